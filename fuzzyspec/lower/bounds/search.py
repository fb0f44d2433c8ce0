"""The largest error over all inputs: boxes are split where their bound is worst, until it cannot get much better.

Every box's bound holds for all its inputs, so the largest over the boxes is a certificate whenever the search stops;
splitting only makes it tighter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from fuzzyspec.fixed.certificate import Band as DecisionBand
from fuzzyspec.fixed.certificate import Dominant
from fuzzyspec.lower.bounds.dominant import dominant, dominant_edge, otherwise_rounded
from fuzzyspec.lower.bounds.memberships import Floats
from fuzzyspec.lower.bounds.outputs import AverageBound, CentroidBound, Parts
from fuzzyspec.lower.bounds.strengths import Boxes, Strengths
from fuzzyspec.lower.centroid import CentroidNumbers
from fuzzyspec.lower.controller import ControllerNumbers
from fuzzyspec.lower.multilinear import MultilinearNumbers

CLOSE_ENOUGH = 1.05
"""Stop where the bound is within this factor of the lemma's own value at a single point."""
CHUNK = 4096
NARROWEST = 2.0**-22
"""A box over which no degree moves by more is not split: what is left there is a jump, or rounding."""
LITTLE = 2.0**-20
"""Of a raw's step: far more than float64 leaves open about where a raw lies, far less than lies between two."""


@dataclass(frozen=True)
class Effort:
    """How many boxes may be looked at, and how many cells of one box (else there is no bound)."""

    boxes: int
    first: int = 8192
    cells: int = 1024


@dataclass(frozen=True)
class ControllerBounds:
    """By output: the error in the output's unit (the range's width where none could be had), and why."""

    errors: dict[str, Fraction]
    reasons: dict[str, str]
    certified: dict[str, bool]
    bands: tuple[DecisionBand, ...]
    dominants: dict[str, Dominant | None]


def means(numbers: ControllerNumbers) -> tuple[CentroidBound | AverageBound, ...]:
    """What is known of each output's mean, whatever the errors of the inputs."""
    fires = float(numbers.fires_at)
    return tuple(
        CentroidBound(o, n, fires, sure) if isinstance(n, CentroidNumbers) else AverageBound(o, n, fires, sure)
        for o, n, sure in zip(numbers.controller.outputs, numbers.outputs, numbers.controller.always_fires, strict=True)
        if not isinstance(n, MultilinearNumbers)
    )


def bound_at_once(
    strengths: Strengths, outputs: list[CentroidBound | AverageBound], effort: Effort
) -> ControllerBounds:
    """Every degree off by its own rounding and by what its input's error does to it, which may be all.

    ``outputs`` are the controller's :func:`means`.
    """
    numbers, controller = strengths.numbers, strengths.controller
    if any(isinstance(n, MultilinearNumbers) for n in numbers.outputs):
        return _multilinear(numbers, strengths)
    search = Search(strengths, outputs, effort)
    found = search.run()
    errors: dict[str, Fraction] = {}
    reasons: dict[str, str] = {}
    certified: dict[str, bool] = {}
    dominants: dict[str, Dominant | None] = {}
    for o, output in enumerate(controller.outputs):
        span = output.variable.hi - output.variable.lo
        bound = found.worst[o] * (1 + 2.0**-40)
        certified[output.name] = bound < 1
        error = Fraction(min(bound, 1.0)) * span
        dominants[output.name] = (
            None if found.boxes is None else dominant(strengths, outputs[o], o, found.boxes.some([o]))
        )
        if output.fallback is not None and not output.fallback.hold:
            raw = output.variable.raw
            rounded = abs(raw.value(raw.nearest(output.fallback.value)) - output.fallback.value)
            if rounded > error:
                error, dominants[output.name] = rounded, otherwise_rounded(output)
        errors[output.name] = error
        reasons[output.name] = (
            reason_of(found.parts[o]) if bound < 1 else search.failure or _why_none(controller.outputs[o].name)
        )
    return ControllerBounds(errors, reasons, certified, decision_bands(numbers, strengths), dominants)


def _multilinear(numbers: ControllerNumbers, strengths: Strengths) -> ControllerBounds:
    """Lemma "multilinear": an interpolation moves along an input by at most its edge times the degree's error."""
    controller = numbers.controller
    off = [Fraction(strengths.farthest(i)) for i in range(len(controller.inputs))]
    errors: dict[str, Fraction] = {}
    reasons: dict[str, str] = {}
    certified: dict[str, bool] = {}
    dominants: dict[str, Dominant | None] = {}
    for output, found in zip(controller.outputs, numbers.outputs, strict=True):
        assert isinstance(found, MultilinearNumbers)
        span = output.variable.hi - output.variable.lo
        moved = sum((e * d for e, d in zip(found.edges, off, strict=True)), Fraction(0))
        rounded = found.rounding * abs(output.variable.raw.step) / span
        errors[output.name] = min(moved + rounded, Fraction(1)) * span
        reasons[output.name] = reason_of((float(moved), float(rounded), 0.0))
        certified[output.name] = moved + rounded < 1
        dominants[output.name] = dominant_edge(controller, output, found.edges, off, rounded)
    return ControllerBounds(errors, reasons, certified, decision_bands(numbers, strengths), dominants)


