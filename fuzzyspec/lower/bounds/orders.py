"""The lemma "slope" piece by piece, where degrees' order decides everything (strong partitions, min and max).

Of an input's two active terms the one with degree m <= 1/2 is its minor. A piece is a set of active terms, a choice of
minors and an order of them: there every level is one of the minors, or 1 - (the largest), always the same one, so area
and moment are sums of functions of one minor each, and how fast the mean moves is known without any choice being open.
"""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fuzzyspec.lower.bounds.memberships import Floats
from fuzzyspec.lower.bounds.outputs import FLOAT_SLACK, CentroidBound
from fuzzyspec.lower.bounds.slopes import LevelSets
from fuzzyspec.lower.bounds.strengths import Strengths
from fuzzyspec.lower.clipped import clipped_sets
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.model.controller import Controller, Output

Ints = npt.NDArray[np.int64]

MOST_PIECES = 60_000
"""Before those that are alike are put together; 6 144 for four inputs of three terms."""
CLOSE_ENOUGH = 1.05
NEAR = 2.0**-40
NARROWEST = 2.0**-14
CHUNK = 4096


def applies(controller: Controller) -> bool:
    """Whether every level is a minor, or what the largest minor leaves, and some level is at least 1/2."""
    cells, infer = controller.cells, controller.infer
    return (
        cells is not None
        and not controller.sentences
        and (infer.and_, infer.aggregate, infer.defuzzify) == ("min", "max", "centroid")
        and all(i.peaks is not None and len(i.peaks) > 1 for i in controller.inputs)
        and all(-1 not in c for c in cells.consequents)
        and math.factorial(len(controller.inputs)) * math.prod(2 * len(i.terms) - 2 for i in controller.inputs)
        <= MOST_PIECES
    )


@dataclass(frozen=True)
class Pieces:
    """P pieces, or parts of them, of one output.

    ``rank`` (P, terms): the place, in their order, of the minor that is the term's level; 0 for no level, n + 1 for
    1 - (the largest). ``weight`` (P, n): how far each minor moves, by its place. ``lo .. hi`` (P, n): the minors.
    ``origin`` (P,) numbers the order and the choice of minors.
    """

    origin: Ints
    rank: Ints
    weight: Floats
    lo: Floats
    hi: Floats

    def __len__(self) -> int:
        return len(self.rank)

    def at(self, which: Ints | slice | npt.NDArray[np.bool_]) -> Pieces:
        """Some of them."""
        return Pieces(self.origin[which], self.rank[which], self.weight[which], self.lo[which], self.hi[which])

    def and_(self, others: Pieces) -> Pieces:
        """These, then the others."""
        return Pieces(
            np.concatenate([self.origin, others.origin]),
            np.concatenate([self.rank, others.rank]),
            np.concatenate([self.weight, others.weight]),
            np.concatenate([self.lo, others.lo]),
            np.concatenate([self.hi, others.hi]),
        )

    def ordered(self) -> Pieces:
        """What the minors' order leaves of them."""
        lo = np.maximum.accumulate(self.lo, axis=1)
        hi = np.minimum.accumulate(self.hi[:, ::-1], axis=1)[:, ::-1]
        return replace(self, lo=lo, hi=hi).at((lo <= hi).all(axis=1))


def slid(strengths: Strengths) -> list[list[float]]:
    """By input and pair of neighbouring peaks, how far degrees move while the inputs move by the strengths' errors."""
    found: list[list[float]] = []
    for item, error in zip(strengths.controller.inputs, strengths.errors, strict=True):
        assert item.peaks is not None
        span = item.variable.hi - item.variable.lo
        found.append([error / float((b - a) / span) for a, b in itertools.pairwise(item.peaks)])
    return found


def rounded(strengths: Strengths) -> list[list[float]]:
    """By input and pair of neighbouring peaks, how far degrees are moved by their rounding."""
    # Each piece's error counts for both of its terms.
    return [[float(min(pair)) for pair in itertools.pairwise(errors)] for errors in strengths.numbers.degree_errors]


