"""What one call of a controller means, in float64 over any number of cases."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from fuzzyspec.exact.centroid import single, union
from fuzzyspec.exact.firing import Fired, Levels, fired
from fuzzyspec.exact.result import Arrays, Bools, Exact, Floats, Ints
from fuzzyspec.model.controller import Controller, Inference, Output
from fuzzyspec.model.term import Singleton

_CHUNK = 1 << 14
"""Cases at a time: bounds the memory, and a chunk's arrays stay in the cache."""


def evaluate_controller(
    controller: Controller, inputs: Arrays, decisions: Arrays | None = None, state: Arrays | None = None
) -> Exact:
    """The exact meaning of one call.

    ``inputs``: a value an input, in the declared unit, (N,) or scalar; outside the range they saturate. ``decisions``
    (``fires.<output>``, ``acting``) are taken where given, -1 standing for not given. ``state``: what
    each output that holds held, else its initial value. Where the definitions give no value (all that fired has no
    area, and there is no ``otherwise``) there is nan. Raises KeyError for a missing input.
    """
    known = {i.name: inputs[i.name] for i in controller.inputs}
    held = {o.name: value for o in controller.outputs if (value := _fallback(o, state or {})) is not None}
    taken = {key: value for key, value in (decisions or {}).items() if key in _keys(controller)}
    cases = np.broadcast_shapes((1,), *(np.shape(v) for group in (known, held, taken) for v in group.values()))
    values = [
        np.broadcast_to(np.clip(known[i.name], float(i.variable.lo), float(i.variable.hi)), cases)
        for i in controller.inputs
    ]
    held_floats = {name: np.broadcast_to(np.asarray(v, dtype=np.float64), cases) for name, v in held.items()}
    taken_ints = {key: np.broadcast_to(np.asarray(v, dtype=np.int64), cases) for key, v in taken.items()}
    parts = [
        _chunk(
            controller,
            [v[part] for v in values],
            {key: v[part] for key, v in taken_ints.items()},
            {name: v[part] for name, v in held_floats.items()},
        )
        for part in _parts(cases[0])
    ]
    return Exact(
        {name: np.concatenate([p.outputs[name] for p in parts]) for name in parts[0].outputs},
        {name: np.concatenate([p.decisions[name] for p in parts]) for name in parts[0].decisions},
        {name: np.concatenate([p.margins[name] for p in parts]) for name in parts[0].margins},
        {name: np.concatenate([p.state[name] for p in parts]) for name in parts[0].state},
    )


def _fallback(output: Output, state: Arrays) -> Any:
    """What the output is when nothing fires; None where it has no ``otherwise``."""
    if output.fallback is None:
        return None
    initial = float(output.fallback.value)
    return state.get(output.name, initial) if output.fallback.hold else initial


def _keys(controller: Controller) -> set[str]:
    return {f"fires.{o.name}" for o in controller.outputs} | {"acting"}


def _parts(cases: int) -> Iterator[slice]:
    for start in range(0, max(cases, 1), _CHUNK):
        yield slice(start, start + _CHUNK)


def _chunk(controller: Controller, values: list[Floats], taken: dict[str, Ints], held: dict[str, Floats]) -> Exact:
    cases = len(values[0])
    rules = _Rules(controller, cases)
    for rule in fired(controller, values):
        rules.add(rule)
    result = Exact({}, {}, {}, {})
    for number, output in enumerate(controller.outputs):
        strongest = rules.strongest[number].rows.max(axis=0, initial=0.0)
        fires: Bools = np.ones(cases, dtype=np.bool_)
        if not controller.always_fires[number]:
            key = f"fires.{output.name}"
            threshold = float(controller.fires_at)
            fires = strongest >= threshold
            result.decisions[key] = fires.astype(np.int64)
            result.margins[key] = np.abs(strongest - threshold)
            if key in taken:
                fires = np.where(taken[key] < 0, fires, taken[key] > 0)
        moment, area = rules.moment_and_area(number)
        otherwise = held.get(output.name, np.full(cases, np.nan))
        fires = fires & (area > 0)
        value = otherwise.copy()
        np.divide(moment, area, out=value, where=fires)
        np.add(value, float(output.integrate_lo), out=value, where=fires)
        # what is averaged lies in the range by construction; only rounding could leave it
        np.clip(value, float(output.variable.lo), float(output.variable.hi), out=value, where=fires)
        result.outputs[output.name] = value
        if output.fallback is not None and output.fallback.hold:
            result.state[output.name] = value.copy()
    if controller.behaviors:
        best, threshold = rules.owners.rows[1:], float(controller.fires_at)
        acting = _acting(best, threshold)
        told = taken.get("acting", acting)
        told = np.where(told < 0, acting, told)
        result.decisions["acting"] = acting
        result.margins["acting"] = _acting_margin(best, threshold, acting, told)
        result.outputs["acting"] = told.astype(np.float64)
    return result


