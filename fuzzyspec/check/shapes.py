"""Term shapes: their arguments to piecewise-linear memberships and singletons."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

from fuzzyspec.model.term import PiecewiseLinear, Shape, Singleton

Points = tuple[tuple[Fraction, Fraction], ...]

ARGUMENTS: dict[str, str] = {
    "triangle": "triangle(a, b, c)",
    "trapezoid": "trapezoid(a, b, c, d)",
    "ramp_up": "ramp_up(a, b)",
    "ramp_down": "ramp_down(a, b)",
    "points": "points((x, y), (x, y), ..)",
    "singleton": "singleton(a)",
}
"""The shapes that a ``term`` can have, and how each is written."""

COUNTS: dict[str, int] = {"triangle": 3, "trapezoid": 4, "ramp_up": 2, "ramp_down": 2, "singleton": 1}

LATER = ("gaussian", "bell", "sigmoid", "z", "s", "pi")
"""Smooth shapes: known in the field, not yet here."""

ZERO, ONE = Fraction(0), Fraction(1)


def in_order(shape: str, args: Sequence[Fraction]) -> bool:
    """Whether the corners of a triangle, trapezoid or ramp are in order and not all in one place."""
    rising = all(a <= b for a, b in pairwise(args))
    return rising and (shape == "singleton" or args[0] < args[-1])


def shaped(shape: str, args: Sequence[Fraction]) -> Shape:
    """The membership of a shape whose corners are in order (not of ``points``)."""
    heights = {
        "triangle": (ZERO, ONE, ZERO),
        "trapezoid": (ZERO, ONE, ONE, ZERO),
        "ramp_up": (ZERO, ONE),
        "ramp_down": (ONE, ZERO),
    }
    if shape == "singleton":
        return Singleton(args[0])
    return PiecewiseLinear(tuple(zip(args, heights[shape], strict=True)))


def even_peaks(lo: Fraction, hi: Fraction, n: int) -> tuple[Fraction, ...]:
    """``n >= 2`` peaks from the low to the high end, evenly spaced."""
    return tuple(lo + k * (hi - lo) / (n - 1) for k in range(n))


def partition(peaks: Sequence[Fraction], full: bool) -> tuple[PiecewiseLinear, ...]:
    """A strong partition by triangles, the ends shouldered; or, ``full``, with the inner half mirrored outwards."""
    first, last = 0, len(peaks) - 1
    shapes: list[PiecewiseLinear] = []
    for k, p in enumerate(peaks):
        points: list[tuple[Fraction, Fraction]] = []
        if k > first:
            points.append((peaks[k - 1], ZERO))
        elif full:
            points.append((2 * p - peaks[k + 1], ZERO))
        points.append((p, ONE))
        if k < last:
            points.append((peaks[k + 1], ZERO))
        elif full:
            points.append((2 * p - peaks[k - 1], ZERO))
        shapes.append(PiecewiseLinear(tuple(points)))
    return tuple(shapes)


def segments(points: Points) -> list[tuple[Fraction, Fraction, Fraction, Fraction]]:
    """The sloping or level pieces ``(x0, y0, x1, y1)`` with ``x0 < x1``; jumps have none."""
    return [(x0, y0, x1, y1) for (x0, y0), (x1, y1) in pairwise(points) if x0 < x1]


def degree(points: Points, x: Fraction) -> Fraction:
    """Membership at ``x``; at a jump the larger value."""
    here = [y for px, y in points if px == x]
    if x <= points[0][0]:
        return max(here) if here else points[0][1]
    if x >= points[-1][0]:
        return max(here) if here else points[-1][1]
    if here:
        return max(here)
    x0, y0, x1, y1 = next(s for s in segments(points) if s[0] < x < s[2])
    return y0 + (y1 - y0) * (x - x0) / (x1 - x0)


def reaches(points: Points, lo: Fraction, hi: Fraction) -> bool:
    """Whether the membership is above 0 anywhere in ``[lo, hi]``."""
    corners = [x for x, _ in points if lo <= x <= hi]
    return any(degree(points, x) > 0 for x in (lo, hi, *corners))


def has_area(points: Points, lo: Fraction, hi: Fraction) -> bool:
    """Whether the membership is above 0 on a stretch of ``[lo, hi]``, not only at single points."""
    cuts = sorted({lo, hi, *(x for x, _ in points if lo < x < hi)})
    return any(degree(points, (a + b) / 2) > 0 for a, b in pairwise(cuts))


def first_gap(terms: Sequence[Points], lo: Fraction, hi: Fraction) -> tuple[Fraction, Fraction] | None:
    """The first stretch of ``[lo, hi]`` (perhaps a single point) on which every membership is 0."""
    cuts = sorted({lo, hi, *(x for points in terms for x, _ in points if lo < x < hi)})
    blank_points = [x for x in cuts if all(degree(p, x) == 0 for p in terms)]
    blanks = [(a, b) for a, b in pairwise(cuts) if all(degree(p, (a + b) / 2) == 0 for p in terms)]
    if not blanks and not blank_points:
        return None
    start = min([a for a, _ in blanks] + blank_points)
    end = start
    while (longer := next((b for a, b in blanks if a == end), None)) is not None:
        end = longer
    return start, end
