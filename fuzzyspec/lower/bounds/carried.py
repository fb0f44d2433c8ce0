"""The bound of a controller whose inputs carry errors: its own at its raws' values, and how far theirs move it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from fuzzyspec.fixed.certificate import Dominant
from fuzzyspec.lower.bounds import orders, slopes
from fuzzyspec.lower.bounds.dominant import added_up, carried_on
from fuzzyspec.lower.bounds.memberships import Floats
from fuzzyspec.lower.bounds.outputs import AverageBound, CentroidBound
from fuzzyspec.lower.bounds.search import (
    CHUNK,
    ControllerBounds,
    Effort,
    Search,
    bound_at_once,
    decision_bands,
    means,
    reason_of,
    strength_error,
)
from fuzzyspec.lower.bounds.strengths import Boxes, Strengths
from fuzzyspec.lower.controller import ControllerNumbers
from fuzzyspec.lower.multilinear import MultilinearNumbers

LARGE = Fraction(1, 100)
"""Errors above this part of the range are derived in both ways."""
A_BOX = 128
"""Rules times directions of a box of ordinary cost: four inputs of two active terms, all of them off."""


def bound_controller(
    numbers: ControllerNumbers,
    input_errors: tuple[Fraction, ...],
    effort: Effort,
    prepared: tuple[CentroidBound | AverageBound, ...] | None = None,
    alone: ControllerBounds | None = None,
    raws: tuple[tuple[int, int], ...] | None = None,
) -> ControllerBounds:
    """|integer program - exact| of every output over all inputs, each input off by at most its error (in its unit).

    ``prepared`` are the controller's :func:`means`, where it is bounded more than once; ``alone`` its bounds for inputs
    without error, where they are known. ``raws``, where given, are by input the smallest and the largest that it is
    called with.
    """
    legal = tuple((i.variable.raw.lo, i.variable.raw.hi) for i in numbers.controller.inputs)
    if raws == legal:
        raws = None
    relative = tuple(
        float(e / (i.variable.hi - i.variable.lo)) * (1 + 2.0**-50)
        for e, i in zip(input_errors, numbers.controller.inputs, strict=True)
    )
    strengths = Strengths(numbers, relative, raws)
    outputs = list(means(numbers)) if prepared is None else list(prepared)
    if any(relative) and not slopes.applies(strengths):
        return bound_at_once(strengths, outputs, effort)
    if alone is None or raws is not None:
        alone = _alone(strengths.off_by((0.0,) * len(relative)), outputs, effort)
    if not any(relative):
        return alone
    return _carried(strengths, outputs, effort, alone)


def _alone(strengths: Strengths, outputs: list[CentroidBound | AverageBound], effort: Effort) -> ControllerBounds:
    """The bounds for inputs without error: at once or, where orders decide, by the same lemma for rounded degrees.

    What then follows from the rounded degrees is looked at as if these were exact, over all that they can be.
    """
    controller = strengths.controller
    if not orders.applies(controller) or any(isinstance(n, MultilinearNumbers) for n in strengths.numbers.outputs):
        return bound_at_once(strengths, outputs, effort)
    found = _Exact(strengths, outputs, effort).run()
    assert found.boxes is not None
    errors: dict[str, Fraction] = {}
    reasons: dict[str, str] = {}
    dominants: dict[str, Dominant | None] = {}
    for o, (output, mean) in enumerate(zip(controller.outputs, outputs, strict=True)):
        assert isinstance(mean, CentroidBound)
        span = output.variable.hi - output.variable.lo
        lemma = orders.Fastest(output, mean, orders.pieces_of(strengths, o, orders.rounded(strengths), beyond=True))
        degrees, worst = lemma.search(effort.boxes)
        at, shares = orders.place(controller, worst, lemma.shares(worst))
        bound = (degrees + found.worst[o]) * (1 + 2.0**-40)
        errors[output.name] = min(Fraction(bound), Fraction(1)) * span
        _, rounding, tail = found.parts[o]
        reasons[output.name] = reason_of((degrees, rounding, tail))
        dominants[output.name] = added_up(
            strengths, o, (Boxes(at, at), shares), (found.boxes.some([o]), rounding, tail)
        )
    certified = {o.name: errors[o.name] < o.variable.hi - o.variable.lo for o in controller.outputs}
    return ControllerBounds(errors, reasons, certified, decision_bands(strengths.numbers, strengths), dominants)


class _Exact(Search):
    """The largest error from exact degrees on: these may be what no raw has, as far beyond as they are rounded."""

    def __init__(self, strengths: Strengths, outputs: list[CentroidBound | AverageBound], effort: Effort) -> None:
        super().__init__(strengths.alone(None), outputs, effort)
        self.rounded = strengths

    def ends(self, i: int) -> tuple[float, float]:
        low, high = self.rounded.around(i)
        own = float(max(self.rounded.numbers.degree_errors[i]))
        return max(0.0, low - own), min(1.0, high + own)

    def raws(self, i: int) -> tuple[float, float] | None:
        return None


def _carried(
    strengths: Strengths, outputs: list[CentroidBound | AverageBound], effort: Effort, alone: ControllerBounds
) -> ControllerBounds:
    """Lemma "slope": to what the program is off by at the values of its raws comes how far these are carried on."""
    numbers, controller = strengths.numbers, strengths.controller
    errors: dict[str, Fraction] = {}
    reasons: dict[str, str] = {}
    dominants: dict[str, Dominant | None] = {}
    moved = fastest(strengths, outputs, effort)
    spans = {o.name: o.variable.hi - o.variable.lo for o in controller.outputs}
    for o, (name, span) in enumerate(spans.items()):
        own, carried = alone.errors[name], Fraction(min(moved[o].far, 1.0)) * span
        errors[name] = min(own + carried, span)
        share = round(100 * carried / (own + carried or 1))
        reasons[name] = f"errors of its inputs {share} %, its own {100 - share} %"
        dominants[name] = alone.dominants[name]
        if carried > own:
            at = carried_on(strengths, o, moved[o].box, moved[o].shares)
            dominants[name] = replace(at, percent=at.percent * share // 100)
    if any(errors[name] > span * LARGE for name, span in spans.items()):
        # Not every degree goes on moving when an input is far off.
        other = bound_at_once(strengths, outputs, effort)
        for name in errors:
            if other.errors[name] <= errors[name]:
                errors[name], reasons[name] = other.errors[name], other.reasons[name]
                dominants[name] = other.dominants[name]
    certified = {name: errors[name] < span for name, span in spans.items()}
    return ControllerBounds(errors, reasons, certified, decision_bands(numbers, strengths), dominants)


@dataclass(frozen=True)
class Moved:
    """How ``far`` an output moves at most, relative to its range, in which box, and the inputs' ``shares`` of it."""

    far: float
    box: Boxes
    shares: list[float]


