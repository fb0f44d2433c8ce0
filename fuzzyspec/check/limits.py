"""Limits of the generated code that only the whole model can be held against."""

from __future__ import annotations

from collections.abc import Mapping

from fuzzyspec.check.findings import Report
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Span
from fuzzyspec.model.controller import Controller
from fuzzyspec.model.system import ListInput, Module, System, SystemOutput

MOST_STATUS_BITS = 32


def check_limits(module: Module, names: Mapping[str, Span], report: Report) -> None:
    """Report every function whose status would need more bits than an integer has."""
    functions: tuple[Controller | System, ...] = (*module.controllers, *module.systems)
    for f in functions:
        bits = _bits(f)
        if bits > MOST_STATUS_BITS:
            kind = "controller" if isinstance(f, Controller) else "system"
            report(
                Diagnostic(
                    "FZ442",
                    f"{kind} `{f.name}` needs {bits} status bits",
                    names[f.name],
                    label=f"the status holds {MOST_STATUS_BITS}",
                    help="each input, list field, list, saturating output and output that holds takes one: split it",
                )
            )


def _bits(f: Controller | System) -> int:
    if isinstance(f, Controller):
        return len(f.inputs) + _held(f)
    ports = sum(len(i.fields) + 1 if isinstance(i, ListInput) else 1 for i in f.inputs)
    saturating = sum(isinstance(o, SystemOutput) and o.saturates for o in f.outputs)
    return ports + saturating + sum(_held(c.controller) for c in f.calls)


def _held(controller: Controller) -> int:
    return sum(o.fallback is not None and o.fallback.hold for o in controller.outputs)
