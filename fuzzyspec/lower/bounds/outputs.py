"""From levels to the error of a mean, relative to the output's range (lemmas "centroid" and "average")."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fuzzyspec.lower.average import AverageNumbers
from fuzzyspec.lower.bounds.memberships import GRID, Floats, level_sets, membership
from fuzzyspec.lower.bounds.strengths import Band
from fuzzyspec.lower.centroid import CentroidNumbers, SetNumbers
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.sets import closed_form
from fuzzyspec.model.controller import Output

BINS = 128
Ints = npt.NDArray[np.int64]
FLOAT_SLACK = 2.0**-40
"""Covers the float64 roundings of a sum over at most 64 sets of values of order 1 (each below 2**-50), with room."""


@dataclass(frozen=True)
class Parts:
    """What a bound is made of, each (B,), relative to the range: degrees' errors, polynomials' roundings, tail."""

    degrees: Floats
    rounding: Floats
    tail: float

    @property
    def total(self) -> Floats:
        result: Floats = np.minimum(self.degrees + self.rounding + self.tail, 1.0)
        return result


class CentroidBound:
    def __init__(self, output: Output, numbers: CentroidNumbers, fires_at: float, sure: bool) -> None:
        self.sure = sure
        span = output.variable.hi - output.variable.lo
        left = float((output.integrate_lo - output.variable.lo) / span)
        right = float((output.integrate_hi - output.variable.lo) / span)
        self.sets = [_Set(s) for s in numbers.sets]
        self.level_sets = [
            level_sets(membership(t.shape, output.variable.lo, output.variable.hi), left, right) for t in output.terms
        ]
        counts = abs(
            output.variable.raw.position(output.variable.hi) - output.variable.raw.position(output.variable.lo)
        )
        self.tail = float(numbers.tail.error / counts)
        self.area_slip, self.moment_slip = numbers.area_slip, numbers.moment_slip
        self.fires_at = fires_at

    def parts(self, levels: Band) -> Parts:
        lo = np.maximum(levels.lo - levels.off, 0.0)
        hi: Floats = np.where(levels.hi > 0, np.minimum(levels.hi + levels.off, 1.0), 0.0)
        # Where some rule always fires, the integer strength may lie below the threshold by its error.
        reached = self.fires_at - (float(levels.off.max(initial=0.0)) if self.sure else 0.0)
        area_lo = self.area_over(lo, hi, reached)
        y = self.mean(levels.lo, levels.hi, lo, hi)
        moved = self._moved(levels.off, lo, y)
        rounding, area_off = self._rounding(lo, hi, y)
        safe = area_lo - area_off
        with np.errstate(divide="ignore", invalid="ignore"):
            degrees = np.where(safe > 0, moved / safe, np.inf)
            rounded = np.where(safe > 0, rounding / safe, np.inf)
        # Where no term can reach the threshold the output falls back, and no mean is taken.
        silent = (hi < self.fires_at - FLOAT_SLACK).all(axis=1)
        degrees, rounded = np.where(silent, 0.0, degrees), np.where(silent, 0.0, rounded)
        degrees = np.where(fires_on_nothing(levels, self.fires_at, self.sure), np.inf, degrees)
        return Parts(degrees, rounded, self.tail)

    def area_over(self, lo: Floats, hi: Floats, reached: float) -> Floats:
        """The least area for levels in ``lo .. hi`` of which one is at least ``reached``."""
        result: Floats = np.maximum(self.area(lo), self._fired_area(hi, reached)) - FLOAT_SLACK
        return result

    def mean(
        self, lo: Floats, hi: Floats, least: Floats | None = None, most: Floats | None = None
    ) -> tuple[Floats, Floats]:
        """Where the mean lies for levels in ``lo .. hi``, in what levels of ``least .. most`` raise."""
        least, most = lo if least is None else least, hi if most is None else most
        middle = np.round((lo + hi) / 2 * DEGREE_ONE) / DEGREE_ONE
        half = np.maximum(hi - middle, middle - lo)
        wide = self.support(most)
        area = self.area(middle)
        y = np.where(area > 0, self.moment(middle) / np.where(area > 0, area, 1.0), 0.5)
        spread = self._moved(half, np.minimum(least, middle), wide)
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = np.where(area > 0, spread / area, np.inf) + FLOAT_SLACK
        return np.maximum(wide[0], y - reach), np.minimum(wide[1], y + reach)

    def area(self, levels: Floats) -> Floats:
        """A lower bound of the union's area at these levels; exact for levels on the grid."""
        total = np.zeros(len(levels))
        for s in self.sets:
            total += s.sign * s.area(s.height(levels), up=s.sign < 0)
        return total

    def moment(self, levels: Floats) -> Floats:
        total = np.zeros(len(levels))
        for s in self.sets:
            total += s.sign * s.moment(s.height(levels))
        return total

    def _fired_area(self, hi: Floats, reached: float) -> Floats:
        """Some term reaches the firing threshold: the least area that this alone gives."""
        floor = np.full(len(hi), np.inf)
        at = max(reached - FLOAT_SLACK, 0.0)
        for s in self.sets:
            if len(s.members) == 1:
                own = float(s.area(np.array([at]), up=False)[0])
                floor = np.where(hi[:, s.members[0]] >= at, np.minimum(floor, own), floor)
        return np.where(np.isfinite(floor), floor, 0.0)

    def support(self, hi: Floats) -> tuple[Floats, Floats]:
        left, right = np.full(len(hi), np.inf), np.full(len(hi), -np.inf)
        for k, (a, b) in enumerate(self.level_sets):
            active = hi[:, k] > 0
            left = np.where(active, np.minimum(left, a[0]), left)
            right = np.where(active, np.maximum(right, b[0]), right)
        some = left <= right
        return np.where(some, np.maximum(left, 0.0), 0.0), np.where(some, np.minimum(right, 1.0), 1.0)

    def _moved(self, off: Floats, lo: Floats, y: tuple[Floats, Floats]) -> Floats:
        """``sum of off_k * integral of |t - y| over the level set of term k at lo_k``, largest over y."""
        total = np.zeros(len(lo))
        for k, (left, right) in enumerate(self.level_sets):
            j = np.floor(lo[:, k] * GRID).astype(np.int64)
            a, b = left[j], right[j]
            lever = np.maximum(_lever(a, b, y[0]), _lever(a, b, y[1]))
            total += off[:, k] * lever
        return total

    def _rounding(self, lo: Floats, hi: Floats, y: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
        area_off = np.full(len(lo), self.area_slip)
        total = self.area_slip * np.abs(y[1]) + self.moment_slip
        for s in self.sets:
            c_lo, c_hi = s.height(lo), s.height(hi)
            active = c_hi > 0
            area, moment = s.errors(c_lo, c_hi)
            lever = np.maximum(np.abs(s.reference - y[0]), np.abs(s.reference - y[1]))
            own = lever * area + moment + s.weight_error * s.area(c_hi, up=True) + s.product_error
            total += np.where(active, own, 0.0)
            area_off += np.where(active, area, 0.0)
        return total, area_off


def fires_on_nothing(levels: Band, fires_at: float, sure: bool) -> npt.NDArray[np.bool_]:
    """Boxes in which the integers may fire while exactly no rule has any strength: there is no mean to compare with."""
    none = levels.lo.max(axis=1) <= 0
    result: npt.NDArray[np.bool_] = none & (levels.off.max(axis=1) >= fires_at - FLOAT_SLACK) & (not sure)
    return result


def _lever(a: Floats, b: Floats, y: Floats) -> Floats:
    inside = ((y - a) ** 2 + (b - y) ** 2) / 2
    outside = np.abs((a + b) / 2 - y) * (b - a)
    return np.where((a <= y) & (y <= b), inside, outside)


class _Set:
    """Look-ups over one set's clip height, from its closed form at every multiple of 2**-15."""

    def __init__(self, numbers: SetNumbers) -> None:
        form = numbers.form
        self.members = form.members
        self.sign = form.sign
        self.reference = float(form.reference)
        self.weight_error = numbers.weight_error
        self.product_error = numbers.product_error
        area, moment = closed_form(form)
        self._area = area
        self._moment = float(form.reference) * area + form.moment_sign * moment
        self._top = float(form.height)
        step = DEGREE_ONE // BINS
        self._worst = [
            _running_maxima(np.array([e[b * step : (b + 1) * step + 1].max() for b in range(BINS)]))
            for e in (numbers.area_error, numbers.moment_error)
        ]

    def height(self, levels: Floats) -> Floats:
        result: Floats = np.minimum(levels[:, list(self.members)].min(axis=1), self._top)
        return result

    def area(self, c: Floats, up: bool) -> Floats:
        """Area at a clip height taken to the table's grid: a bound from above or below, as area grows with height."""
        result: Floats = self._area[np.where(c >= self._top, DEGREE_ONE, _grid(c, up))]
        return result

    def moment(self, c: Floats) -> Floats:
        """First moment about the range's low end, for a height on the grid."""
        result: Floats = self._moment[np.where(c >= self._top, DEGREE_ONE, _grid(c, False))]
        return result

    def errors(self, lo: Floats, hi: Floats) -> tuple[Floats, Floats]:
        """Largest rounding of area and moment for clip heights in ``lo .. hi``."""
        first = np.clip((lo * BINS).astype(np.int64), 0, BINS - 1)
        last = np.clip((hi * BINS).astype(np.int64), 0, BINS - 1)
        return _range_max(self._worst[0], first, last), _range_max(self._worst[1], first, last)


def _grid(c: Floats, up: bool) -> Ints:
    """Index of a clip height in the tables, rounded outwards."""
    at = np.clip(c, 0.0, 1.0) * DEGREE_ONE
    index: Ints = (np.ceil(at) if up else np.floor(at)).astype(np.int64)
    return index


def _range_max(table: list[Floats], first: Ints, last: Ints) -> Floats:
    """Largest value of ``first .. last``, from the running maxima over 1, 2, 4 .. bins."""
    level = np.floor(np.log2(last - first + 1)).astype(np.int64)
    stacked = np.stack(table)
    result: Floats = np.maximum(stacked[level, first], stacked[level, last - (1 << level) + 1])
    return result


def _running_maxima(values: Floats) -> list[Floats]:
    table = [values]
    while (1 << len(table)) <= len(values):
        w = 1 << (len(table) - 1)
        prev = table[-1]
        table.append(np.maximum(prev, np.concatenate([prev[w:], prev[-1:].repeat(w)])))
    return table


class AverageBound:
    def __init__(self, output: Output, numbers: AverageNumbers, fires_at: float, sure: bool) -> None:
        self.sure = sure
        self.places = np.array([float(p) for p in numbers.places])
        self.weight_error = numbers.weight_error
        self.product_error = numbers.product_error
        raw = output.variable.raw
        counts = abs(raw.position(output.variable.hi) - raw.position(output.variable.lo))
        self.tail = float(numbers.tail.error / counts)
        self.fires_at = fires_at

    def parts(self, levels: Band) -> Parts:
        lo = np.maximum(levels.lo - levels.off, 0.0)
        reached = self.fires_at - (float(levels.off.max(initial=0.0)) if self.sure else 0.0)
        area = np.maximum(lo.sum(axis=1), max(reached, 0.0)) - FLOAT_SLACK
        y_lo, y_hi = (y[:, None] for y in self.mean(levels.lo, levels.hi))
        lever = np.maximum(np.abs(self.places - y_lo), np.abs(self.places - y_hi))
        area = np.maximum(area, 2.0**-1000)
        degrees = (levels.off * lever).sum(axis=1) / area
        degrees = np.where(fires_on_nothing(levels, self.fires_at, self.sure), np.inf, degrees)
        return Parts(degrees, self.weight_error + self.product_error / area, self.tail)

    def mean(self, lo: Floats, hi: Floats) -> tuple[Floats, Floats]:
        """Where the mean lies for levels in ``lo .. hi``."""
        active = hi > 0
        left = np.where(active, self.places, np.inf).min(axis=1)
        right = np.where(active, self.places, -np.inf).max(axis=1)
        some = left <= right
        left, right = np.where(some, left, 0.0), np.where(some, right, 1.0)
        middle = (lo + hi) / 2
        total = middle.sum(axis=1)
        safe = np.where(total > 0, total, 1.0)
        y = (middle * self.places).sum(axis=1) / safe
        lever = np.maximum(np.abs(self.places - left[:, None]), np.abs(self.places - right[:, None]))
        reach = ((hi - lo) / 2 * lever).sum(axis=1) / safe
        return np.maximum(left, y - reach), np.minimum(right, y + reach)
