"""Terms: piecewise-linear membership functions and singletons, in the variable's unit."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.diagnostics.diagnostic import Span


@dataclass(frozen=True, slots=True)
class PiecewiseLinear:
    """Membership through ``points`` (x non-decreasing, y in [0, 1]); constant beyond both ends.

    Two (or more) points with one x make a jump, where the largest of their values holds. Triangle (a, b, c) is
    ``(a, 0) (b, 1) (c, 0)``; a shouldered end term is constant 1 beyond its peak.
    """

    points: tuple[tuple[Fraction, Fraction], ...]


@dataclass(frozen=True, slots=True)
class Singleton:
    """1 at ``at``, 0 elsewhere."""

    at: Fraction


Shape = PiecewiseLinear | Singleton


@dataclass(frozen=True, slots=True)
class Term:
    name: str
    shape: Shape
    span: Span
