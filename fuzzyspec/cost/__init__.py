"""What a call costs on a microcontroller: the C is built for the target and run in an emulator."""

from __future__ import annotations

from fuzzyspec.cost.budgets import Verdict, confirm
from fuzzyspec.cost.limit import with_limits
from fuzzyspec.cost.measure import TARGETS, Conditions, Measured, Mismatch, Record, measure
from fuzzyspec.cost.pareto import pareto, pareto_json, pareto_text
from fuzzyspec.cost.report import as_json, as_text
from fuzzyspec.machines.emulate import Emulation
from fuzzyspec.machines.image import EmulationError, Image
from fuzzyspec.machines.toolchains import OPTIMISATIONS, CrossCompiler, Target, find_compiler

__all__ = [
    "OPTIMISATIONS",
    "TARGETS",
    "Conditions",
    "CrossCompiler",
    "Emulation",
    "EmulationError",
    "Image",
    "Measured",
    "Mismatch",
    "Record",
    "Target",
    "Verdict",
    "as_json",
    "as_text",
    "confirm",
    "find_compiler",
    "measure",
    "pareto",
    "pareto_json",
    "pareto_text",
    "with_limits",
]
