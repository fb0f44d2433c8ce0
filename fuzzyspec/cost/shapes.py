"""What of an output's terms a program by hand would make use of, for the counted limit."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from itertools import pairwise
from math import gcd, lcm

from fuzzyspec.cost.blocks import height
from fuzzyspec.model.controller import Output
from fuzzyspec.model.term import PiecewiseLinear, Singleton


def even(output: Output) -> bool:
    """Triangles of one width that meet at half their height or not at all, and halves of them at the ends of the range:
    areas and moments are small multiples of heights, squares and cubes."""
    peaks = output.peaks
    if peaks is not None:
        ends = (output.variable.lo, output.variable.hi)
        return (peaks[0], peaks[-1]) == ends and len({b - a for a, b in pairwise(peaks)}) == 1
    shapes = [t.shape for t in output.terms if isinstance(t.shape, PiecewiseLinear)]
    if not all(whole(output, t) for t in range(len(output.terms))) or {len(s.points) for s in shapes} != {3}:
        return False
    widths = {s.points[1][0] - s.points[0][0] for s in shapes}
    at = sorted(s.points[1][0] for s in shapes)
    (width, *others) = widths
    return not others and all(b - a == width or b - a >= 2 * width for a, b in pairwise(at))


def whole(output: Output, term: int) -> bool:
    """Whether a term's mean is the same at every strength: a singleton, or alike on both sides and not cut."""
    shape = output.terms[term].shape
    if isinstance(shape, Singleton):
        return True
    points = shape.points
    (lo, low), (hi, high) = points[0], points[-1]
    mirrored = tuple((lo + hi - x, y) for x, y in reversed(points))
    return points == mirrored and low == high == 0 and output.integrate_lo <= lo and hi <= output.integrate_hi


def overlaps(output: Output, named: Iterable[int]) -> int:
    """Pairs of terms with common support."""
    supports = [s for t in sorted(named) if (s := _support(output, t)) is not None]
    return sum(max(a, c) < min(b, d) for i, (a, b) in enumerate(supports) for c, d in supports[:i])


def _support(output: Output, term: int) -> tuple[Fraction, Fraction] | None:
    shape = output.terms[term].shape
    if not isinstance(shape, PiecewiseLinear):
        return None
    xs = [x for x, _ in shape.points]
    lo = output.integrate_lo if shape.points[0][1] else xs[0]
    hi = output.integrate_hi if shape.points[-1][1] else xs[-1]
    return max(lo, output.integrate_lo), min(hi, output.integrate_hi)


def cut(output: Output, term: int) -> bool:
    """Whether an end of the range cuts a term's flank."""
    shape = output.terms[term].shape
    return any(0 < height(shape, x) < 1 for x in (output.integrate_lo, output.integrate_hi))


def rounded(output: Output) -> bool:
    """Whether the range is a power of two of raws, so that a quotient is only shortened."""
    raws = (output.variable.hi - output.variable.lo) / abs(output.variable.raw.step)
    return raws.denominator == 1 and raws.numerator & (raws.numerator - 1) == 0


def places(output: Output) -> int:
    """Of singletons, the largest distance in the largest step that divides all."""
    at = sorted({t.shape.at for t in output.terms if isinstance(t.shape, Singleton)})
    if len(at) < 2:
        return 1
    common = lcm(*(x.denominator for x in at))
    whole = [int((x - at[0]) * common) for x in at]
    return whole[-1] // gcd(*whole)
