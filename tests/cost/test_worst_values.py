"""Sets of words: whatever the words are, the result of an operation on them is in the set that is told."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from fuzzyspec.cost.worst.values import (
    Operator,
    Value,
    between,
    join,
    may_equal,
    operate,
    signed,
    unsigned,
    within,
    within_signed,
    without,
)

BITS = 8
TOP = (1 << BITS) - 1
OPERATORS: tuple[Operator, ...] = ("+", "-", "*", "&", "|", "^", "<<", ">>", "asr", "/", "%", "?")
SETS = st.builds(
    lambda lo, step, count: between(lo, lo + step * count, step, BITS),
    st.integers(0, TOP),
    st.integers(1, 64),
    st.integers(0, 40),
)


def words(value: Value) -> set[int]:
    """All of a set."""
    return {w & TOP for w in range(value.lo, value.hi + 1, value.step or 1)}


def number(word: int) -> int:
    """A word in two's complement."""
    return word - (TOP + 1) if word >> (BITS - 1) else word


def computed(operator: Operator, a: int, b: int) -> int | None:
    """What a machine computes; None where machines differ."""
    match operator:
        case "+":
            return a + b
        case "-":
            return a - b
        case "*":
            return a * b
        case "&":
            return a & b
        case "|":
            return a | b
        case "^":
            return a ^ b
        case "<<":
            return a << b
        case ">>":
            return a >> b
        case "asr":
            return number(a) >> b
        case "/":
            return a // b if b else None
        case "%":
            return a % b if b else None
        case _:
            return a


@given(st.sampled_from(OPERATORS), SETS, SETS, st.data())
def test_every_result_is_in_the_set_of_results(operator: Operator, a: Value, b: Value, data: st.DataObject) -> None:
    """For any words of two sets."""
    x, y = data.draw(st.sampled_from(sorted(words(a)))), data.draw(st.sampled_from(sorted(words(b))))
    result = computed(operator, x, y)
    if result is not None:
        assert result & TOP in words(operate(operator, a, b, BITS))


@given(SETS, SETS)
def test_a_join_holds_both(a: Value, b: Value) -> None:
    """No word of either is lost."""
    assert words(a) | words(b) <= words(join(a, b, BITS))


@given(SETS, SETS)
def test_sets_that_share_a_word_may_be_equal(a: Value, b: Value) -> None:
    """Where it is said that they cannot, they do not."""
    assert may_equal(a, b, BITS) or not words(a) & words(b)


@given(SETS)
def test_the_ends_are_the_ends(value: Value) -> None:
    """Read without sign and with it."""
    lo, hi = unsigned(value, BITS)
    assert all(lo <= w <= hi for w in words(value))
    low, high = signed(value, BITS)
    assert all(low <= number(w) <= high for w in words(value))


@given(SETS, st.integers(0, TOP), st.integers(0, TOP))
def test_a_part_keeps_every_word_that_fits(value: Value, one: int, other: int) -> None:
    """Between two bounds, and without a word, nothing that belongs to the part is lost."""
    lo, hi = sorted((one, other))
    part = within(value, lo, hi, BITS)
    assert {w for w in words(value) if lo <= w <= hi} <= (set() if part is None else words(part))
    low, high = sorted((number(one), number(other)))
    part = within_signed(value, low, high, BITS)
    assert {w for w in words(value) if low <= number(w) <= high} <= (set() if part is None else words(part))
    rest = without(value, one, BITS)
    assert words(value) - {one} <= (set() if rest is None else words(rest))
