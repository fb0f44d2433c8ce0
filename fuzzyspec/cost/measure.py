"""One module on several targets: records of what every function costs, and a check that its outputs are right."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from fuzzyspec.cost.avr import measure_avr
from fuzzyspec.cost.counter import measure_calls
from fuzzyspec.cost.worst import Bound, derive
from fuzzyspec.estimate.inputs import draw_cases
from fuzzyspec.fixed.program import Function, Program
from fuzzyspec.fixed.run import Run, run
from fuzzyspec.machines.emulate import Emulation
from fuzzyspec.machines.image import Image
from fuzzyspec.machines.simavr import simavr_is_here
from fuzzyspec.machines.toolchains import TARGETS as MACHINES
from fuzzyspec.machines.toolchains import CrossCompiler, Target
from fuzzyspec.native.layout import Result

Ints = npt.NDArray[np.int64]
TARGETS: Mapping[str, Target] = MappingProxyType(
    {name: target for name, target in MACHINES.items() if target.machine in ("thumb", "riscv32", "avr")}
)
"""Those on which it is known how to count what is executed."""

Meaning = Callable[[str, Mapping[str, Ints], Mapping[str, Ints] | None], Run]
"""What comes of N cases of raws and states of the function named."""


@dataclass(frozen=True, slots=True)
class Record:
    """One function on one target, built with one option. None where nothing honest can be said.

    Means and largest are over the inputs that were tried; ``instructions_worst`` and ``cycles_worst`` are derived from
    the code: no call takes more. ``worst_reason`` says why there is no such figure. ``instructions_limit`` and
    ``cycles_limit`` are counted (``cost.limit``). ``flash`` is with what the
    compiler's library adds, ``flash_own`` without. ``matches``: the emulated outputs, status and state were those that
    were wanted: the integer program's, bit for bit, where nothing else is said.
    """

    target: str
    option: str
    function: str
    compiler: str
    instructions_mean: float | None
    instructions_max: int | None
    instructions_worst: int | None
    cycles_mean: float | None
    cycles_max: int | None
    cycles_worst: int | None
    worst_reason: str | None
    flash: int
    flash_own: int
    ram: int
    stack: int | None
    matches: bool | None
    instructions_limit: int | None = None
    cycles_limit: int | None = None

    @property
    def exceeds(self) -> bool:
        """Whether a call took more than is derived: the derivation would be wrong."""
        pairs = ((self.instructions_max, self.instructions_worst), (self.cycles_max, self.cycles_worst))
        return any(seen is not None and worst is not None and seen > worst for seen, worst in pairs)


@dataclass(frozen=True, slots=True)
class Mismatch:
    """A case whose emulated outcome is not the one wanted."""

    target: str
    option: str
    function: str
    case: int
    inputs: Mapping[str, list[int] | int]
    what: str
    got: int
    wanted: int


@dataclass(frozen=True, slots=True)
class Conditions:
    """What is built and tried: ``inputs`` cases a function.

    ``long_calls``: calls may take more than half a million cycles on AVR (``avr.measure_avr``). ``worst``: derive what
    no call exceeds; the C must be fuzzyc's own.
    """

    compilers: tuple[CrossCompiler, ...]
    options: tuple[str, ...] = ("O2", "Os")
    inputs: int = 1000
    only: tuple[str, ...] = ()
    long_calls: bool = False
    worst: bool = False


@dataclass(frozen=True, slots=True)
class Measured:
    """All records, targets outermost, and at most one mismatch for each."""

    records: tuple[Record, ...]
    mismatches: tuple[Mismatch, ...]

    @property
    def ok(self) -> bool:
        """Whether every output was right, and no call took more than the worst case derived."""
        return not self.mismatches and not any(r.exceeds for r in self.records)


@dataclass(frozen=True, slots=True)
class _Cases:
    """Inputs of a function and what must come of them."""

    inputs: Mapping[str, Ints]
    state: Mapping[str, Ints] | None
    wanted: Run


def measure(
    program: Program,
    files: Callable[[str, str], Mapping[str, bytes]],
    conditions: Conditions,
    progress: Callable[[int, int, str], None] | None = None,
    meaning: Meaning | None = None,
    slack: int = 0,
) -> Measured:
    """Build, emulate and compare. ``files`` gives the C for a target's name and a compiler's option: all of them must
    compute what ``program`` does. ``progress`` is called with builds done, builds planned and the target's name.

    C that someone else wrote behind the same interface is held against its own ``meaning`` instead, its outputs to
    within ``slack`` raws.

    Raises MissingTool, BuildError where a compiler rejects the C, EmulationError where the built code faults.
    """
    functions = [f for f in program.functions if not conditions.only or f.name in conditions.only]
    cases = {f.name: _draw(program, f, conditions.inputs, meaning) for f in functions}
    builds = [(c, o) for c in conditions.compilers for o in conditions.options]
    records: list[Record] = []
    mismatches: list[Mismatch] = []
    for done, (compiler, option) in enumerate(builds):
        if progress is not None:
            progress(done, len(builds), compiler.target.name)
        with Image(program, files(compiler.target.name, option), compiler, option) as image:
            for record, mismatch in _measure_image(image, conditions, cases, slack):
                records.append(record)
                mismatches += [] if mismatch is None else [mismatch]
    return Measured(tuple(records), tuple(mismatches))


def _draw(program: Program, function: Function, n: int, meaning: Meaning | None) -> _Cases:
    inputs, state = draw_cases(program, function, n)
    wanted = meaning(function.name, inputs, state) if meaning else run(program, function.name, inputs, state)
    return _Cases(inputs, state, wanted)


def _measure_image(
    image: Image, conditions: Conditions, cases: Mapping[str, _Cases], slack: int
) -> list[tuple[Record, Mismatch | None]]:
    """Every function of one build."""
    avr = image.compiler.target.machine == "avr"
    emulation = None if avr else Emulation(image)
    found: list[tuple[Record, Mismatch | None]] = []
    for name, tried in cases.items():
        result: Result | None = None
        instructions = cycles = None
        stack: int | None = None
        if emulation is not None:
            calls = measure_calls(emulation, name, tried.inputs, tried.state)
            result, instructions, cycles, stack = calls.result, calls.instructions, calls.cycles, calls.stack
        elif simavr_is_here():
            timed = measure_avr(image, name, tried.inputs, tried.state, long_calls=conditions.long_calls)
            if timed is not None:
                result, cycles, stack = timed.result, timed.cycles, timed.stack
        mismatch = None if result is None else _first_mismatch(image, name, tried, result, slack)
        sizes = image.sizes(name)
        worst = derive(image, name) if conditions.worst else Bound(None, None, None, {})
        record = Record(
            image.compiler.target.name,
            image.option,
            name,
            image.compiler.description,
            _mean(instructions),
            _largest(instructions),
            worst.instructions,
            _mean(cycles),
            _largest(cycles),
            worst.cycles,
            worst.reason,
            sizes.flash,
            sizes.own,
            sizes.ram,
            stack,
            None if result is None else mismatch is None,
        )
        found.append((record, mismatch))
    return found


def _first_mismatch(image: Image, function: str, tried: _Cases, got: Result, slack: int) -> Mismatch | None:
    """The first case that differs (an output: by more than ``slack``), in the order of outputs, status, state."""
    triples = [(f"output {k}", got.outputs[k], v, slack) for k, v in tried.wanted.outputs.items()]
    triples.append(("status", got.status, tried.wanted.status, 0))
    triples += [(f"state {k}", v, tried.wanted.state[k], 0) for k, v in got.state.items()]
    for what, found, wanted, allowed in triples:
        differing = np.flatnonzero(np.abs(found - wanted) > allowed)
        if differing.size:
            at = int(differing[0])
            given = {k: np.asarray(v)[at].tolist() for k, v in (*tried.inputs.items(), *(tried.state or {}).items())}
            return Mismatch(
                image.compiler.target.name,
                image.option,
                function,
                at,
                given,
                what,
                int(found[at]),
                int(np.asarray(wanted)[at]),
            )
    return None


def _mean(values: Ints | None) -> float | None:
    return None if values is None or not values.size else round(float(values.mean()), 3)


def _largest(values: Ints | None) -> int | None:
    return None if values is None or not values.size else int(values.max())
