"""Comparisons of one read signal with a constant, moved to where they are exact.

``2 * x + 1 mm < 4 mm`` says the same of x as ``x < 1.5 mm``. Both meanings decide that alike at every raw, so the float
one must not lose it to the rounding of a conversion: a raw's value and the literal are compared in the signal's own
unit, where each is rounded once and equal rationals are equal floats.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.model.system import Add, Const, Div, Expr, Let, Mul, Neg, ReadField, ReadInput, ReadLet, Sub

Lets = Callable[[ReadLet], Let]


@dataclass(frozen=True, slots=True)
class Affine:
    """``slope * read + offset``, in coherent units; ``read`` None for a constant."""

    read: ReadInput | ReadField | None
    slope: Fraction
    offset: Fraction


def affine(expr: Expr, lets: Lets) -> Affine | None:
    """An expression as a multiple of one signal plus a constant; None where it is something else."""
    match expr:
        case Const(value):
            return Affine(None, Fraction(0), value)
        case ReadInput() | ReadField():
            return Affine(expr, Fraction(1), Fraction(0))
        case ReadLet():
            return affine(lets(expr).value, lets)
        case Neg(operand):
            return _scaled(affine(operand, lets), Fraction(-1))
        case Add(left, right):
            return _sum(affine(left, lets), affine(right, lets))
        case Sub(left, right):
            return _sum(affine(left, lets), _scaled(affine(right, lets), Fraction(-1)))
        case Mul(left, right):
            a, b = affine(left, lets), affine(right, lets)
            if a is not None and a.read is None:
                return _scaled(b, a.offset)
            return _scaled(a, b.offset) if b is not None and b.read is None else None
        case Div(left, right, None):
            b = affine(right, lets)
            return _scaled(affine(left, lets), 1 / b.offset) if b is not None and b.read is None and b.offset else None
        case _:
            return None


def _scaled(a: Affine | None, by: Fraction) -> Affine | None:
    return None if a is None else Affine(a.read if by else None, a.slope * by, a.offset * by)


def _sum(a: Affine | None, b: Affine | None) -> Affine | None:
    if a is None or b is None or (a.read is not None and b.read is not None and a.read != b.read):
        return None
    slope = a.slope + b.slope
    return Affine((a.read or b.read) if slope else None, slope, a.offset + b.offset)
