"""The interval of an expression holds every value that it can have."""

from __future__ import annotations

from fractions import Fraction
from typing import assert_never

from hypothesis import given
from hypothesis import strategies as st

from fuzzyspec.check.variables import default_raw
from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.model.interval import Intervals, interval, quotient, saturated
from fuzzyspec.model.system import (
    Abs,
    Add,
    CallOutput,
    Clamp,
    Compare,
    Const,
    Div,
    Expr,
    Fold,
    Greatest,
    If,
    Least,
    Let,
    ListInput,
    Mul,
    Neg,
    ReadField,
    ReadInput,
    ReadLet,
    Sub,
    System,
)
from fuzzyspec.model.units import ONE, Unit
from fuzzyspec.model.variable import Variable

NOWHERE = Span(0, 0)
NUMBERS = st.fractions(-8, 8, max_denominator=6)


def variable(name: str, lo: int, hi: int, unit: Unit = ONE) -> Variable:
    """A variable in its default raw."""
    ends = Fraction(lo), Fraction(hi)
    return Variable(name, *ends, unit, default_raw(*ends), NOWHERE)


INPUTS = (variable("a", -3, 5), variable("b", 1, 4), variable("c", -6, -2, Unit("mm", (("m", 1),), Fraction(1, 10))))
FIELDS = (variable("d", 0, 8), variable("e", -1, 1))
LEAVES: st.SearchStrategy[Expr] = NUMBERS.map(Const) | st.sampled_from([ReadInput(v.name) for v in INPUTS])


def compound(parts: st.SearchStrategy[Expr]) -> st.SearchStrategy[Expr]:
    """One more level on top of smaller expressions."""
    pairs = st.tuples(parts, parts)
    return st.one_of(
        pairs.map(lambda p: Add(*p)),
        pairs.map(lambda p: Sub(*p)),
        pairs.map(lambda p: Mul(*p)),
        parts.map(lambda x: Mul(x, x)),
        parts.map(Neg),
        parts.map(Abs),
        pairs.map(Least),
        pairs.map(Greatest),
        st.tuples(parts, NUMBERS, NUMBERS).map(lambda t: Clamp(t[0], min(t[1:]), max(t[1:]))),
        st.tuples(parts, parts, parts).map(lambda t: If(Compare("<", t[0], t[1], "k", NOWHERE), t[1], t[2])),
        parts.map(lambda x: Div(x, ReadInput("b"), None, None, "k", NOWHERE)),
    )


EXPRS = st.recursive(LEAVES, compound, max_leaves=8)
VALUES = st.fixed_dictionaries(
    {v.name: st.fractions(v.unit.to_coherent(v.lo), v.unit.to_coherent(v.hi), max_denominator=9) for v in INPUTS}
)


def value_of(expr: Expr, at: dict[str, Fraction]) -> Fraction:
    """The value of an expression without lists, from the definitions."""

    def of(e: Expr) -> Fraction:
        return value_of(e, at)

    match expr:
        case Const(value):
            return value
        case ReadInput(name):
            return at[name]
        case Add(left, right):
            return of(left) + of(right)
        case Sub(left, right):
            return of(left) - of(right)
        case Mul(left, right):
            return of(left) * of(right)
        case Neg(operand):
            return -of(operand)
        case Abs(operand):
            return abs(of(operand))
        case Least(operands):
            return min(map(of, operands))
        case Greatest(operands):
            return max(map(of, operands))
        case Clamp(operand, lo, hi):
            return sorted((lo, of(operand), hi))[1]
        case If(Compare(left=left, right=right), then, other):
            return of(then) if of(left) < of(right) else of(other)
        case Div(left, right):
            return of(left) / of(right)
        case If() | Fold() | ReadField() | ReadLet() | CallOutput():
            raise NotImplementedError
        case _:
            assert_never(expr)


@given(EXPRS, EXPRS, VALUES)
def test_intervals_hold_every_value(first: Expr, then: Expr, at: dict[str, Fraction]) -> None:
    """Of an expression, and of one that reads it through a `let`."""
    both = Add(ReadLet("x", None), then)
    system = System("s", INPUTS, (Let("x", first, NOWHERE),), (), NOWHERE)
    lo, hi = interval(first, system)
    assert lo <= value_of(first, at) <= hi
    lo, hi = interval(both, system)
    assert lo <= value_of(first, at) + value_of(then, at) <= hi


RANGE = st.tuples(NUMBERS, NUMBERS).map(lambda t: (min(t), max(t)))


@given(RANGE, st.fractions(Fraction(1, 4), 9), st.fractions(0, 1), st.fractions(0, 1), st.booleans(), RANGE)
def test_quotients_saturate(
    n: tuple[Fraction, Fraction], d: Fraction, t: Fraction, u: Fraction, negative: bool, into: tuple[Fraction, Fraction]
) -> None:
    """A divisor whose range ends at 0: the saturated interval holds every saturated quotient."""
    divisor = (-d, Fraction(0)) if negative else (Fraction(0), d)
    lo, hi = saturated(*quotient(n, divisor), into)
    x, y = n[0] + (n[1] - n[0]) * t, divisor[0] + d * u
    if y != 0:
        assert lo <= sorted((into[0], x / y, into[1]))[1] <= hi
    elif x != 0:
        assert (into[1] if (x > 0) != negative else into[0]) in (lo, hi)


def test_lists_and_folds() -> None:
    """Sums grow with the capacity, counts go up to it, a maximum can be what it is otherwise."""
    known = Intervals()
    known.add_input(ListInput("l", 5, FIELDS, NOWHERE))
    d, e = ReadField("l", "d"), ReadField("l", "e")
    assert known.of(Fold("sum", "l", d, None, None)) == (0, 40)
    assert known.of(Fold("sum", "l", Add(d, Const(Fraction(2))), None, None)) == (0, 50)
    assert known.of(Fold("sum", "l", e, None, None)) == (-5, 5)
    assert known.of(Fold("count", "l", None, None, None)) == (0, 5)
    assert known.of(Fold("max", "l", e, None, Const(Fraction(9)))) == (-1, 9)
