"""Shapes for a machine of 8 bits: other operations, the same integers."""

from __future__ import annotations

import operator
from collections.abc import Callable

from hypothesis import given
from hypothesis import strategies as st

from fuzzyspec.fixed import build
from fuzzyspec.fixed.build import UINT32_MAX
from fuzzyspec.fixed.program import Binary, Compare, CompareOp, Const, Define, Expr, Local, SetOutput
from fuzzyspec.lower.factors import with_short_factors
from fuzzyspec.lower.shapes import IMMEDIATE, cheapest, cycles, operators, plainest, without_constant_of_two


def value(expr: Expr, names: dict[str, int]) -> int:
    """What an expression of non-negatives comes to; every part lies in its interval, and that in 32 bits."""
    match expr:
        case Const(found):
            pass
        case Local(name):
            found = names[name]
        case Binary(op, left, right):
            a, b = value(left, names), value(right, names)
            found = {"+": a + b, "-": a - b, "*": a * b, ">>": a >> b, "<<": a << b}[op]
        case _:
            raise AssertionError(expr)
    assert 0 <= expr.lo <= found <= expr.hi <= UINT32_MAX
    return found


@st.composite
def shifts(draw: st.DrawFn) -> tuple[Expr, dict[str, int]]:
    """A shift of a line, of a product or of something else, and values of its locals."""
    highest = st.integers(1, 65535) | st.sampled_from([1, 32767, 32768, 65535])
    a, b = (Local(name, "uint32", 0, draw(highest)) for name in "ab")
    names = {x.name: draw(st.integers(0, x.hi) | st.just(x.hi)) for x in (a, b)}
    count = draw(st.integers(1, 24))
    short = build.add(a, Const(draw(st.integers(0, 99)))) if draw(st.booleans()) else a
    factor = draw(st.integers(1, UINT32_MAX // short.hi) | st.sampled_from([1, 2, 3, 128, 21845]))
    multiple = Binary("*", short, Const(factor), 0, short.hi * factor)
    last = UINT32_MAX - multiple.hi
    match draw(st.integers(0, 3)):
        case 0:
            inner = build.add(multiple, Const(draw(st.integers(0, max(0, last)))))
        case 1:
            start = multiple.hi + draw(st.integers(0, max(0, last)))
            inner = build.sub_guarded(Const(start), multiple, start)
        case 2:
            product = build.mul(a, b)
            inner = build.add(product, Const(draw(st.integers(0, min(1 << count, UINT32_MAX - product.hi)))))
        case _:
            inner = build.add(build.mul(a, b), build.mul(a, Const(1)))
    if inner.hi > UINT32_MAX:
        inner = a
    return build.shift_right(inner, count), names


@given(shifts())
def test_the_cheapest_shape_is_equal(drawn: tuple[Expr, dict[str, int]]) -> None:
    """Scaled by powers of two, parted or shifted by bytes, the integer is the same, and nothing leaves 32 bits."""
    expr, names = drawn
    assert value(cheapest(expr), names) == value(expr, names)
    assert cycles(cheapest(expr)) <= cycles(expr)
    assert (cheapest(expr).lo, cheapest(expr).hi) == (expr.lo, expr.hi)


@given(shifts())
def test_the_plainest_shape_is_equal(drawn: tuple[Expr, dict[str, int]]) -> None:
    """On any machine a power of two that factor and count share goes, where an operator goes with it."""
    expr, names = drawn
    assert value(plainest(expr), names) == value(expr, names)
    assert operators(plainest(expr)) <= operators(expr)


ORDERS: dict[CompareOp, Callable[[int, int], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


@given(st.integers(0, 32), st.integers(-2, 2), st.sampled_from(sorted(ORDERS)), st.integers(0, UINT32_MAX), st.data())
def test_a_power_of_two_is_asked_for_by_a_shift(
    bits: int, off: int, op: CompareOp, hi: int, data: st.DataObject
) -> None:
    """The outcome is the same on both sides of the bound; where that was a larger power of two, 0 is compared with."""
    bound = min(max(0, 2**bits + off), UINT32_MAX)
    test = Compare(op, Local("a", "uint32", 0, hi), Const(bound))
    found = without_constant_of_two(test)
    assert isinstance(found.right, Const)
    for a in {0, hi, data.draw(st.integers(0, hi)), *(min(max(0, bound + d), hi) for d in (-1, 0, 1))}:
        asked, against = value(found.left, {"a": a}), found.right.value
        told = ORDERS[found.op](asked, against) if found.op in ORDERS else (asked == against) == (found.op == "==")
        assert told == ORDERS[op](a, bound)
    first = bound + (op in ("<=", ">"))
    assert (found != test) == (IMMEDIATE < first <= UINT32_MAX and first & (first - 1) == 0)
    signed = Compare(op, Local("a", "int32", 0, min(hi, 2**31 - 1)), Const(bound))
    assert without_constant_of_two(signed) == signed


def test_long_shifts_and_multipliers_go() -> None:
    """A degree's line with a slope of 17 bits, and a shift by 15: short multiplications, and shifts by bytes."""
    u = Local("u", "uint16", 0, 24575)
    line = build.shift_right(build.add(build.mul(u, Const(87381)), Const(36864)), 16)
    assert cheapest(line) == build.add(u, build.shift_right(build.add(build.mul(u, Const(21845)), Const(36864)), 16))
    third = build.rounded_shift(build.mul(u, Const(21845)), 15)
    assert cheapest(third) == build.rounded_shift(build.mul(u, Const(43690)), 16)
    half = build.shift_right(build.add(build.mul(u, Const(32768)), Const(49152)), 16)
    assert cheapest(half) == plainest(half) == build.shift_right(build.add(u, Const(1)), 1)


def test_a_local_that_only_multiplies_is_held_short() -> None:
    """``drop = d << 8`` becomes ``drop = d``, and its product is shifted; one that is also added stays as it is."""
    d, c = Local("d", "uint16", 0, 32768), Local("c", "uint8", 0, 255)
    wide = build.shift_left(d, 8)
    drop = build.local("drop", wide)
    body = (Define(drop, wide, True), SetOutput("y", build.mul(c, drop)))
    short = Local("drop", drop.ctype, 0, 32768)
    held = with_short_factors(body)
    assert held == (
        Define(short, d, True),
        SetOutput("y", Binary("*", c, Binary("<<", short, Const(8), 0, drop.hi), 0, 255 * drop.hi)),
    )
    (_, output) = held
    assert isinstance(output, SetOutput)
    assert cheapest(output.value) == build.shift_left(build.mul(c, short), 8)
    summed = (Define(drop, wide, True), SetOutput("y", build.add(build.mul(c, drop), drop)))
    assert with_short_factors(summed) == summed
