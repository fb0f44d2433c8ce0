"""Memberships over intervals: ranges, steepness, level sets. float64, rounded outwards by :data:`SLACK`."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Literal

import numpy as np
import numpy.typing as npt

from fuzzyspec.model.term import PiecewiseLinear, Shape, Singleton

Floats = npt.NDArray[np.float64]

SLACK = 2.0**-46
"""Covers the float64 roundings of one membership (a subtraction, a division, a multiply-add of values of at most 1)."""

GRID = 1024
"""Level sets are tabulated at heights j / GRID; a height is taken down to the grid, which only widens its level set."""


@dataclass(frozen=True)
class Membership:
    """One piecewise-linear term in relative positions (0 .. 1 over the variable's range).

    ``x`` are its breakpoints, ``before``/``after`` the limits from either side, ``low``/``high`` the least and
    largest value at each breakpoint, ``jumps`` those where there is more than one; ``slopes`` lie between them.
    """

    x: Floats
    before: Floats
    after: Floats
    low: Floats
    high: Floats
    slopes: Floats
    jumps: npt.NDArray[np.bool_]

    @property
    def steepest(self) -> float:
        """The largest slope anywhere, jumps apart."""
        return float(np.abs(self.slopes).max(initial=0.0))

    def slope(self, lo: Floats, hi: Floats) -> tuple[Floats, Floats]:
        """Least and largest slope inside each open interval ``lo .. hi``, jumps apart; 0 for those without length."""
        least, most = np.zeros(len(lo)), np.zeros(len(lo))
        first = np.ones(len(lo), dtype=np.bool_)
        outside = ((lo < self.x[0]) | (hi > self.x[-1]), 0.0)
        pieces = [((lo < b) & (hi > a), k) for a, b, k in zip(self.x, self.x[1:], self.slopes, strict=False)]
        for inside, k in (outside, *pieces):
            least = np.where(inside, np.where(first, k, np.minimum(least, k)), least)
            most = np.where(inside, np.where(first, k, np.maximum(most, k)), most)
            first &= ~inside
        return least, most

    def jumps_in(self, lo: Floats, hi: Floats) -> npt.NDArray[np.bool_]:
        """Whether the closed interval holds a jump."""
        found = np.zeros(len(lo), dtype=np.bool_)
        for x in self.x[self.jumps]:
            found |= (lo <= x) & (x <= hi)
        return found

    def over(self, lo: Floats, hi: Floats) -> tuple[Floats, Floats]:
        """Least and largest membership over each closed interval ``lo .. hi``."""
        ends = [self._at(lo, "right"), self._at(hi, "left")]
        least, most = np.minimum(*ends), np.maximum(*ends)
        for x, low, high in zip(self.x, self.low, self.high, strict=True):
            # At a jump the largest value holds; of its limits those count that the interval comes to from inside.
            least = np.where((lo < x) & (x < hi), np.minimum(least, low), np.where((lo == x) & (hi == x), high, least))
            most = np.where((lo <= x) & (x <= hi), np.maximum(most, high), most)
        # Exactly 0 and exactly 1 are kept: the integer degree is exact there.
        low = np.where(least >= 1, 1.0, np.maximum(least - SLACK, 0.0))
        return low, np.where(most <= 0, 0.0, np.minimum(most + SLACK, 1.0))

    def _at(self, t: Floats, side: Literal["left", "right"] = "right") -> Floats:
        """The value off the breakpoints, the limit from one side on them."""
        j = np.searchsorted(self.x, t, side=side) - 1
        last = len(self.x) - 1
        k = np.clip(j, 0, last)
        n = np.minimum(k + 1, last)
        width = np.where(n > k, self.x[n] - self.x[k], 1.0)
        inside = self.after[k] + (self.before[n] - self.after[k]) * np.clip((t - self.x[k]) / width, 0.0, 1.0)
        result: Floats = np.where(j < 0, self.before[0], np.where(j >= last, self.after[last], inside))
        return result


def membership(shape: Shape, lo: Fraction, hi: Fraction) -> Membership:
    """The term over the range ``lo .. hi``."""
    if isinstance(shape, Singleton):
        points: tuple[tuple[Fraction, Fraction], ...] = (
            (shape.at, Fraction(0)),
            (shape.at, Fraction(1)),
            (shape.at, Fraction(0)),
        )
    else:
        assert isinstance(shape, PiecewiseLinear)
        points = shape.points
    span = hi - lo
    xs = sorted({x for x, _ in points})
    groups = [[y for x, y in points if x == at] for at in xs]
    before = [g[0] for g in groups]
    after = [g[-1] for g in groups]
    slopes = [(b - a) / (x1 - x0) * span for x0, x1, a, b in zip(xs, xs[1:], after, before[1:], strict=False)]
    return Membership(
        np.array([float((x - lo) / span) for x in xs]),
        np.array([float(b) for b in before]),
        np.array([float(a) for a in after]),
        np.array([float(min(g)) for g in groups]),
        np.array([float(max(g)) for g in groups]),
        np.array([float(k) for k in slopes]) * (1 + SLACK),
        np.array([len(set(g)) > 1 for g in groups]),
    )


def level_sets(m: Membership, lo: float, hi: float) -> tuple[Floats, Floats]:
    """Ends of the smallest interval that holds ``{t in [lo, hi]: mu(t) > j / GRID}``, for j = 0 .. GRID.

    An empty set is the interval (0, 0); widened by SLACK otherwise.
    """
    height = np.arange(GRID + 1) / GRID - SLACK
    above_zero = np.maximum(height, SLACK)
    left, right = np.full(GRID + 1, np.inf), np.full(GRID + 1, -np.inf)

    def take(where: npt.NDArray[np.bool_], a: Floats | float, b: Floats | float) -> None:
        np.minimum(left, np.where(where, a, np.inf), out=left)
        np.maximum(right, np.where(where, b, -np.inf), out=right)

    cuts = [lo, *(float(x) for x in m.x if lo < x < hi), hi]
    for a, b in pairwise(cuts):
        # The line of this piece, from two points inside it.
        y1, y3 = m._at(np.array([a + (b - a) / 4, a + 3 * (b - a) / 4]))
        ya, yb = y1 - (y3 - y1) / 2, y3 + (y3 - y1) / 2
        whole = min(ya, yb) >= above_zero
        take(whole, a, b)
        some = ~whole & (max(ya, yb) >= above_zero)
        if ya != yb:
            cross = np.clip(a + (b - a) * (height - ya) / (yb - ya), a, b)
            take(some, *((cross, b) if yb > ya else (a, cross)))
    for x, y in zip(m.x, m.high, strict=True):
        if lo <= x <= hi:
            take(y >= above_zero, float(x), float(x))
    empty = left > right
    return np.where(empty, 0.0, left - SLACK), np.where(empty, 0.0, right + SLACK)