def fastest(strengths: Strengths, outputs: list[CentroidBound | AverageBound], effort: Effort) -> list[Moved]:
    """How far each output moves at most while the inputs move by their errors."""
    numbers, controller = strengths.numbers, strengths.controller
    if any(isinstance(n, MultilinearNumbers) for n in numbers.outputs):
        anywhere = Boxes(np.zeros((1, len(controller.inputs))), np.ones((1, len(controller.inputs))))
        interpolated = [slopes.fastest_interpolation(strengths, o) for o in range(len(controller.outputs))]
        return [Moved(sum(shares), anywhere, shares) for shares in interpolated]
    if orders.applies(controller):
        found = []
        for o, mean in enumerate(outputs):
            assert isinstance(mean, CentroidBound)
            lemma = orders.Fastest(controller.outputs[o], mean, orders.pieces_of(strengths, o, orders.slid(strengths)))
            far, worst = lemma.search(2 * effort.boxes)
            at, shares = orders.place(controller, worst, lemma.shares(worst))
            found.append(Moved(far, Boxes(at, at), shares))
        return found
    off = strength_error(numbers, strengths)
    reached = tuple(
        float(min(controller.fires_at, numbers.fires_at) if sure else numbers.fires_at - off)
        for sure in controller.always_fires
    )
    search = _Steepest(strengths, outputs, reached, _affordable(strengths, effort))
    steepest = search.run()
    if steepest.boxes is None:
        anywhere = Boxes(np.zeros((1, len(controller.inputs))), np.ones((1, len(controller.inputs))))
        return [Moved(1.0, anywhere, list(strengths.errors)) for _ in outputs]
    return [
        Moved(far, steepest.boxes.some([o]), search.shares(steepest.boxes.some([o]), o))
        for o, far in enumerate(steepest.worst)
    ]


def _affordable(strengths: Strengths, effort: Effort) -> Effort:
    """As many boxes as take no longer where rules or directions are many."""
    moving = sum(1 for e in strengths.errors if e)
    rules = len(strengths.controller.sentences)
    if strengths.controller.cells is not None:
        rules += 1 << len(strengths.errors)
    boxes = effort.boxes * A_BOX // max(A_BOX, rules << (moving - 1))
    return replace(effort, boxes=boxes, first=min(effort.first, boxes))


class _Steepest(Search):
    """The largest move over all exact inputs, which may lie beyond the legal raws."""

    def __init__(
        self,
        strengths: Strengths,
        outputs: list[CentroidBound | AverageBound],
        reached: tuple[float, ...],
        effort: Effort,
    ) -> None:
        # An interval of inputs is looked at as it is; that they are off is what moves them.
        super().__init__(strengths.off_by((0.0,) * len(strengths.errors)), outputs, effort)
        self.carrying = strengths
        self.reached = reached
        self.moves = slopes.Slopes(strengths, outputs, reached)

    def ends(self, i: int) -> tuple[float, float]:
        return self.carrying.around(i)

    def raws(self, i: int) -> tuple[float, float] | None:
        return None

    def evaluate(self, boxes: Boxes) -> tuple[Floats, Floats]:
        parts = [slice(start, start + CHUNK) for start in range(0, len(boxes), CHUNK)]
        found = np.concatenate([self.moves.rates(Boxes(boxes.lo[p], boxes.hi[p])) for p in parts])
        return np.minimum(found, 1.0), np.zeros((*found.shape, 3))

    def shares(self, box: Boxes, output: int) -> list[float]:
        """How far each input's error alone moves an output."""
        found = []
        for i, e in enumerate(self.carrying.errors):
            one = self.carrying.off_by(tuple(e if k == i else 0.0 for k in range(len(self.carrying.errors))))
            moves = slopes.Slopes(one, self.outputs, self.reached) if e else None
            found.append(min(float(moves.rates(box)[0, output]), 1.0) if moves else 0.0)
        return found
