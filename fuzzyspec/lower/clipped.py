"""Closed forms of clipped sets: area and moment as polynomials of the clip height alone.

For a set S of terms with common support let ``h = min of their memberships``. The set clipped at c has the area
``F(c) = integral of min(h, c)`` and, about a reference r, the moment ``H(c) = integral of (t - r) min(h, c)``.
Their derivatives
are the width and first moment of the level set ``{h > c}``, which for piecewise-linear terms are a piecewise linear and
a piecewise quadratic polynomial of c: so F is piecewise quadratic and H piecewise cubic. The union of all clipped
terms is
the sum over S of ``(-1)**(|S|+1)`` times these (inclusion-exclusion), each S clipped at the smallest of its heights.

Positions t are relative to the output's range: 0 at its low end, 1 at its high end.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise

from fuzzyspec.model.controller import Output
from fuzzyspec.model.term import PiecewiseLinear

MAX_SETS = 64
"""Sets with common support that one output may have."""

Segment = tuple[Fraction, Fraction, Fraction, Fraction]
"""A straight piece of a membership: t from, t to, its limits at both."""


class TooManySets(Exception):
    """More than :data:`MAX_SETS` sets of terms share support."""


@dataclass(frozen=True, slots=True)
class Piece:
    """On ``start <= c <= end`` the coefficients of the width (linear) and first moment about r (quadratic), by
    powers of c.

    ``area`` and ``moment`` are F and H at ``start``.
    """

    start: Fraction
    end: Fraction
    width: tuple[Fraction, Fraction]
    first: tuple[Fraction, Fraction, Fraction]
    area: Fraction
    moment: Fraction


@dataclass(frozen=True, slots=True)
class ClippedSet:
    """One set of terms. ``moment_sign`` is the sign that H enters with (H itself is kept >= 0), 0 where H vanishes."""

    members: tuple[int, ...]
    sign: int
    reference: Fraction
    moment_sign: int
    pieces: tuple[Piece, ...]

    @property
    def height(self) -> Fraction:
        return self.pieces[-1].end

    @property
    def full_area(self) -> Fraction:
        last = self.pieces[-1]
        return last.area + _integral(last.width, last.start, last.end)


@lru_cache(maxsize=256)
def clipped_sets(output: Output) -> tuple[ClippedSet, ...]:
    """Every set of terms with common support, singles first, then by size and members. Raises TooManySets."""
    shapes = [_segments(output, k) for k in range(len(output.terms))]
    found: list[ClippedSet] = []
    layer: list[tuple[tuple[int, ...], tuple[Segment, ...]]] = [((k,), s) for k, s in enumerate(shapes)]
    while layer:
        following: list[tuple[tuple[int, ...], tuple[Segment, ...]]] = []
        for members, segments in layer:
            if not any(max(s[2], s[3]) > 0 for s in segments):
                continue
            found.append(_clipped(members, segments))
            if len(found) > MAX_SETS:
                raise TooManySets
            for k in range(members[-1] + 1, len(shapes)):
                meet = minimum(segments, shapes[k])
                if any(max(s[2], s[3]) > 0 for s in meet):
                    following.append(((*members, k), meet))
        layer = following
    return tuple(found)


def _segments(output: Output, k: int) -> tuple[Segment, ...]:
    """Term k over the output's domain of integration, in relative positions."""
    shape = output.terms[k].shape
    assert isinstance(shape, PiecewiseLinear)
    lo, span = output.variable.lo, output.variable.hi - output.variable.lo
    left, right = (output.integrate_lo - lo) / span, (output.integrate_hi - lo) / span
    points = [((x - lo) / span, y) for x, y in shape.points]
    chain = [(min(left, points[0][0]) - 1, points[0][1]), *points, (max(right, points[-1][0]) + 1, points[-1][1])]
    pieces: list[Segment] = []
    for (x0, y0), (x1, y1) in pairwise(chain):
        a, b = max(x0, left), min(x1, right)
        if a < b:
            slope = (y1 - y0) / (x1 - x0)
            pieces.append((a, b, y0 + slope * (a - x0), y0 + slope * (b - x0)))
    return tuple(pieces)


