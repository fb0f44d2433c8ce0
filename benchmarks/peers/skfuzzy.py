"""scikit-fuzzy: its functions, and its ``control`` module."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.peers.task import (
    SAMPLES,
    PeerEntry,
    Skipped,
    Task,
    averages,
    evaluated,
    imported,
    installed,
    rules,
    triangle,
)
from fuzzyspec.model.controller import Controller


def measure_functions(task: Task) -> PeerEntry:
    """``trimf``, ``interp_membership``, ``fmin``, ``fmax`` and ``defuzz``, put together as its examples do."""
    fuzz = _library(task)
    controller = task.controller
    inputs = [_sets(fuzz, i) for i in controller.inputs]
    outputs = [_sets(fuzz, o) for o in controller.outputs]
    names = [o.name for o in controller.outputs]
    cells = rules(controller)

    def evaluate(row: tuple[float, ...]) -> Mapping[str, float]:
        degrees = [
            [float(fuzz.interp_membership(universe, s, x)) for s in sets]
            for (universe, sets), x in zip(inputs, row, strict=True)
        ]
        joined = [np.zeros_like(universe) for universe, _ in outputs]
        for at, consequents in cells:
            strength = min(d[k] for d, k in zip(degrees, at, strict=True))
            if strength > 0:
                for o, k in enumerate(consequents):
                    joined[o] = np.fmax(joined[o], np.fmin(strength, outputs[o][1][k]))
        return {
            name: float(fuzz.defuzz(universe, total, "centroid"))
            for name, (universe, _), total in zip(names, outputs, joined, strict=True)
        }

    part = task.first(1000 if len(cells) < 50 else 300)
    found, took = evaluated(part, evaluate)
    return _entry(part, "scikit-fuzzy, functions", found, took)


def measure_control(task: Task) -> PeerEntry:
    """``ControlSystemSimulation``, as its tutorial uses it."""
    _library(task)
    control = imported("skfuzzy.control")
    simulation = _simulation(control, imported("skfuzzy"), task.controller)
    names = [i.name for i in task.controller.inputs]

    def evaluate(row: tuple[float, ...]) -> Mapping[str, float]:
        for name, value in zip(names, row, strict=True):
            simulation.input[name] = value
        simulation.compute()
        return {o.name: float(simulation.output[o.name]) for o in task.controller.outputs}

    part = task.first(100 if len(task.controller.inputs) < 3 else 20)
    found, took = evaluated(part, evaluate)
    return _entry(part, "scikit-fuzzy, control", found, took)


def _simulation(control: Any, fuzz: Any, controller: Controller) -> Any:
    def variable(kind: Any, of: Any) -> Any:
        universe, sets = _sets(fuzz, of)
        made = kind(universe, of.name)
        for term, values in zip(of.terms, sets, strict=True):
            made[term.name] = values
        return made

    inputs = [variable(control.Antecedent, i) for i in controller.inputs]
    outputs = [variable(control.Consequent, o) for o in controller.outputs]
    made = []
    for at, consequents in rules(controller):
        antecedent = inputs[0][controller.inputs[0].terms[at[0]].name]
        for given, of, k in zip(inputs[1:], controller.inputs[1:], at[1:], strict=True):
            antecedent = antecedent & given[of.terms[k].name]
        then = [out[of.terms[k].name] for out, of, k in zip(outputs, controller.outputs, consequents, strict=True)]
        made.append(control.Rule(antecedent, then))
    return control.ControlSystemSimulation(control.ControlSystem(made))


def _library(task: Task) -> Any:
    if averages(task.controller):
        raise Skipped("it has no weighted average of singletons")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return imported("skfuzzy")


def _sets(fuzz: Any, of: Any) -> tuple[Any, list[Any]]:
    """A universe over the range, and the terms on it."""
    lo, hi = float(of.variable.lo), float(of.variable.hi)
    universe = np.linspace(lo, hi, SAMPLES + 1)
    return universe, [fuzz.trimf(universe, list(triangle(term))) for term in of.terms]


def _entry(part: Task, peer: str, found: Mapping[str, Any], took: float) -> PeerEntry:
    n = len(part.rows)
    return PeerEntry(part.workload, peer, installed("scikit-fuzzy"), part.error(found), n, took)