class _Rules:
    """What the rules that fired add up to, in N cases."""

    def __init__(self, controller: Controller, cases: int) -> None:
        self._outputs = controller.outputs
        self._infer: Inference = controller.infer
        sizes = [len(o.terms) for o in controller.outputs]
        self.strongest = [Levels(size, cases, "max") for size in sizes]
        self.owners = Levels(len(controller.behaviors) + 1, cases, "max")
        self._has_owners = bool(controller.behaviors)
        self._summed = [Levels(size, cases, "sum") for size in sizes] if self._infer.aggregate == "sum" else []
        # clipping each rule's set and adding them up is not a matter of one level a term
        self._by_rule = self._infer == Inference(self._infer.and_, self._infer.or_, "min", "sum", "centroid")
        self._area = np.zeros((len(sizes), cases))
        self._moment = np.zeros((len(sizes), cases))

    def add(self, rule: Fired) -> None:
        for number, terms in rule.consequents:
            self.strongest[number].raise_to(terms, rule.strength)
            if self._by_rule:
                self._add_clipped(number, terms, rule.strength)
            elif self._summed:
                self._summed[number].raise_to(terms, rule.strength)
        if self._has_owners and rule.owner is not None:
            self.owners.raise_to(rule.owner, rule.strength)

    def _add_clipped(self, number: int, terms: Ints | int, strength: Floats) -> None:
        output = self._outputs[number]
        for term in range(len(output.terms)):
            where = np.flatnonzero((terms == term) & (strength > 0))
            if where.size:
                area, moment = single(output, term, strength[where], "min")
                self._area[number, where] += area
                self._moment[number, where] += moment

    def moment_and_area(self, number: int) -> tuple[Floats, Floats]:
        """Of what output ``number`` is to be; the moment is about ``integrate_lo``."""
        output, infer = self._outputs[number], self._infer
        if self._by_rule:
            return self._moment[number], self._area[number]
        levels = (self._summed if self._summed else self.strongest)[number].rows
        if infer.defuzzify == "weighted_average":
            return _places(output) @ levels, levels.sum(axis=0)
        if infer.aggregate == "max":
            area, moment = union(output, levels, infer.implies)
            return moment, area
        # scaled sets add up term by term
        area, moment = np.zeros(levels.shape[1]), np.zeros(levels.shape[1])
        for term, level in enumerate(levels):
            a, m = single(output, term, level, "product")
            area += a
            moment += m
        return moment, area


def _places(output: Output) -> Floats:
    """Where the singletons stand, measured from ``integrate_lo``."""
    places = []
    for term in output.terms:
        if not isinstance(term.shape, Singleton):
            raise ValueError(f"the weighted average takes singletons; {term.name} of {output.name} is none")
        places.append(float(term.shape.at - output.integrate_lo))
    return np.array(places)


def _acting(best: Floats, fires_at: float) -> Ints:
    """The code of the behavior that owns the strongest cell; ``best`` is (codes from 1, N)."""
    strongest = best.max(axis=0)
    # argmax takes the first of equals: the higher priority
    return np.where(strongest >= fires_at, best.argmax(axis=0) + 1, 0).astype(np.int64)


def _acting_margin(best: Floats, fires_at: float, code: Ints, told: Ints) -> Floats:
    """How far the strengths are from making another code act: the one that was told, else the nearest.

    To 0 that is the strength above ``fires_at``; to a behavior the lead over its strength or, from 0, what its
    strength lacks of ``fires_at``.
    """
    strongest = best.max(axis=0)
    to_none = np.maximum(strongest - fires_at, 0.0)
    distance = np.concatenate([to_none[None, :], np.maximum(strongest, fires_at) - best])
    lanes = np.arange(len(code))
    elsewhere = distance.copy()
    elsewhere[code, lanes] = np.inf
    known = np.where(told < len(distance), told, 0)
    to_told = np.where(told < len(distance), distance[known, lanes], np.inf)
    return np.where(told == code, elsewhere.min(axis=0), to_told)