def minimum(one: tuple[Segment, ...], two: tuple[Segment, ...]) -> tuple[Segment, ...]:
    """Pointwise minimum of two piecewise-linear functions over the same domain."""
    cuts = sorted({s[0] for s in one} | {s[1] for s in one} | {s[0] for s in two} | {s[1] for s in two})
    result: list[Segment] = []
    i = j = 0
    for a, b in pairwise(cuts):
        while one[i][1] <= a:
            i += 1
        while two[j][1] <= a:
            j += 1
        p0, p1 = _at(one[i], a), _at(one[i], b)
        q0, q1 = _at(two[j], a), _at(two[j], b)
        if (p0 - q0) * (p1 - q1) < 0:
            cross = a + (b - a) * (p0 - q0) / ((p0 - q0) - (p1 - q1))
            there = _at(one[i], cross)
            result.append((a, cross, min(p0, q0), there))
            result.append((cross, b, there, min(p1, q1)))
        else:
            result.append((a, b, min(p0, q0), min(p1, q1)))
    return tuple(result)


def _at(segment: Segment, t: Fraction) -> Fraction:
    a, b, ya, yb = segment
    return ya + (yb - ya) * (t - a) / (b - a)


@lru_cache(maxsize=512)
def _clipped(members: tuple[int, ...], segments: tuple[Segment, ...]) -> ClippedSet:
    levels = sorted({Fraction(0)} | {y for s in segments for y in s[2:] if y > 0})
    support = [s for s in segments if max(s[2], s[3]) > 0]
    sign = 1 if len(members) % 2 else -1
    raw = [_level_set(support, a, b) for a, b in pairwise(levels)]
    centre = _centre(raw)
    if centre is not None:
        reference, moment_sign = centre, 0
    else:
        low, high = support[0][0], support[-1][1]
        if low.denominator <= high.denominator:
            reference, moment_sign = low, 1
        else:
            reference, moment_sign = high, -1
    pieces: list[Piece] = []
    area = moment = Fraction(0)
    for (width, first), a, b in zip(raw, levels, levels[1:], strict=False):
        turned = [moment_sign * (v - reference * w) for v, w in zip(first, (*width, Fraction(0)), strict=True)]
        about = (turned[0], turned[1], turned[2])
        pieces.append(Piece(a, b, width, about, area, moment))
        area += _integral(width, a, b)
        moment += _integral(about, a, b)
    return ClippedSet(members, sign, reference, moment_sign, tuple(pieces))


def _level_set(
    support: list[Segment], low: Fraction, high: Fraction
) -> tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction, Fraction]]:
    """Width and first moment (about 0) of ``{h > c}`` for ``low < c < high``, as polynomials of c."""
    w0 = w1 = v0 = v1 = v2 = Fraction(0)
    for a, b, ya, yb in support:
        if min(ya, yb) >= high:
            w0 += b - a
            v0 += (b * b - a * a) / 2
        elif max(ya, yb) > low:
            slope = (b - a) / (yb - ya)
            # The line is at height c at t = e + slope * c; the part above lies towards its higher end.
            e = a - slope * ya
            side, end = (1, b) if yb > ya else (-1, a)
            w0 += side * (end - e)
            w1 -= side * slope
            v0 += side * (end * end - e * e) / 2
            v1 -= side * e * slope
            v2 -= side * slope * slope / 2
    return (w0, w1), (v0, v1, v2)


def _centre(
    raw: list[tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction, Fraction]]],
) -> Fraction | None:
    """The point that every level set is symmetric enough about to have its mean there, or None."""
    (w0, w1), (v0, v1, _) = raw[0]
    r = v0 / w0 if w0 else v1 / w1
    for (a0, a1), (b0, b1, b2) in raw:
        if b0 != r * a0 or b1 != r * a1 or b2 != 0:
            return None
    return r


def _integral(poly: tuple[Fraction, ...], start: Fraction, end: Fraction) -> Fraction:
    return sum((p * (end ** (i + 1) - start ** (i + 1)) / (i + 1) for i, p in enumerate(poly)), Fraction(0))
