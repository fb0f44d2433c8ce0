"""What a checked module amounts to, as data: cells and who won them, coverage, reachable intervals, decisions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.check.coverage import Floor, controller_floors, show_spot
from fuzzyspec.check.decisions import Decision, of_controller, of_system
from fuzzyspec.check.reachable import Reach, reach
from fuzzyspec.check.strength import setters_of
from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.model.budget import Budget
from fuzzyspec.model.controller import Behavior, Controller, Fallback, Inference, Output
from fuzzyspec.model.system import ActingOutput, ListInput, Module, System
from fuzzyspec.model.variable import Variable

Bands = Mapping[str, Mapping[str, Fraction]]
"""Function name and decision key to the width within which the two meanings may decide differently.

A key that a function does not list is decided alike by both.
"""


@dataclass(frozen=True)
class BehaviorReport:
    """``lost`` names winners with the cells that each took; ``dead`` counts rules that never win."""

    behavior: Behavior
    rules: int
    started: int
    executed: int
    lost: tuple[tuple[str, int], ...]
    dead: int


@dataclass(frozen=True)
class OutputReport:
    """``where`` is the input at which the floor is reached, printed; inputs that do not matter are left out.

    ``unset`` counts cells of which nobody sets the output.
    """

    output: Output
    floor: Floor
    where: Mapping[str, str]
    always_fires: bool
    reach: Reach
    unset: int


@dataclass(frozen=True)
class ControllerReport:
    """``cells`` and ``claimed`` are 0 where there are sentence rules alone."""

    controller: Controller
    cells: int
    claimed: int
    behaviors: tuple[BehaviorReport, ...]
    outputs: tuple[OutputReport, ...]
    decisions: tuple[Decision, ...]

    @property
    def infer(self) -> Inference:
        return self.controller.infer


@dataclass(frozen=True)
class SystemReport:
    """``decisions`` are those on computed values."""

    system: System
    decisions: tuple[Decision, ...]


@dataclass(frozen=True)
class ModuleReport:
    """The whole file; ``bands`` may be empty where nothing has been lowered."""

    name: str
    controllers: tuple[ControllerReport, ...]
    systems: tuple[SystemReport, ...]
    bands: Bands

    def text(self) -> str:
        """For people; ends without a newline."""
        from fuzzyspec.check.report_text import report_text

        return report_text(self)

    def as_json(self) -> dict[str, object]:
        """The same as plain data; numbers are floats in the unit that stands beside them."""
        return {
            "module": self.name,
            "controllers": [_controller_json(c, self.bands) for c in self.controllers],
            "systems": [_system_json(s, self.bands) for s in self.systems],
        }


def module_report(module: Module, source: Source | None = None, bands: Bands | None = None) -> ModuleReport:
    """Account for everything that ``check`` prints.

    With ``source`` decisions are told in the spec's own words, with ``bands`` (from the certificates) how near their
    operands must be for the two meanings to part.
    """
    return ModuleReport(
        module.name,
        tuple(_controller(c) for c in module.controllers),
        tuple(SystemReport(s, of_system(s, source)) for s in module.systems),
        {} if bands is None else bands,
    )


def _controller(controller: Controller) -> ControllerReport:
    account = controller.account
    names = {b.code: b.name for b in controller.behaviors}
    behaviors = []
    if account is not None:
        for behavior, counted in zip(controller.behaviors, account.behaviors, strict=True):
            rules = [r for r in account.rules if r.owner == behavior.code]
            lost = tuple((names[code], count) for code, count in counted.lost)
            dead = sum(r.executed == 0 for r in rules)
            behaviors.append(BehaviorReport(behavior, len(rules), counted.started, counted.executed, lost, dead))
    found = controller_floors(controller)
    outputs = []
    for index, (output, low) in enumerate(zip(controller.outputs, found, strict=True)):
        setters = setters_of(index, controller.inputs, controller.infer, controller.cells, controller.sentences)
        where = show_spot(low.spot, controller.inputs, setters.used)
        cells = () if controller.cells is None else controller.cells.consequents[index]
        # An output of sentence rules alone has no cells, rather than only open ones.
        unset = cells.count(-1) if any(term >= 0 for term in cells) else 0
        always = controller.always_fires[index]
        outputs.append(OutputReport(output, low, where, always, reach(controller, index), unset))
    return ControllerReport(
        controller,
        0 if account is None else account.cells,
        0 if account is None else account.claimed,
        tuple(behaviors),
        tuple(outputs),
        of_controller(controller, controller.always_fires),
    )


# --- as plain data ---------------------------------------------------------------------------


def _controller_json(report: ControllerReport, bands: Bands) -> dict[str, object]:
    controller = report.controller
    cells = {
        "total": report.cells,
        "claimed": report.claimed,
        "unclaimed": report.cells - report.claimed,
    }
    return {
        "name": controller.name,
        "inputs": [{**_variable_json(v.variable), "terms": [t.name for t in v.terms]} for v in controller.inputs],
        "inference": {
            "and": report.infer.and_,
            "or": report.infer.or_,
            "implies": report.infer.implies,
            "aggregate": report.infer.aggregate,
            "defuzzify": report.infer.defuzzify,
            "fires_at": float(controller.fires_at),
        },
        "cells": cells if controller.cells is not None else None,
        "sentence_rules": len(controller.sentences),
        "behaviors": [
            {
                "name": b.behavior.name,
                "code": b.behavior.code,
                "priority": b.behavior.priority,
                "rules": b.rules,
                "rules_that_never_win": b.dead,
                "started": b.started,
                "executed": b.executed,
                "lost": dict(b.lost),
            }
            for b in report.behaviors
        ],
        "outputs": [_output_json(o) for o in report.outputs],
        "decisions": _decisions_json(report.decisions, bands.get(controller.name)),
        "budgets": _budgets_json(controller.budgets),
    }


def _output_json(report: OutputReport) -> dict[str, object]:
    reached = report.reach
    return {
        **_variable_json(report.output.variable),
        "terms": [t.name for t in report.output.terms],
        "unused_terms": list(reached.unused),
        "cells_unset": report.unset,
        "coverage": {
            "at_least": float(report.floor.proved),
            "seen": float(report.floor.seen),
            "exact": report.floor.exact,
            "at": dict(report.where),
        },
        "always_fires": report.always_fires,
        "otherwise": _fallback_json(report.output.fallback),
        "reachable": {
            "within": [float(reached.lo), float(reached.hi)],
            "attained": None if reached.attained is None else [float(x) for x in reached.attained],
            "exact": reached.exact,
            "by": reached.means,
        },
    }


def _fallback_json(fallback: Fallback | None) -> dict[str, object] | None:
    return None if fallback is None else {"value": float(fallback.value), "hold": fallback.hold}


def _system_json(report: SystemReport, bands: Bands) -> dict[str, object]:
    system = report.system
    inputs: list[dict[str, object]] = []
    for item in system.inputs:
        if isinstance(item, ListInput):
            fields = [_variable_json(f) for f in item.fields]
            inputs.append({"name": item.name, "capacity": item.capacity, "fields": fields})
        else:
            inputs.append(_variable_json(item))
    outputs: list[dict[str, object]] = []
    for output in system.outputs:
        if isinstance(output, ActingOutput):
            outputs.append({"name": output.name, "acting_of": output.call})
        else:
            bare = None if output.bare is None else f"{output.bare[0]}.{output.bare[1]}"
            outputs.append({**_variable_json(output.variable), "bare": bare, "saturates": output.saturates})
    return {
        "name": system.name,
        "inputs": inputs,
        "outputs": outputs,
        "calls": [{"id": c.id, "controller": c.controller.name} for c in system.calls],
        "decisions": _decisions_json(report.decisions, bands.get(system.name)),
        "budgets": _budgets_json(system.budgets),
    }


def _decisions_json(decisions: tuple[Decision, ...], bands: Mapping[str, Fraction] | None) -> list[dict[str, object]]:
    return [
        {"key": d.key, "kind": d.kind, "what": d.what, "band": None if bands is None else float(bands.get(d.key, 0))}
        for d in decisions
    ]


def _budgets_json(budgets: tuple[Budget, ...]) -> list[dict[str, object]]:
    """Limits in bytes or as counts; ``target`` is null where they hold on every target that tells the quantity."""
    return [{"quantity": b.quantity, "limit": b.limit, "target": b.target} for b in budgets]


def _variable_json(variable: Variable) -> dict[str, object]:
    return {
        "name": variable.name,
        "range": [float(variable.lo), float(variable.hi)],
        "unit": variable.unit.symbol,
        "raw": {
            "type": variable.raw.ctype,
            "step": float(variable.raw.step),
            "origin": float(variable.raw.origin),
            "lo": variable.raw.lo,
            "hi": variable.raw.hi,
        },
    }
