"""Degrees of membership over exact rationals, with the limits on both sides of a jump."""

from __future__ import annotations

import itertools
from fractions import Fraction
from typing import assert_never

from fuzzyspec.model.controller import Input
from fuzzyspec.model.term import PiecewiseLinear, Shape, Singleton

Side = int
"""-1 for the limit from the left, 0 for the value, 1 for the limit from the right."""


def points(shape: Shape) -> tuple[tuple[Fraction, Fraction], ...]:
    """A shape's corners; a singleton is a jump up and down."""
    match shape:
        case PiecewiseLinear(corners):
            return corners
        case Singleton(at):
            return ((at, Fraction(0)), (at, Fraction(1)), (at, Fraction(0)))
        case _:
            assert_never(shape)


def degree(shape: Shape, x: Fraction, side: Side = 0) -> Fraction:
    """Membership at ``x``, or its limit there from one side; the largest value holds at a jump."""
    corners = points(shape)
    here = [y for at, y in corners if at == x]
    if here:
        return max(here) if side == 0 else here[0] if side < 0 else here[-1]
    if x < corners[0][0]:
        return corners[0][1]
    for (x0, y0), (x1, y1) in itertools.pairwise(corners):
        if x0 < x < x1:
            return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    return corners[-1][1]


def core(variable: Input, term: int) -> Fraction:
    """Where, inside the variable's range, a term is strongest: its peak, or the middle of its plateau."""
    if variable.peaks is not None:
        return variable.peaks[term]
    lo, hi = variable.variable.lo, variable.variable.hi
    shape = variable.terms[term].shape
    places = sorted({lo, hi, *(x for x, _ in points(shape) if lo <= x <= hi)})
    best = max(degree(shape, x) for x in places)
    plateau = [x for x in places if degree(shape, x) == best]
    middle = (plateau[0] + plateau[-1]) / 2
    return middle if degree(shape, middle) == best else plateau[0]
