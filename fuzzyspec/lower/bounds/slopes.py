"""How far a controller's exact outputs move while its inputs move by their errors (lemma "slope").

Along the segment from where the inputs are to where they may be, an output moves at a rate that is linear in the
direction, so it is fastest in a direction in which every input moves by its whole error, up or down. For each such
direction the rates of degrees, strengths and levels are followed over boxes of inputs, together and with their signs:
of two neighbours whose degrees are opposite, one rises as fast as the other falls.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Literal, assert_never

import numpy as np

from fuzzyspec.lower.bounds.memberships import Floats, Membership
from fuzzyspec.lower.bounds.outputs import FLOAT_SLACK, AverageBound, CentroidBound
from fuzzyspec.lower.bounds.strengths import Boxes, Ints, Strengths, by_degree, cells_named
from fuzzyspec.lower.clipped import ClippedSet, clipped_sets
from fuzzyspec.model.controller import And, Antecedent, Controller, Is, Not, Or, Output
from fuzzyspec.model.term import Singleton

MOST_INPUTS = 6
"""Inputs that carry an error, at most: 32 directions, of which the other half are the opposites."""

NEAR = 2.0**-40


@dataclass(frozen=True)
class Moving:
    """A quantity over B boxes: exact values in ``lo .. hi`` (B,), rates in D directions in ``down .. up`` (B, D)."""

    lo: Floats
    hi: Floats
    down: Floats
    up: Floats


def directions(errors: tuple[float, ...]) -> Floats:
    """Every way in which inputs move by their errors, (D, inputs); of opposite ones, one."""
    moving = [i for i, e in enumerate(errors) if e]
    found = []
    for signs in itertools.product((1.0, -1.0), repeat=max(0, len(moving) - 1)):
        row = [0.0] * len(errors)
        for i, sign in zip(moving, (1.0, *signs), strict=False):
            row[i] = sign * errors[i]
        found.append(row)
    return np.array(found)


def applies(strengths: Strengths) -> bool:
    """Whether rates say anything: no degree of an input that is off may jump, and the directions must be few."""
    moving = [i for i, e in enumerate(strengths.errors) if e]
    if not 0 < len(moving) <= MOST_INPUTS:
        return False
    around = {i: np.array([strengths.around(i)]) for i in moving}
    return not any(m.jumps_in(at[:, 0], at[:, 1]).any() for i, at in around.items() for m in strengths.terms[i])


class Slopes:
    """Rates of one controller's outputs, relative to their ranges, for inputs off by ``strengths.errors``.

    ``reached[o]`` is a strength that some rule of output o is known to have wherever its mean is taken.
    """

    def __init__(
        self, strengths: Strengths, means: list[CentroidBound | AverageBound], reached: tuple[float, ...]
    ) -> None:
        self.controller: Controller = strengths.controller
        self.terms = strengths.terms
        self.directions = directions(strengths.errors)
        steepest = max(m.steepest for terms in strengths.terms for m in terms)
        self.outputs = [
            _Centroid(o, m, at, steepest * float(np.abs(self.directions[0]).max()))
            if isinstance(m, CentroidBound)
            else _Average(m, at)
            for o, m, at in zip(self.controller.outputs, means, reached, strict=True)
        ]

    def rates(self, boxes: Boxes) -> Floats:
        """For every box and output, (B, outputs), how far the output moves at most, were its rate what it is there."""
        degrees = [[self._degree(i, m, boxes) for m in terms] for i, terms in enumerate(self.terms)]
        fired: list[list[tuple[Ints, Moving]]] = [[] for _ in self.controller.outputs]
        if self.controller.cells is not None:
            self._cells(len(boxes), degrees, fired)
        for rule in self.controller.sentences:
            weight = float(rule.weight)
            m = self._sentence(rule.antecedent, degrees)
            m = Moving(m.lo * weight, m.hi * weight, m.down * weight, m.up * weight)
            for output, term in rule.consequents:
                fired[output].append((np.full(len(boxes), term), m))
        found = [
            bound.rate(self._levels(len(boxes), len(o.terms), f))
            for o, bound, f in zip(self.controller.outputs, self.outputs, fired, strict=True)
        ]
        return np.stack(found, axis=1)

    def _degree(self, i: int, m: Membership, boxes: Boxes) -> Moving:
        lo, hi = boxes.lo[:, i], boxes.hi[:, i]
        least, most = m.over(lo, hi)
        # Where a box is a point, the slopes on both sides of it.
        near = np.where(lo == hi, NEAR, 0.0)
        low, high = m.slope(lo - near, hi + near)
        along = self.directions[:, i]
        ends = low[:, None] * along, high[:, None] * along
        return Moving(least, most, np.minimum(*ends), np.maximum(*ends))

    def _levels(self, n: int, terms: int, fired: list[tuple[Ints, Moving]]) -> Moving:
        row = np.arange(n)
        lo, hi = np.zeros((n, terms + 1)), np.zeros((n, terms + 1))
        wide = (n, terms + 1, len(self.directions))
        if self.controller.infer.aggregate == "sum":
            down, up = np.zeros(wide), np.zeros(wide)
            for term, m in fired:
                lo[row, term] += m.lo
                hi[row, term] += m.hi
                down[row, term] += m.down
                up[row, term] += m.up
        else:
            down, up = np.full(wide, np.inf), np.full(wide, -np.inf)
            for term, m in fired:
                lo[row, term] = np.maximum(lo[row, term], m.lo)
                hi[row, term] = np.maximum(hi[row, term], m.hi)
            for term, m in fired:
                # Only a rule that can be the largest moves the level.
                counts = (m.hi >= lo[row, term])[:, None]
                down[row, term] = np.minimum(down[row, term], np.where(counts, m.down, np.inf))
                up[row, term] = np.maximum(up[row, term], np.where(counts, m.up, -np.inf))
            none = down > up
            down, up = np.where(none, 0.0, down), np.where(none, 0.0, up)
        return Moving(lo[:, :terms], hi[:, :terms], down[:, :terms], up[:, :terms])

    def _cells(self, n: int, degrees: list[list[Moving]], fired: list[list[tuple[Ints, Moving]]]) -> None:
        row = np.arange(n)
        found: list[list[Ints]] = []
        moves: list[list[Moving]] = []
        for terms in degrees:
            lo, hi, down, up = (
                np.stack(ends, axis=1) for ends in zip(*((m.lo, m.hi, m.down, m.up) for m in terms), strict=True)
            )
            found.append(by_degree(hi))
            moves.append([Moving(lo[row, k], hi[row, k], down[row, k], up[row, k]) for k in found[-1]])
        for which, named in cells_named(self.controller, found):
            m = self._both([parts[w] for parts, w in zip(moves, which, strict=True)])
            # A cell that cannot fire moves nothing, and its term's level is another rule's.
            m = Moving(m.lo, np.where(m.hi > 0, m.hi, -1.0), m.down, m.up)
            for o, terms_named in enumerate(named):
                fired[o].append((terms_named, m))

    def _both(self, parts: list[Moving]) -> Moving:
        if self.controller.infer.and_ == "min":
            return _smallest(parts)
        product = parts[0]
        for m in parts[1:]:
            product = _product(product, m)
        return product

    def _either(self, parts: list[Moving]) -> Moving:
        if self.controller.infer.or_ == "max":
            return _opposite(_smallest([_opposite(m) for m in parts]))
        none = _opposite(parts[0])
        for m in parts[1:]:
            none = _product(none, _opposite(m))
        return _opposite(none)

    def _sentence(self, node: Antecedent, degrees: list[list[Moving]]) -> Moving:
        match node:
            case Is(i, terms):
                return self._either([degrees[i][t] for t in terms])
            case Not(operand):
                return _opposite(self._sentence(operand, degrees))
            case And(operands):
                return self._both([self._sentence(o, degrees) for o in operands])
            case Or(operands):
                return self._either([self._sentence(o, degrees) for o in operands])
            case _:
                assert_never(node)


def _smallest(parts: list[Moving]) -> Moving:
    """Moves as one of those that can be the smallest."""
    lo: Floats = np.minimum.reduce([m.lo for m in parts])
    hi: Floats = np.minimum.reduce([m.hi for m in parts])
    counts = [(m.lo <= hi)[:, None] for m in parts]
    down: Floats = np.minimum.reduce([np.where(c, m.down, np.inf) for c, m in zip(counts, parts, strict=True)])
    up: Floats = np.maximum.reduce([np.where(c, m.up, -np.inf) for c, m in zip(counts, parts, strict=True)])
    return Moving(lo, hi, down, up)


def _opposite(m: Moving) -> Moving:
    """``1 - m``."""
    return Moving(1 - m.hi, 1 - m.lo, -m.up, -m.down)


def _product(a: Moving, b: Moving) -> Moving:
    """Of degrees, which are not negative."""
    one, two = _scaled(a.down, a.up, b.lo, b.hi), _scaled(b.down, b.up, a.lo, a.hi)
    return Moving(a.lo * b.lo, a.hi * b.hi, one[0] + two[0], one[1] + two[1])


def _scaled(down: Floats, up: Floats, lo: Floats, hi: Floats) -> tuple[Floats, Floats]:
    """Rates ``down .. up`` (B, D) times factors ``lo .. hi`` (B,)."""
    ends = [rate * factor[:, None] for rate in (down, up) for factor in (lo, hi)]
    return np.minimum.reduce(ends), np.maximum.reduce(ends)


class _Centroid:
    """``y' = sum over sets of sign c_S' (integral of t - y over the level set of S at c_S) / A``."""

    def __init__(self, output: Output, mean: CentroidBound, reached: float, steepest: float) -> None:
        self.mean = mean
        self.reached = reached
        self.sets = LevelSets(clipped_sets(output))
        # A breakpoint's float is not the breakpoint: between them a slope is its neighbour's.
        self.slack = len(self.sets.sign) * steepest * FLOAT_SLACK

    def rate(self, levels: Moving) -> Floats:
        y = self.mean.mean(levels.lo, levels.hi)
        area = self.mean.area_over(levels.lo, levels.hi, self.reached)
        shape = levels.down.shape[0], levels.down.shape[2]
        total_down, total_up = np.full(shape, -self.slack), np.full(shape, self.slack)
        heights = [_smallest([_term(levels, int(k)) for k in members]) for members in self.sets.members]
        lo, hi = np.stack([h.lo for h in heights], axis=1), np.stack([h.hi for h in heights], axis=1)
        low, high = self.sets.turn(lo, hi, y)
        for s, height in enumerate(heights):
            down, up = _scaled(height.down, height.up, low[:, s], high[:, s])
            total_down, total_up = total_down + down, total_up + up
        return _largest(total_down, total_up, area, levels.hi, self.reached)


class _Average:
    """``y' = sum of s_k' (z_k - y) / (sum of s_k)``."""

    def __init__(self, mean: AverageBound, reached: float) -> None:
        self.mean = mean
        self.reached = reached

    def rate(self, levels: Moving) -> Floats:
        y = self.mean.mean(levels.lo, levels.hi)
        area = np.maximum(levels.lo.sum(axis=1), self.reached) - FLOAT_SLACK
        shape = levels.down.shape[0], levels.down.shape[2]
        total_down, total_up = np.zeros(shape), np.zeros(shape)
        for k, place in enumerate(self.mean.places):
            m = _term(levels, k)
            down, up = _scaled(m.down, m.up, place - y[1], place - y[0])
            total_down, total_up = total_down + down, total_up + up
        return _largest(total_down, total_up, area, levels.hi, self.reached)


def _term(levels: Moving, k: int) -> Moving:
    return Moving(levels.lo[:, k], levels.hi[:, k], levels.down[:, k], levels.up[:, k])


def _largest(down: Floats, up: Floats, area: Floats, hi: Floats, reached: float) -> Floats:
    """The fastest rate of a mean, 0 where it is not taken and unbounded where its area may vanish."""
    fastest = np.maximum(np.abs(down), np.abs(up)).max(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.where(area > 0, fastest / area, np.inf)
    return np.where((hi < reached - FLOAT_SLACK).all(axis=1), 0.0, rate * (1 + FLOAT_SLACK))


class LevelSets:
    """Level sets of S sets of terms: width and first moment at any clip height, both falling with it."""

    def __init__(self, forms: tuple[ClippedSet, ...]) -> None:
        most = max(len(f.members) for f in forms)
        pieces = max(len(f.pieces) for f in forms)
        self.members = np.array([[*f.members, *f.members[:1] * (most - len(f.members))] for f in forms])
        """(S, members), the first one again where there are fewer."""
        self.sign = np.array([f.sign for f in forms])
        self.reference = np.array([float(f.reference) for f in forms])
        self.turned = np.array([f.moment_sign for f in forms])
        self.top = np.array([float(f.height) for f in forms])
        self.starts = np.full((len(forms), pieces), np.inf)
        self.width, self.first = np.zeros((len(forms), pieces, 2)), np.zeros((len(forms), pieces, 3))
        for s, f in enumerate(forms):
            self.starts[s, : len(f.pieces)] = [float(p.start) for p in f.pieces]
            self.width[s, : len(f.pieces)] = [[float(w) for w in p.width] for p in f.pieces]
            self.first[s, : len(f.pieces)] = [[float(v) for v in p.first] for p in f.pieces]

    def turn(self, lo: Floats, hi: Floats, y: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
        """Least and largest integral of ``t - y`` (B,) over each level set at a height in ``lo .. hi`` (B, S), signed
        as the set is."""
        wide, first = self._at(lo, "left")
        narrow, last = self._at(hi, "right")
        arms = [(self.reference - at[:, None]) * w for at in y for w in (narrow, wide)]
        least = np.minimum.reduce(arms) + np.where(self.turned > 0, last, -first) * (self.turned != 0) - FLOAT_SLACK
        most = np.maximum.reduce(arms) + np.where(self.turned > 0, first, -last) * (self.turned != 0) + FLOAT_SLACK
        return np.where(self.sign > 0, least, -most), np.where(self.sign > 0, most, -least)

    def _at(self, c: Floats, side: Literal["left", "right"]) -> tuple[Floats, Floats]:
        """Widths and first moments in the limit from below (``left``) or above."""
        begun = self.starts < c[:, :, None] if side == "left" else self.starts <= c[:, :, None]
        j = np.maximum(begun.sum(axis=2) - 1, 0)
        each = np.arange(len(self.starts))
        w, v = self.width[each, j], self.first[each, j]
        inside = c <= self.top if side == "left" else c < self.top
        width = np.where(inside, w[:, :, 0] + w[:, :, 1] * c, 0.0)
        first = np.where(inside, v[:, :, 0] + (v[:, :, 1] + v[:, :, 2] * c) * c, 0.0)
        return np.maximum(width, 0.0), np.maximum(first, 0.0)


def fastest_interpolation(strengths: Strengths, output: int) -> list[float]:
    """How far a multilinear interpolation moves at most while its inputs move by their errors: the inputs' parts.

    Along each input it is linear between two peaks, so the sum of its rates' sizes is largest at a corner of a cell.
    """
    controller = strengths.controller
    cells, variable = controller.cells, controller.outputs[output].variable
    assert cells is not None
    shapes = [t.shape for t in controller.outputs[output].terms]
    places = np.array(
        [float((s.at - variable.lo) / (variable.hi - variable.lo)) for s in shapes if isinstance(s, Singleton)]
    )
    table = places[np.array(cells.consequents[output])].reshape(cells.shape)
    parts: list[Floats] = []
    for i, (item, error) in enumerate(zip(controller.inputs, strengths.errors, strict=True)):
        assert item.peaks is not None
        gaps = np.diff(
            np.array([float((p - item.variable.lo) / (item.variable.hi - item.variable.lo)) for p in item.peaks])
        )
        along = np.abs(np.diff(np.moveaxis(table, i, -1), axis=-1)) * (error / gaps)
        edge = [(0, 0)] * (along.ndim - 1)
        either = np.maximum(np.pad(along, [*edge, (1, 0)]), np.pad(along, [*edge, (0, 1)]))
        parts.append(np.moveaxis(either, -1, i))
    corner = np.unravel_index(int(np.sum(parts, axis=0).argmax()), cells.shape)
    return [float(p[corner]) * (1 + FLOAT_SLACK) for p in parts]
