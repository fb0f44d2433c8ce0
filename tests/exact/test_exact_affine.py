"""Comparisons moved to the signal's own unit."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from fuzzyspec.exact.affine import affine
from fuzzyspec.model.system import Abs, Add, Const, Div, Expr, Let, Mul, Neg, ReadField, ReadInput, ReadLet, Sub
from tests.exact.exact_models import NOWHERE, grid

X, Y, LET = ReadInput("x"), ReadField("items", "y"), ReadLet("l", None)


def _let(read: ReadLet) -> Let:
    return Let(read.name, Sub(X, Const(Fraction(3))), NOWHERE)


def _value(expr: Expr, x: Fraction, y: Fraction) -> Fraction:
    match expr:
        case Const(value):
            return value
        case Add(a, b):
            return _value(a, x, y) + _value(b, x, y)
        case Sub(a, b):
            return _value(a, x, y) - _value(b, x, y)
        case Mul(a, b):
            return _value(a, x, y) * _value(b, x, y)
        case Div(a, b):
            return _value(a, x, y) / _value(b, x, y)
        case Neg(a):
            return -_value(a, x, y)
        case ReadLet():
            return x - 3
        case _:
            return x if expr == X else y


def _grown(inner: st.SearchStrategy[Expr]) -> st.SearchStrategy[Expr]:
    ratio = st.builds(lambda n, d: Div(n, Const(d), None, None, "k", NOWHERE), inner, grid(1, 4, 1))
    pairs = [st.builds(node, inner, inner) for node in (Add, Sub, Mul)]
    return st.one_of(ratio, st.builds(Neg, inner), *pairs)


linear = st.recursive(st.one_of(st.sampled_from([X, Y, LET]), grid(-4, 4, 1).map(Const)), _grown, max_leaves=6)


@given(linear, grid(-4, 4, 4), grid(-4, 4, 4))
def test_affine_is_the_same_function(expr: Expr, x: Fraction, y: Fraction) -> None:
    """What is called affine in one signal has that value, whatever the other signals are."""
    found = affine(expr, _let)
    if found is not None:
        read = x if found.read == X else y
        assert (found.read is None) == (found.slope == 0)
        assert found.slope * read + found.offset == _value(expr, x, y)


def test_affine_finds_one_signal() -> None:
    """A multiple of one signal plus a constant is found through lets; two signals, products and kinks are not."""
    two = Const(Fraction(2))
    found = affine(Div(Add(Mul(two, LET), X), Const(Fraction(-4)), None, None, "k", NOWHERE), _let)
    assert found is not None
    assert (found.read, found.slope, found.offset) == (X, Fraction(-3, 4), Fraction(3, 2))
    assert affine(Sub(X, X), _let) is not None
    for other in (Add(X, Y), Mul(X, X), Abs(X), Div(two, X, None, None, "k", NOWHERE)):
        assert affine(other, _let) is None
