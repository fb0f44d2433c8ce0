"""A spec in the loop: the generated C or the exact meaning, behind the same call."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any, Literal

import numpy as np

from firmware_sim.parameters import PERIOD, Parameters
from firmware_sim.run import Command
from firmware_sim.sensing import Readings, Sighting
from fuzzyspec.api import Spec

Meaning = Literal["c", "exact"]
FIELDS = ("distance", "bearing", "speed", "radius")
INPUTS = frozenset({"target_bearing", *(f"obstacles.{f}" for f in FIELDS)})


class Unfit(ValueError):
    """A spec that no robot can run; the message says what a robot wants."""


class Brain:
    """One robot's controller: senses become raws, raws go through the C (or their values through the exact meaning).

    The system must have nav.fz's inputs and its outputs v and w; ``acting`` is reported where there is one. A system
    that remembers keeps its state here, so every robot needs a brain of its own.
    """

    def __init__(self, spec: Spec, meaning: Meaning) -> None:
        """Raises Unfit where the spec has no system, more than one, or one with another interface."""
        if len(spec.systems) != 1:
            raise Unfit(f"{spec.source.name} has {len(spec.systems)} systems; a robot runs a spec with one, as nav.fz")
        (self._system,) = spec.systems.values()
        self._spec, self._meaning = spec, meaning
        self._variables = _variables(self._system)
        outputs = {o.name: o for o in self._system.outputs}
        if self._variables.keys() != INPUTS or not {"v", "w"} <= outputs.keys():
            raise Unfit(
                f"{spec.source.name} is not for robots: their system has the inputs {', '.join(sorted(INPUTS))} "
                "and the outputs v and w"
            )
        self._behaviors = {0: ""}
        if "acting" in outputs:
            called = {c.id: c.controller for c in self._system.calls}
            acting = called[getattr(outputs["acting"], "call")]  # noqa: B009 (its type is not to be imported here)
            self._behaviors |= {b.code: b.name for b in acting.behaviors}
        self._state: Mapping[str, Any] | None = None

    def __call__(self, readings: Readings, /) -> Command:
        """One step."""
        raws = {key: [self._raw(key, x) for x in values] for key, values in _signals(readings).items()}
        found, self._state = self._step(raws, len(readings.obstacles), self._state)
        code = int(found["acting"][0]) if "acting" in found else 0
        return Command(float(found["v"][0]), float(found["w"][0]), self._behaviors[code])

    def _raw(self, key: str, value: float) -> int:
        return int(self._variables[key].raw.nearest(Fraction(value)))

    def _step(self, raws: Mapping[str, list[int]], count: int, state: Any) -> tuple[Mapping[str, Any], Any]:
        signals: dict[str, Any] = {"obstacles.count": np.array([count])}
        match self._meaning:
            case "c":
                signals |= {key: _shaped(key, numbers, np.int64) for key, numbers in raws.items()}
                called = self._spec.native(self._system.name, signals, state, raw=True)
                return called.outputs, called.state
            case "exact":
                signals |= {
                    key: _shaped(key, [float(self._variables[key].raw.value(r)) for r in numbers], np.float64)
                    for key, numbers in raws.items()
                }
                meant = self._spec.exact(self._system.name, signals, state)
                return meant.outputs, meant.state


def _variables(system: Any) -> dict[str, Any]:
    """The variables of a system's inputs by signal name."""
    found: dict[str, Any] = {}
    for port in system.inputs:
        fields = getattr(port, "fields", None)
        if fields is None:
            found[port.name] = port
        else:
            found |= {f"{port.name}.{f.name}": f for f in fields}
    return found


def _signals(readings: Readings) -> dict[str, list[float]]:
    columns = {f"obstacles.{f}": [float(getattr(o, f)) for o in readings.obstacles] for f in FIELDS}
    return {"target_bearing": [readings.target_bearing], **columns}


def _shaped(key: str, numbers: Sequence[int] | Sequence[float], kind: type) -> Any:
    """One case: (1,) for a scalar, (1, M) for a list's field, M = 0 too."""
    return np.array([numbers] if "." in key else numbers, dtype=kind)


def danger(spec: Spec, meaning: Meaning, sightings: Sequence[Sighting], parameters: Parameters) -> list[float]:
    """DDC of each sighting by the spec's own layer ``danger``; nan where the spec has no such layer.

    Equations 5 to 7, with the world's radius and safety distance: what nav.fz computes before it calls the layer.
    """
    layer = spec.controllers.get("danger")
    if (
        layer is None
        or {i.name for i in layer.inputs} != {"eta_t", "eta_d"}
        or "ddc" not in {o.name for o in layer.outputs}
    ):
        return [math.nan] * len(sightings)
    ranges = {i.name: i.variable for i in layer.inputs}
    gaps = [max(0.0, s.distance - parameters.robot_radius - s.radius) for s in sightings]
    never = float(ranges["eta_t"].hi)
    times = [gap / (s.speed * PERIOD) if s.speed else never for gap, s in zip(gaps, sightings, strict=True)]
    inputs = {
        "eta_t": np.clip(times, float(ranges["eta_t"].lo), never),
        "eta_d": np.clip([g / parameters.safe_distance for g in gaps], 0.0, float(ranges["eta_d"].hi)),
    }
    if meaning == "c":
        return [float(x) for x in spec.native("danger", inputs).outputs["ddc"]]
    return [float(x) for x in spec.exact("danger", inputs).outputs["ddc"]]