def _why_none(name: str) -> str:
    return f"the area of {name} can come too near 0 for the errors of its degrees"


def reason_of(parts: tuple[float, float, float]) -> str:
    """The parts of a bound in words."""
    total = sum(parts) or 1.0
    shares = [round(100 * p / total) for p in parts]
    return f"degrees {shares[0]} %, areas and moments {shares[1]} %, quotient and rounding {shares[2]} %"


def strength_error(numbers: ControllerNumbers, strengths: Strengths) -> Fraction:
    """How far a rule's strength can be off, over all inputs."""
    controller = numbers.controller
    ends = np.array([strengths.around(i) for i in range(len(controller.inputs))])
    degrees = strengths.degrees(Boxes(ends[None, :, 0], ends[None, :, 1]))
    off = [max(float(b.off.max()) for b in row) for row in degrees]
    joined = max(off) if controller.infer.and_ == "min" else sum(off)
    cells = Fraction(joined) + numbers.cell_error if controller.cells is not None else Fraction(0)
    for rule, error in zip(controller.sentences, numbers.sentence_errors, strict=True):
        spoken = float(strengths.sentence(rule.antecedent, degrees).off.max())
        cells = max(cells, Fraction(spoken) + error)
    return cells


def decision_bands(numbers: ControllerNumbers, strengths: Strengths) -> tuple[DecisionBand, ...]:
    """How close strengths must be for the two meanings to decide differently about them."""
    controller = numbers.controller
    cells = strength_error(numbers, strengths)
    bands: list[DecisionBand] = []
    for output, sure in zip(controller.outputs, controller.always_fires, strict=True):
        if not sure:
            width = cells + abs(numbers.fires_at - controller.fires_at)
            bands.append(DecisionBand(f"fires.{output.name}", f"whether {output.name} fires", width))
    if controller.behaviors:
        width = 2 * cells
        if not any(controller.always_fires):
            width += abs(numbers.fires_at - controller.fires_at)
        if width:
            bands.append(DecisionBand("acting", "which behavior acts", width))
    return tuple(bands)


@dataclass(frozen=True)
class Found:
    """By output: the bound relative to the range, its parts where it is reached, and (None without any) that box."""

    worst: list[float]
    parts: list[tuple[float, float, float]]
    boxes: Boxes | None