def pieces_of(strengths: Strengths, output: int, moves: list[list[float]], *, beyond: bool = False) -> Pieces:
    """Every piece of a controller, for one of its outputs and degrees that move so far; alike ones once.

    ``beyond``: they move so far from where the inputs may be, and not because inputs may be there.
    """
    controller = strengths.controller
    cells = controller.cells
    assert cells is not None
    n = len(controller.inputs)
    sides = [_sides(strengths, i, moves[i], beyond) for i in range(n)]
    chosen = np.stack([g.ravel() for g in np.meshgrid(*(np.arange(len(s)) for s in sides), indexing="ij")], axis=1)
    # (choices, inputs): which terms are major and minor there, how far the minor moves, where it can lie.
    major, minor, moved, low, high = (
        np.stack([s[chosen[:, i], k] for i, s in enumerate(sides)], axis=1) for k in range(5)
    )
    major, minor = major.astype(np.int64), minor.astype(np.int64)
    there = (low <= high).all(axis=1)
    strides = np.array([math.prod(cells.shape[i + 1 :]) for i in range(n)])
    table = np.array(cells.consequents[output])
    row = np.arange(len(chosen))
    found: list[Pieces] = []
    for order in itertools.permutations(range(n)):
        rank = np.zeros((len(chosen), len(controller.outputs[output].terms)), dtype=np.int64)
        for at, first in enumerate(order):
            later = order[at + 1 :]
            for more in itertools.product((False, True), repeat=len(later)):
                taken = {first} | {i for i, t in zip(later, more, strict=True) if t}
                cells_named = np.where([i in taken for i in range(n)], minor, major) * strides
                rank[row, table[cells_named.sum(axis=1)]] = at + 1
        rank[row, table[(major * strides).sum(axis=1)]] = n + 1
        turn = list(order)
        origin = len(found) * len(chosen) + row
        found.append(Pieces(origin, rank, moved[:, turn], low[:, turn], high[:, turn]).at(there).ordered())
    pieces = functools.reduce(Pieces.and_, found)
    alike = np.concatenate([pieces.rank, pieces.weight, pieces.lo, pieces.hi], axis=1)
    _, once = np.unique(alike, axis=0, return_index=True)
    return pieces.at(np.sort(once))


def _sides(strengths: Strengths, i: int, moves: list[float], beyond: bool) -> Floats:
    """By pair of neighbouring terms and by which of them is the minor: major, minor, how far its degree moves, and the
    ends between which it lies (none where the first is above the second)."""
    item = strengths.controller.inputs[i]
    assert item.peaks is not None
    lo, span = item.variable.lo, item.variable.hi - item.variable.lo
    ends = strengths.around(i)
    rows = []
    for j, (pair, rise) in enumerate(zip(itertools.pairwise(item.peaks), moves, strict=True)):
        a, b = (float((p - lo) / span) for p in pair)
        # Before the first peak and beyond the last one a degree stays what it is at the peak.
        at = [(x - a) / (b - a) for x in ends]
        whole = strengths.raws is None
        near = NEAR + (rise if beyond else 0.0)
        upper = [0.0, 1.0] if whole else [max(0.0, at[0] - near), min(1.0, at[1] + near)]
        first = j == 0 and at[1] < 0
        last = j == len(item.peaks) - 2 and at[0] > 1
        if first or last:
            upper = [0.0, 0.0] if first else [1.0, 1.0]
        rows.append([j, j + 1, rise, upper[0], min(0.5, upper[1])])
        rows.append([j + 1, j, rise, 1 - upper[1], min(0.5, 1 - upper[0])])
    return np.array(rows)


