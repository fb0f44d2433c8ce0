"""Shows that the C does what the spec says: C, integer program and exact meaning over many cases.

The C is held to the integer program bit for bit, and that to the exact meaning within the certified bounds.
"""

from __future__ import annotations

from fuzzyspec.verify.directed import Effort, largest_errors
from fuzzyspec.verify.equivalence import DEFAULT_SEED, Options, TheirC, verify
from fuzzyspec.verify.exhaust import Sweep
from fuzzyspec.verify.machines import LEVELS, NAMES, Machines, find_machines
from fuzzyspec.verify.render import as_json, as_text
from fuzzyspec.verify.report import Example, Failure, FunctionFound, OutputFound, Report
from fuzzyspec.verify.scenario import ScenarioError, read_scenario
from fuzzyspec.verify.subject import Subject, subjects
from fuzzyspec.verify.swept import Swept

__all__ = [
    "DEFAULT_SEED",
    "LEVELS",
    "NAMES",
    "Effort",
    "Example",
    "Failure",
    "FunctionFound",
    "Machines",
    "Options",
    "OutputFound",
    "Report",
    "ScenarioError",
    "Subject",
    "Sweep",
    "Swept",
    "TheirC",
    "as_json",
    "as_text",
    "find_machines",
    "largest_errors",
    "read_scenario",
    "subjects",
    "verify",
]
