"""simpful: rules as sentences, Mamdani and Sugeno."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import redirect_stdout
from io import StringIO
from typing import Any

from benchmarks.peers.task import PeerEntry, Task, averages, evaluated, imported, installed, place, rules, triangle
from fuzzyspec.model.controller import Controller


def measure(task: Task) -> PeerEntry:
    """``Mamdani_inference`` at its own 1,000 subdivisions, ``Sugeno_inference`` where singletons are averaged."""
    simpful = imported("simpful")
    with redirect_stdout(StringIO()):  # it tells the kind of model that it detects
        system = _system(simpful, task.controller)
    inputs = [i.name for i in task.controller.inputs]
    outputs = [o.name for o in task.controller.outputs]
    infer = system.Sugeno_inference if averages(task.controller) else system.Mamdani_inference

    def evaluate(row: tuple[float, ...]) -> Mapping[str, float]:
        for name, value in zip(inputs, row, strict=True):
            system.set_variable(name, value)
        found = infer(outputs)
        return {name: float(found[name]) for name in outputs}

    part = task.first(100 if len(inputs) < 3 else 20)
    found, took = evaluated(part, evaluate)
    return PeerEntry(task.workload, "simpful", installed("simpful"), part.error(found), len(part.rows), took)


def _system(simpful: Any, controller: Controller) -> Any:
    product = controller.infer.and_ == "product"
    system = simpful.FuzzySystem(show_banner=False, operators=["AND_PRODUCT"] if product else None)
    for of in controller.inputs:
        system.add_linguistic_variable(of.name, _variable(simpful, of))
    for output in controller.outputs:
        if averages(controller):
            for term in output.terms:
                system.set_crisp_output_value(f"{output.name}_{term.name}", place(term))
        else:
            system.add_linguistic_variable(output.name, _variable(simpful, output))
    written = []
    for at, consequents in rules(controller):
        parts = [f"({i.name} IS {i.terms[k].name})" for i, k in zip(controller.inputs, at, strict=True)]
        joined = parts[0]
        for part in parts[1:]:
            joined = f"({joined} AND {part})"
        for output, k in zip(controller.outputs, consequents, strict=True):
            name = output.terms[k].name
            named = f"{output.name}_{name}" if averages(controller) else name
            written.append(f"IF {joined} THEN ({output.name} IS {named})")
    system.add_rules(written)
    return system


def _variable(simpful: Any, of: Any) -> Any:
    sets = [simpful.TriangleFuzzySet(*triangle(t), term=t.name) for t in of.terms]
    return simpful.LinguisticVariable(sets, universe_of_discourse=[float(of.variable.lo), float(of.variable.hi)])