class Search:
    """Boxes of a controller's inputs, split where their bound is worst."""

    def __init__(self, strengths: Strengths, outputs: list[CentroidBound | AverageBound], effort: Effort) -> None:
        self.strengths = strengths
        self.outputs = outputs
        self.effort = effort
        self.failure = ""

    def run(self) -> Found:
        """The certified bound of each output, relative to its range."""
        boxes = self._first()
        if boxes is None:
            return Found([math.inf] * len(self.outputs), [(0.0, 0.0, 0.0)] * len(self.outputs), None)
        total, parts = self.evaluate(boxes)
        looked = len(boxes)
        floor, at = self._points(boxes, total)
        while looked < self.effort.boxes:
            over = total / np.maximum(floor * CLOSE_ENOUGH, 1e-300)
            score = over.max(axis=1)
            wide = self.strengths.travel(boxes).max(axis=1) > NARROWEST
            open_ = np.flatnonzero((score > 1) & wide)
            if not len(open_):
                break
            room = max(1, min(len(open_), (self.effort.boxes - looked) // 2, CHUNK))
            chosen = open_[np.argsort(-score[open_], kind="stable")[:room]]
            children = self._split(boxes, chosen)
            more, more_parts = self.evaluate(children)
            if len(children):
                higher, where = self._points(children, more)
                at = np.where((higher > floor)[:, None], where, at)
                floor = np.maximum(floor, higher)
            keep = np.ones(len(boxes), dtype=bool)
            keep[chosen] = False
            # A box that is already below what some point needs will never be the worst one.
            keep &= score > 1
            boxes = boxes.some(keep).and_(children)
            closed = (total * (~keep & (score <= 1))[:, None]).max(axis=0, initial=0.0)
            floor = np.maximum(floor, closed / CLOSE_ENOUGH)
            total = np.concatenate([total[keep], more])
            parts = np.concatenate([parts[keep], more_parts])
            looked += 2 * len(chosen)
        bounds = np.maximum(total.max(axis=0, initial=0.0), floor * CLOSE_ENOUGH)
        if not len(total):
            return Found([float(b) for b in bounds], [(0.0, 0.0, 0.0)] * len(bounds), Boxes(at, at))
        worst = total.argmax(axis=0)
        shares = [tuple(float(p) for p in parts[w, o]) for o, w in enumerate(worst)]
        return Found([float(b) for b in bounds], [(a, b, c) for a, b, c in shares], boxes.some(worst))

    def _first(self) -> Boxes | None:
        cuts: list[Floats] = []
        for i, terms in enumerate(self.strengths.terms):
            low, high = self.ends(i)
            inner = {float(x) for m in terms for x in m.x if low < x < high}
            cuts.append(np.array([low, *sorted(inner), high]))
        while math.prod(len(c) - 1 for c in cuts) > self.effort.first:
            i = max(range(len(cuts)), key=lambda k: len(cuts[k]))
            cuts[i] = np.concatenate([cuts[i][:-1:2], cuts[i][-1:]])
        grids_lo = np.meshgrid(*(c[:-1] for c in cuts), indexing="ij")
        grids_hi = np.meshgrid(*(c[1:] for c in cuts), indexing="ij")
        boxes = Boxes(np.stack([g.ravel() for g in grids_lo], axis=1), np.stack([g.ravel() for g in grids_hi], axis=1))
        boxes = self._around_raws(boxes)
        if self.strengths.controller.cells is not None:
            active = math.prod(
                int((np.stack([b.hi for b in row], axis=1) > 0).sum(axis=1).max())
                for row in self.strengths.degrees(boxes)
            )
            if active > self.effort.cells:
                self.failure = f"up to {active} cells fire at once, more than the {self.effort.cells} that are followed"
                return None
        return boxes

    def ends(self, i: int) -> tuple[float, float]:
        """What an input is looked at over, relative to its range."""
        return self.strengths.legal(i)

    def raws(self, i: int) -> tuple[float, float] | None:
        """The first legal raw of an input and their distance, relative to its range; None where any value counts."""
        variable = self.strengths.controller.inputs[i].variable
        return self.strengths.legal(i)[0], float(abs(variable.raw.step) / (variable.hi - variable.lo))

    def _around_raws(self, boxes: Boxes) -> Boxes:
        """What of the boxes holds raws: each drawn in to a little before its first and behind its last."""
        lo, hi = boxes.lo.copy(), boxes.hi.copy()
        some = np.ones(len(boxes), dtype=np.bool_)
        for i in range(lo.shape[1]):
            grid = self.raws(i)
            if grid is None:
                continue
            start, step = grid
            first = np.ceil((lo[:, i] - start) / step - LITTLE)
            last = np.floor((hi[:, i] - start) / step + LITTLE)
            some &= first <= last
            lo[:, i] = np.maximum(lo[:, i], start + (first - LITTLE) * step)
            hi[:, i] = np.minimum(hi[:, i], start + (last + LITTLE) * step)
        return Boxes(lo[some], hi[some])

    def _points(self, boxes: Boxes, total: Floats) -> tuple[Floats, Floats]:
        """The lemma's value at the middle of the worst boxes, what no splitting gets below; and the inputs there."""
        count = min(len(boxes), 64)
        chosen = np.unique(
            np.concatenate([np.argsort(-total[:, o], kind="stable")[:count] for o in range(total.shape[1])])
        )
        middle = (boxes.lo[chosen] + boxes.hi[chosen]) / 2
        for i in range(middle.shape[1]):
            grid = self.raws(i)
            if grid is not None:
                middle[:, i] = grid[0] + np.round((middle[:, i] - grid[0]) / grid[1]) * grid[1]
        found, _ = self.evaluate(Boxes(middle, middle))
        return found.max(axis=0), middle[found.argmax(axis=0)]

    def _split(self, boxes: Boxes, chosen: np.typing.NDArray[np.int64]) -> Boxes:
        lo, hi = boxes.lo[chosen], boxes.hi[chosen]
        side = self.strengths.travel(boxes.some(chosen)).argmax(axis=1)
        row = np.arange(len(chosen))
        middle = (lo[row, side] + hi[row, side]) / 2
        left_hi, right_lo = hi.copy(), lo.copy()
        left_hi[row, side] = middle
        right_lo[row, side] = middle
        return self._around_raws(Boxes(np.concatenate([lo, right_lo]), np.concatenate([left_hi, hi])))

    def evaluate(self, boxes: Boxes) -> tuple[Floats, Floats]:
        """Bounds (B, outputs) and their parts (B, outputs, 3)."""
        totals: list[Floats] = [np.zeros((0, len(self.outputs)))]
        pieces: list[Floats] = [np.zeros((0, len(self.outputs), 3))]
        for start in range(0, len(boxes), CHUNK):
            part = slice(start, start + CHUNK)
            levels = self.strengths.levels(Boxes(boxes.lo[part], boxes.hi[part]))
            found: list[Parts] = [o.parts(band) for o, band in zip(self.outputs, levels, strict=True)]
            totals.append(np.stack([p.total for p in found], axis=1))
            pieces.append(
                np.stack(
                    [np.stack([p.degrees, p.rounding, np.full(len(p.degrees), p.tail)], axis=1) for p in found], axis=1
                )
            )
        return np.concatenate(totals), np.concatenate(pieces)
