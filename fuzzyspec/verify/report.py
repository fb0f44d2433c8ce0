"""What a verification found, as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Literal

from fuzzyspec.fixed.certificate import Dominant

FailureKind = Literal["build", "selftest", "c", "death", "bound", "band"]


@dataclass(frozen=True, slots=True)
class Example:
    """One case: raws by signal (lists as tuples, counts under ``list.count``), and the same in the user's units."""

    inputs: Mapping[str, int | tuple[int, ...]]
    state: Mapping[str, int]
    values: Mapping[str, str | tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class Difference:
    """Something that came out otherwise than it should: ``what`` names an output, a state or the status."""

    what: str
    expected: str
    got: str


@dataclass(frozen=True, slots=True)
class Build:
    """How the C was built, and for which machine."""

    target: str
    compiler: str
    level: str

    def __str__(self) -> str:
        return f"{self.target}, {self.compiler} -{self.level}"


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a verification failed. ``example`` is a smallest input that shows it, where an input is to blame.

    ``on``: the build that was run; None for the ordinary one on this machine.
    """

    kind: FailureKind
    function: str | None
    message: str
    example: Example | None = None
    differences: tuple[Difference, ...] = ()
    output: str = ""
    """What the compiler or a sanitizer printed."""
    on: Build | None = None


@dataclass(frozen=True, slots=True)
class OutputFound:
    """One output over all cases. Errors are in the output's unit; ``percent`` is of its range.

    ``bound`` is the certified one, None where the certificate has none; ``dominant`` is what it owes most to.
    ``acting`` has neither: it is a decision.
    """

    output: str
    unit: str
    cases: int
    mismatches: int
    largest_error: float | None
    largest_percent: float | None
    bound: Fraction | None
    bound_percent: Fraction | None
    worst: Example | None
    dominant: Dominant | None = None

    @property
    def ratio(self) -> float | None:
        """Certified over found: how many times the largest error seen the bound is."""
        return None if self.bound is None or not self.largest_error else float(self.bound) / self.largest_error


@dataclass(frozen=True, slots=True)
class DecisionFound:
    """One decision over all cases: how often it was taken, and how often the exact meaning alone would take another.

    ``largest_margin`` is how far the operands were apart at most where it would; ``band`` is what the certificate
    allows, None where it allows nothing.
    """

    key: str
    what: str
    taken: int
    disagreed: int
    largest_margin: float
    band: Fraction | None


@dataclass(frozen=True, slots=True)
class FunctionFound:
    """One controller or system. ``cases`` went through C and both meanings, ``sanitized`` through sanitizers too."""

    function: str
    kind: Literal["controller", "system"]
    cases: int
    kinds: Mapping[str, int]
    sanitized: int
    mismatches: int
    status_mismatches: int
    state_mismatches: int
    outputs: tuple[OutputFound, ...]
    decisions: tuple[DecisionFound, ...]


@dataclass(frozen=True, slots=True)
class OnMachine:
    """One function on one machine. ``left_out`` says why it was not run, where it was not."""

    function: str
    cases: int
    mismatches: int
    left_out: str = ""


@dataclass(frozen=True, slots=True)
class MachineFound:
    """One build on its machine. ``emulator``: what ran it, empty where this machine did.

    ``selftest``: what it returned; None where it did not, or was not run.
    """

    build: Build
    emulator: str
    selftest: int | None
    functions: tuple[OnMachine, ...]
    left_out: str = ""

    @property
    def cases(self) -> int:
        """Cases that it ran, over all functions."""
        return sum(f.cases for f in self.functions)

    @property
    def mismatches(self) -> int:
        """Those whose outcome is not the integer program's."""
        return sum(f.mismatches for f in self.functions)


@dataclass(frozen=True, slots=True)
class Report:
    """The outcome of a verification. ``notes`` say what was left out, and why."""

    module: str
    seed: int
    compiler: str
    sanitizers: tuple[str, ...]
    selftest: int | None
    functions: tuple[FunctionFound, ...]
    failures: tuple[Failure, ...]
    notes: tuple[str, ...] = field(default=())
    machines: tuple[MachineFound, ...] = field(default=())

    @property
    def ok(self) -> bool:
        """Whether nothing failed."""
        return not self.failures

    @property
    def cases(self) -> int:
        """Cases compared, over all functions."""
        return sum(f.cases for f in self.functions)

    def function(self, name: str) -> FunctionFound:
        """What was found of one function. KeyError where it was not verified."""
        for found in self.functions:
            if found.function == name:
                return found
        raise KeyError(name)