class Fastest:
    """The largest sum over the inputs of |the mean's rate along it| * its error."""

    def __init__(self, output: Output, mean: CentroidBound, pieces: Pieces) -> None:
        self.mean = mean
        self.sets = LevelSets(clipped_sets(output))
        self.pieces = pieces

    def search(self, boxes: int) -> tuple[float, Pieces]:
        """By splitting parts of pieces, at most about so many, where the bound is worst; also where that is."""
        parts = self.pieces
        rates = self.rates(parts)
        looked, floor = len(parts), 0.0
        spot: Pieces | None = None
        while len(parts):
            worst = np.argsort(-rates, kind="stable")[:64]
            middle = (parts.lo[worst] + parts.hi[worst]) / 2
            points = replace(parts.at(worst), lo=middle, hi=middle)
            found = self.rates(points)
            if found.max(initial=0.0) > floor or spot is None:
                floor, spot = float(found.max()), points.at(found.argmax(keepdims=True))
            open_ = rates > floor * CLOSE_ENOUGH
            parts, rates = parts.at(open_), rates[open_]
            wide = np.flatnonzero((parts.hi - parts.lo).max(axis=1, initial=0.0) > NARROWEST)
            room = (boxes - looked) // 2
            if not len(wide) or room <= 0:
                break
            chosen = wide[np.argsort(-rates[wide], kind="stable")[: min(room, CHUNK)]]
            halves = self._halves(parts.at(chosen))
            more = self.rates(halves)
            keep = np.ones(len(parts), dtype=bool)
            keep[chosen] = False
            parts = parts.at(keep).and_(halves)
            rates = np.concatenate([rates[keep], more])
            looked += len(halves)
        assert spot is not None
        if len(parts) and rates.max() > floor * CLOSE_ENOUGH:
            return float(rates.max()), parts.at(rates.argmax(keepdims=True))
        return floor * CLOSE_ENOUGH, spot

    def _halves(self, parts: Pieces) -> Pieces:
        n = parts.lo.shape[1]
        # A minor that is no term's level moves nothing.
        matters = np.stack([(parts.rank == r + 1).any(axis=1) for r in range(n)], axis=1)
        matters[:, -1] = True
        side = ((parts.hi - parts.lo) * np.where(matters, 1.0, 2.0**-20)).argmax(axis=1)
        row = np.arange(len(parts))
        middle = (parts.lo[row, side] + parts.hi[row, side]) / 2
        hi, lo = parts.hi.copy(), parts.lo.copy()
        hi[row, side] = middle
        lo[row, side] = middle
        return replace(parts, hi=hi).and_(replace(parts, lo=lo)).ordered()

    def rates(self, parts: Pieces) -> Floats:
        """A bound for every part, relative to the output's range."""
        found = [self._rates(parts.at(slice(i, i + CHUNK))) for i in range(0, len(parts), CHUNK)]
        return np.concatenate(found) if found else np.zeros(0)

    def shares(self, one: Pieces) -> list[float]:
        """What each minor of a single part adds to its bound, by place in the order."""
        rates, area = self._by_minor(one)
        return [float(r) for r in rates[0] / area[0]]

    def _rates(self, parts: Pieces) -> Floats:
        rates, area = self._by_minor(parts)
        slack = len(self.sets.sign) * parts.weight.sum(axis=1) * FLOAT_SLACK
        result: Floats = (rates.sum(axis=1) + slack) / area * (1 + FLOAT_SLACK)
        return result

    def _by_minor(self, parts: Pieces) -> tuple[Floats, Floats]:
        """What each minor adds, by place (P, n), and the least area that it is to be divided by (P,)."""
        none = np.zeros((len(parts), 1))
        lo = np.concatenate([none, parts.lo, 1 - parts.hi[:, -1:]], axis=1)
        hi = np.concatenate([none, parts.hi, 1 - parts.lo[:, -1:]], axis=1)
        least = np.take_along_axis(lo, parts.rank, axis=1)
        most = np.take_along_axis(hi, parts.rank, axis=1)
        y = self._mean(parts, lo, hi, most)
        return parts.weight * self._turned(parts, lo, hi, y), self.mean.area(least) - FLOAT_SLACK

    def _mean(self, parts: Pieces, lo: Floats, hi: Floats, most: Floats) -> tuple[Floats, Floats]:
        """Where the mean lies: about that in the middle, and how far the minors take it from there."""
        n = parts.lo.shape[1]
        at = np.round((lo + hi) / 2 * DEGREE_ONE) / DEGREE_ONE
        at[:, n + 1] = 1 - at[:, n]
        far = np.maximum(hi - at, at - lo)
        levels = np.take_along_axis(at, parts.rank, axis=1)
        area = self.mean.area(levels)
        middle = self.mean.moment(levels) / area
        y = self.mean.support(most)
        lows, highs = np.minimum(lo, at), np.maximum(hi, at)
        for _ in range(2):
            reach = (far[:, 1 : n + 1] * self._turned(parts, lows, highs, y)).sum(axis=1) / area + FLOAT_SLACK
            y = np.maximum(y[0], middle - reach), np.minimum(y[1], middle + reach)
        return y

    def _turned(self, parts: Pieces, lo: Floats, hi: Floats, y: tuple[Floats, Floats]) -> Floats:
        """By place: the size of the integral of ``t - y`` over what rises with that minor, less what falls, at most."""
        down, up = np.zeros_like(lo), np.zeros_like(lo)
        row, n = np.arange(len(parts))[:, None], parts.lo.shape[1]
        place = parts.rank[:, self.sets.members].min(axis=2)
        low, high = self.sets.turn(lo[row, place], hi[row, place], y)
        np.add.at(down, (row, place), low)
        np.add.at(up, (row, place), high)
        down[:, n], up[:, n] = down[:, n] - up[:, n + 1], up[:, n] - down[:, n + 1]
        result: Floats = np.maximum(np.abs(down), np.abs(up))[:, 1 : n + 1]
        return result


def place(controller: Controller, one: Pieces, by_place: list[float]) -> tuple[Floats, list[float]]:
    """The middle of a single part as inputs relative to their ranges, (1, n), and what was by place by input."""
    n = len(controller.inputs)
    sides = [2 * len(i.terms) - 2 for i in controller.inputs]
    which, choice = divmod(int(one.origin[0]), math.prod(sides))
    order = list(itertools.permutations(range(n)))[which]
    minors = (one.lo[0] + one.hi[0]) / 2
    at, by_input = np.zeros((1, n)), [0.0] * n
    for i, side in enumerate(np.unravel_index(choice, sides)):
        item, at_place = controller.inputs[i], order.index(i)
        assert item.peaks is not None
        ends = item.peaks[side // 2], item.peaks[side // 2 + 1]
        lo, hi = (float((p - item.variable.lo) / (item.variable.hi - item.variable.lo)) for p in ends)
        minor = minors[at_place] if side % 2 == 0 else 1 - minors[at_place]
        at[0, i] = lo + (hi - lo) * minor
        by_input[i] = by_place[at_place]
    return at, by_input
