"""Coverage: how weak the strongest rule that sets an output can get, over the whole input range."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from fuzzyspec.check.bounding import bounded_floor
from fuzzyspec.check.degrees import Side, core, degree
from fuzzyspec.check.lattice import Literal, critical_places, lattice_floor
from fuzzyspec.check.quantities import at_least, at_most, quantity
from fuzzyspec.check.strength import ONE, ZERO, Setters, Spot, conjunction, setters_of, strongest
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Span
from fuzzyspec.model.controller import CellRules, Controller, Inference, Input, Output, SentenceRule


@dataclass(frozen=True)
class Floor:
    """No input has a strongest strength below ``proved``; ``seen`` is the strength at ``spot`` (or its limit there).

    The two are the same where the floor is known exactly.
    """

    proved: Fraction
    seen: Fraction
    spot: Spot

    @property
    def exact(self) -> bool:
        return self.proved == self.seen


def controller_floors(controller: Controller) -> tuple[Floor, ...]:
    """The coverage floor of each output."""
    return floors(
        controller.inputs,
        len(controller.outputs),
        controller.infer,
        controller.fires_at,
        controller.cells,
        controller.sentences,
    )


def floors(
    inputs: tuple[Input, ...],
    outputs: int,
    infer: Inference,
    fires_at: Fraction,
    cells: CellRules | None,
    sentences: tuple[SentenceRule, ...],
) -> tuple[Floor, ...]:
    """The coverage floor of each output; outputs set by the same rules share the work."""
    known: dict[tuple[bytes, tuple[SentenceRule, ...]], Floor] = {}
    found = []
    for output in range(outputs):
        setters = setters_of(output, inputs, infer, cells, sentences)
        key = (b"" if setters.cells is None else setters.cells.tobytes(), setters.sentences)
        if key not in known:
            known[key] = floor(setters, fires_at)
        found.append(known[key])
    return tuple(found)


def floor(setters: Setters, fires_at: Fraction) -> Floor:
    """The infimum of the strongest strength, by the first way that applies.

    Complete cells: ``and`` is monotone in each input, so the best cell takes the best term of each input and the
    floor is the ``and`` over the inputs of the least best degree (1/2 each in a strong partition). Cells with a hole:
    often nothing fires at its peaks. Min and max alone: exactly, over a finite grid. Else: branch and bound.
    """
    if setters.cells is not None and setters.cells.all() and not setters.sentences:
        lows = [least_best(v, i, setters.inputs) for i, v in enumerate(setters.inputs)]
        value = conjunction([low for low, _, _ in lows], setters.infer)
        spot = Spot(tuple(x for _, x, _ in lows), tuple(side for _, _, side in lows))
        return Floor(value, value, spot)
    starts = _first_looks(setters)
    for spot in starts:
        if strongest(setters, spot) == 0:
            return Floor(ZERO, ZERO, _settle(setters, spot))
    exactly = lattice_floor(setters)
    if exactly is not None:
        value, spot = exactly
        return Floor(value, value, _settle(setters, spot))
    bounded = bounded_floor(setters, fires_at, starts)
    return Floor(bounded.proved, bounded.seen, bounded.spot)


def least_best(variable: Input, index: int, inputs: tuple[Input, ...]) -> tuple[Fraction, Fraction, Side]:
    """Where the best degree of an input is least: that degree, the place and the side of it."""
    literals = [Literal(index, t, False, ONE) for t in range(len(variable.terms))]
    places = critical_places(variable, literals, inputs)
    best = [(max(degree(t.shape, x, side) for t in variable.terms), x, side) for x, side in places]
    return min(best, key=lambda found: found[0])


def prove_firing(
    inputs: tuple[Input, ...],
    outputs: tuple[Output, ...],
    infer: Inference,
    fires_at: Fraction,
    cells: CellRules | None,
    sentences: tuple[SentenceRule, ...],
    span: Span,
    report: Callable[[Diagnostic], None],
) -> tuple[bool, ...]:
    """Which outputs always fire; one that may not, and has no ``otherwise``, is reported."""
    found = floors(inputs, len(outputs), infer, fires_at, cells, sentences)
    for output, low in zip(outputs, found, strict=True):
        if low.proved < fires_at and output.fallback is None:
            report(_silent(output, low, inputs, fires_at, span))
    return tuple(low.proved >= fires_at for low in found)


def show_spot(spot: Spot, inputs: tuple[Input, ...], used: tuple[bool, ...]) -> dict[str, str]:
    """A spot as printed values by input; inputs that do not matter are left out."""
    words = {-1: "just below ", 0: "", 1: "just above "}
    return {
        v.name: words[side] + quantity(x, v.variable.unit)
        for v, x, side, matters in zip(inputs, spot.at, spot.sides, used, strict=True)
        if matters
    }


def _silent(output: Output, low: Floor, inputs: tuple[Input, ...], fires_at: Fraction, span: Span) -> Diagnostic:
    point = show_spot(low.spot, inputs, (True,) * len(inputs))
    where = ", ".join(f"{name} = {value}" for name, value in point.items())
    if low.seen < fires_at:
        idle = [
            v
            for v, x, side in zip(inputs, low.spot.at, low.spot.sides, strict=True)
            if all(degree(t.shape, x, side) < fires_at for t in v.terms)
        ]
        said = "no rule fires" if low.seen == 0 else f"the strongest rule only reaches {at_most(low.seen)}"
        return Diagnostic(
            "FZ324",
            f"nothing fires for output `{output.name}` at some inputs",
            output.variable.span,
            label=f"{said} at the input below",
            labels=tuple(Label(v.variable.span, "no term of this input covers that value") for v in idle),
            help=f"cover it with a rule, or give `{output.name}` an `otherwise`",
            notes=(f"an output fires where the strongest of its rules reaches {fires_at} (`fires at`)",),
            point=point,
        )
    return Diagnostic(
        "FZ325",
        f"it could not be proved that a rule for output `{output.name}` always fires",
        output.variable.span,
        label=f"no strength below {at_least(low.proved)} is possible; {at_most(low.seen)} was seen at {where}",
        labels=(Label(span, "in this controller"),),
        help=f"give `{output.name}` an `otherwise`, or rules that overlap more",
        point=point,
    )


def _first_looks(setters: Setters) -> tuple[Spot, ...]:
    """Spots worth looking at first: the peaks of a few cells that do not set the output, and the middle."""
    sides = (0,) * len(setters.inputs)
    spots = [Spot(tuple((v.variable.lo + v.variable.hi) / 2 for v in setters.inputs), sides)]
    if setters.cells is not None:
        holes = np.argwhere(~setters.cells)
        for hole in holes[:: max(1, len(holes) // 32)]:
            spots.append(Spot(tuple(core(v, int(t)) for v, t in zip(setters.inputs, hole, strict=True)), sides))
    return tuple(spots)


def _settle(setters: Setters, spot: Spot) -> Spot:
    """A spot no stronger than the given one that lies inside a gap rather than on its edge, one input at a time."""
    value = strongest(setters, spot)
    for i, variable in enumerate(setters.inputs):
        literals = [Literal(i, t, False, ONE) for t in range(len(variable.terms))]
        corners = sorted({x for x, _ in critical_places(variable, literals, setters.inputs)} | {spot.at[i]})
        middles = [(a + b) / 2 for a, b in itertools.pairwise(corners)]
        places = sorted({*corners, *middles})
        low = [strongest(setters, _moved(spot, i, x)) <= value for x in places]
        runs = _runs(low)
        if not runs:
            continue
        start, end = max(runs, key=lambda run: places[run[1]] - places[run[0]])
        x = places[start] if start == end else places[(start + end) // 2]
        if spot.sides[i] or x != spot.at[i]:
            spot = _moved(spot, i, x)
    return spot


def _moved(spot: Spot, axis: int, x: Fraction) -> Spot:
    at, sides = list(spot.at), list(spot.sides)
    at[axis], sides[axis] = x, 0
    return replace(spot, at=tuple(at), sides=tuple(sides))


def _runs(flags: list[bool]) -> list[tuple[int, int]]:
    """First and last index of every run of True."""
    found: list[tuple[int, int]] = []
    for index, flag in enumerate(flags):
        if flag and found and found[-1][1] == index - 1:
            found[-1] = (found[-1][0], index)
        elif flag:
            found.append((index, index))
    return found
