"""The constructors: intervals hold, folding changes no value, and what could leave 32 bits is refused."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from fuzzyspec.fixed import build
from fuzzyspec.fixed.build import INT32_MAX, INT32_MIN, UINT32_MAX, RangeError
from fuzzyspec.fixed.program import Binary, Const, Expr, Local
from tests.fixed.fixed_values import Operand, computed, numbers, operands

Two = Callable[[Expr, Expr], Expr]
Meaning = Callable[[int, int], int]

ARITHMETIC: dict[str, tuple[Two, Meaning]] = {
    "add": (build.add, lambda a, b: a + b),
    "sub": (build.sub, lambda a, b: a - b),
    "mul": (build.mul, lambda a, b: a * b),
}
CHOICES: dict[str, tuple[Two, Meaning]] = {
    "least": (build.least, min),
    "greatest": (build.greatest, max),
    "above": (build.above, lambda a, b: max(a - b, 0)),
}
COMPARISONS: dict[str, Callable[[int, int], bool]] = {
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
}


def one_type(*values: int) -> bool:
    """Whether uint32_t or int32_t holds all of them."""
    return (min(values) >= 0 and max(values) <= UINT32_MAX) or (min(values) >= INT32_MIN and max(values) <= INT32_MAX)


def agrees(node: Expr, meaning: Meaning, left: Operand, right: Operand) -> None:
    """The node's value is the meaning's for every pair of values, and inside its interval."""
    expected = [meaning(a, b) for a, b in itertools.product(left.values, right.values)]
    assert computed(node, left, right) == expected
    assert node.lo <= min(expected) and max(expected) <= node.hi


def corners(meaning: Meaning, left: Expr, right: Expr) -> list[int]:
    """The meaning at the corners of both intervals, where sums, differences and products are extreme."""
    return [meaning(a, b) for a in (left.lo, left.hi) for b in (right.lo, right.hi)]


@pytest.mark.parametrize("name", ARITHMETIC)
@given(left=operands("a"), right=operands("b"))
@example(Operand(Local("a", "uint32", 0, UINT32_MAX), (0, UINT32_MAX)), Operand(Const(-1), (-1,)))
@example(Operand(Const(-5), (-5,)), Operand(Local("b", "uint32", 5, UINT32_MAX), (5, UINT32_MAX)))
@example(Operand(Const(2**31), (2**31,)), Operand(Const(UINT32_MAX), (UINT32_MAX,)))
@example(Operand(Const(UINT32_MAX), (UINT32_MAX,)), Operand(Const(UINT32_MAX), (UINT32_MAX,)))
def test_arithmetic_has_the_tightest_interval_or_is_refused(name: str, left: Operand, right: Operand) -> None:
    """Sums, differences, products get exactly the interval of their values, or a RangeError where no type holds it."""
    constructor, meaning = ARITHMETIC[name]
    extremes = corners(meaning, left.expr, right.expr)
    try:
        node = constructor(left.expr, right.expr)
    except RangeError:
        ends = (left.expr.lo, left.expr.hi, right.expr.lo, right.expr.hi)
        assert not one_type(*ends, min(extremes), max(extremes))
        return
    assert (node.lo, node.hi) == (min(extremes), max(extremes))
    if isinstance(node, Binary):
        assert one_type(node.left.lo, node.left.hi, node.right.lo, node.right.hi, node.lo, node.hi)
    agrees(node, meaning, left, right)


@pytest.mark.parametrize("name", CHOICES)
@given(left=operands("a"), right=operands("b"))
def test_choices_have_the_tightest_interval_or_are_refused(name: str, left: Operand, right: Operand) -> None:
    """min, max and guarded differences too; they are refused only where their two operands share no type."""
    constructor, meaning = CHOICES[name]
    extremes = corners(meaning, left.expr, right.expr)
    try:
        node = constructor(left.expr, right.expr)
    except RangeError:
        assert not one_type(left.expr.lo, left.expr.hi, right.expr.lo, right.expr.hi, *extremes)
        return
    assert (node.lo, node.hi) == (min(extremes), max(extremes))
    agrees(node, meaning, left, right)


@given(left=operands("a"), right=operands("b"))
def test_division_refuses_negatives_and_zero(left: Operand, right: Operand) -> None:
    """Floor division takes non-negatives by positives only, and powers of two become shifts of the same value."""
    sound = left.expr.lo >= 0 and right.expr.lo >= 1
    if not sound:
        with pytest.raises(RangeError):
            build.floor_div(left.expr, right.expr)
        return
    node = build.floor_div(left.expr, right.expr)
    assert (node.lo, node.hi) == (left.expr.lo // right.expr.hi, left.expr.hi // right.expr.lo)
    agrees(node, lambda a, b: a // b, left, right)


@given(divisor=st.integers(2, 5000) | st.integers(2, 2**20), hi=st.integers(0, 2**21) | numbers(0, UINT32_MAX))
def test_division_by_a_constant_is_a_product_where_it_can_be(divisor: int, hi: int) -> None:
    """Exact where it is hardest: just below, at and above the multiples, the largest among them; and it is no division
    for all that 15 bits hold."""
    x = Local("x", "uint32", 0, hi)
    multiples = {q * divisor for q in (0, 1, 2, hi // divisor // 2, hi // divisor - 1, hi // divisor)}
    values = tuple(v for m in sorted(multiples) for v in (m - 1, m, m + 1) if 0 <= v <= hi)
    node = build.floor_div(x, Const(divisor))
    agrees(node, lambda a, b: a // b, Operand(x, (*values, hi)), Operand(Const(divisor), (divisor,)))
    if hi < 2**15 and divisor < 2**15:
        assert not (isinstance(node, Binary) and node.op == "/")


@given(left=operands("a"), count=st.integers(-1, 33))
@example(left=Operand(Const(0), (0,)), count=32)
def test_shifts_lose_nothing_to_the_left(left: Operand, count: int) -> None:
    """A left shift that could push a bit out of 32 is refused, and so is any shift of a negative or by 32 and more."""
    right = Operand(Const(count), (count,))
    if left.expr.lo < 0 or not 0 <= count < 32:
        for constructor in (build.shift_left, build.shift_right):
            with pytest.raises(RangeError):
                constructor(left.expr, count)
        return
    agrees(build.shift_right(left.expr, count), lambda a, b: a >> b, left, right)
    if left.expr.hi << count > UINT32_MAX:
        with pytest.raises(RangeError):
            build.shift_left(left.expr, count)
    else:
        agrees(build.shift_left(left.expr, count), lambda a, b: a << b, left, right)


@given(left=operands("a", 0), count=st.integers(0, 31))
def test_a_rounded_shift_rounds_ties_up(left: Operand, count: int) -> None:
    """``rounded_shift`` is the integer nearest to the quotient, the upper of two; refused where the half overflows."""
    half = (1 << count) >> 1
    if left.expr.hi + half > UINT32_MAX:
        with pytest.raises(RangeError):
            build.rounded_shift(left.expr, count)
        return
    node = build.rounded_shift(left.expr, count)
    agrees(node, lambda a, b: (2 * a + (1 << b)) // (2 << b), left, Operand(Const(count), (count,)))


@given(left=operands("a", 0), right=operands("b", 0, 65537))
def test_mul_high_is_the_high_part_of_the_product(left: Operand, right: Operand) -> None:
    """``mul_high`` is ``floor(a b / 2**16)`` over its whole domain and refuses multipliers above 2**16."""
    if right.expr.hi > 65536:
        with pytest.raises(RangeError):
            build.mul_high(left.expr, right.expr)
        return
    agrees(build.mul_high(left.expr, right.expr), lambda a, b: a * b // 65536, left, right)


def ratio(num: int, den: int) -> int:
    """What the quotient kernel promises, word by word."""
    return num * 65536 // den if num < den else 65536


@given(left=operands("a", 0), right=operands("b", 0, 2**31))
def test_quotient_is_a_16_bit_fraction_capped_at_1(left: Operand, right: Operand) -> None:
    """``quotient`` floors ``2**16 a / b`` for a < b, is 65536 from a = b up and for b = 0, and refuses b >= 2**31."""
    if right.expr.hi >= 2**31:
        with pytest.raises(RangeError):
            build.quotient(left.expr, right.expr)
        return
    agrees(build.quotient(left.expr, right.expr), ratio, left, right)


@given(left=operands("a"), right=operands("b"))
def test_a_negative_operand_of_a_kernel_is_refused(left: Operand, right: Operand) -> None:
    """Both kernels are unsigned."""
    assume(left.expr.lo < 0 or right.expr.lo < 0)
    for kernel in (build.mul_high, build.quotient):
        with pytest.raises(RangeError):
            kernel(left.expr, right.expr)


@given(op=st.sampled_from(sorted(COMPARISONS)), ends=st.lists(st.integers(-4, 4), min_size=4, max_size=4))
def test_always_knows_what_intervals_decide(op: str, ends: list[int]) -> None:
    """``always`` says True or False exactly where every pair of values gives that, and None where both occur."""
    a, b = sorted(ends[:2]), sorted(ends[2:])
    left, right = Local("a", "int32", *a), Local("b", "int32", *b)
    seen = {COMPARISONS[op](x, y) for x in range(a[0], a[1] + 1) for y in range(b[0], b[1] + 1)}
    assert build.always(build.compare(op, left, right)) == (seen.pop() if len(seen) == 1 else None)


@given(op=st.sampled_from(sorted(COMPARISONS)), left=operands("a"), right=operands("b"))
def test_a_comparison_takes_one_type(op: str, left: Operand, right: Operand) -> None:
    """Comparisons are refused exactly where their two sides share no type; what is chosen by one follows it."""
    if not one_type(left.expr.lo, left.expr.hi, right.expr.lo, right.expr.hi):
        with pytest.raises(RangeError):
            build.compare(op, left.expr, right.expr)
        return
    node = build.select(build.compare(op, left.expr, right.expr), left.expr, right.expr)
    agrees(node, lambda a, b: a if COMPARISONS[op](a, b) else b, left, right)


@given(value=numbers(), width=st.integers(0, 2**17))
def test_the_smallest_type_is_the_smallest(value: int, width: int) -> None:
    """``smallest_type`` holds the interval, and no narrower type of its signedness does."""
    lo, hi = value, value + width
    if not one_type(lo, hi):
        with pytest.raises(RangeError):
            build.smallest_type(lo, hi)
        return
    ctype = build.smallest_type(lo, hi)
    low, high = build.LIMITS[ctype]
    assert low <= lo and hi <= high
    assert ctype.startswith("u") == (lo >= 0)
    bits = int(ctype.strip("uint"))
    narrower = f"{ctype[: -len(str(bits))]}{bits // 2}"
    assert bits == 8 or not (build.LIMITS[narrower][0] <= lo and hi <= build.LIMITS[narrower][1])


def test_min_and_max_want_atoms() -> None:
    """C names the operands of min, max and guarded differences twice, so compound ones are a programming error."""
    a, b = Local("a", "uint8", 0, 9), Local("b", "uint8", 0, 9)
    for constructor in (build.least, build.greatest, build.above):
        with pytest.raises(TypeError):
            constructor(build.add(a, b), a)


@given(left=operands("a", 0), right=operands("b", 0), data=st.data())
def test_a_guarded_difference_keeps_the_guards_interval(left: Operand, right: Operand, data: st.DataObject) -> None:
    """``sub_guarded`` claims ``0 .. hi`` as its caller proved, and computes the plain difference."""
    hi = data.draw(st.integers(0, UINT32_MAX))
    node = build.sub_guarded(left.expr, right.expr, hi)
    assert node.lo >= 0 and (node.hi <= hi or isinstance(node, Const))
    for a, b in itertools.product(left.values, right.values):
        if 0 <= a - b <= hi:
            single = computed(node, Operand(left.expr, (a,)), Operand(right.expr, (b,)))
            assert single == [a - b]


@given(left=operands("a", 0), hi=st.integers(0, UINT32_MAX))
def test_nothing_is_added_where_one_side_is_0(left: Operand, hi: int) -> None:
    """A sum that begins with 0 is what is added to it, in the interval that its caller proved."""
    for node in (build.add_bounded(Const(0), left.expr, hi), build.add_bounded(left.expr, Const(0), hi)):
        assert type(node) is type(left.expr)
        assert isinstance(node, Const) or (node.lo, node.hi) == (left.expr.lo, min(left.expr.hi, hi))
