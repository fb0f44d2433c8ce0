"""Tests that the intervals decide."""

from __future__ import annotations

from hypothesis import example, given
from hypothesis import strategies as st

from fuzzyspec.fixed.decide import decided, settle_test
from fuzzyspec.fixed.program import AllOf, AnyOf, Compare, CompareOp, Const, Local, NotTest, Test

X = Local("x", "uint8", 0, 9)
OPERATORS: list[CompareOp] = ["<", "<=", ">", ">=", "==", "!="]


def holds(test: Test, x: int) -> bool:
    """What the test says at a value of x."""
    match test:
        case Compare(op, left, right):
            a, b = (s.value if isinstance(s, Const) else x for s in (left, right))
            return {"<": a < b, "<=": a <= b, ">": a > b, ">=": a >= b, "==": a == b, "!=": a != b}[op]
        case AllOf(operands):
            return all(holds(t, x) for t in operands)
        case AnyOf(operands):
            return any(holds(t, x) for t in operands)
        case NotTest(operand):
            return not holds(operand, x)


def compares() -> st.SearchStrategy[Test]:
    """Comparisons of x with constants, which stand on either side."""
    constants = st.integers(0, 9).map(Const)
    operators = st.sampled_from(OPERATORS)
    return st.builds(Compare, operators, st.just(X), constants) | st.builds(Compare, operators, constants, st.just(X))


def joined(inner: st.SearchStrategy[Test]) -> st.SearchStrategy[Test]:
    """Several tests joined, or one denied."""
    several = st.lists(inner, min_size=2, max_size=3).map(tuple)
    return several.map(AllOf) | several.map(AnyOf) | inner.map(NotTest)


@given(st.recursive(compares(), joined, max_leaves=6))
def test_what_is_decided_is_so_everywhere(test: Test) -> None:
    """A decided test has its outcome at every value, and what is left of another one is equal to it."""
    outcomes = {holds(test, x) for x in range(10)}
    outcome = decided(test)
    assert outcome is None or outcomes == {outcome}
    left = settle_test(test)
    assert all(holds(left, x) == holds(test, x) for x in range(10))


@example(Compare("!=", X, Const(5)), Compare("==", X, Const(5)))
@given(compares(), compares())
def test_two_comparisons_that_exclude_each_other_are_seen(a: Test, b: Test) -> None:
    """What clang warns of is known here: two comparisons never both true, or always one of them."""
    outcomes = {holds(AllOf((a, b)), x) for x in range(10)}
    if outcomes == {False}:
        assert decided(AllOf((a, b))) is False
    if {holds(AnyOf((a, b)), x) for x in range(10)} == {True}:
        assert decided(AnyOf((a, b))) is True
