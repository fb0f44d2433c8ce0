"""One spec through everything that the project promises of any spec, a stage at a time."""

from __future__ import annotations

import random
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

from fuzzyspec import SpecError, load
from fuzzyspec.api import Spec
from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.emit import emit
from fuzzyspec.fixed.build import RangeError
from fuzzyspec.fixed.run import run
from fuzzyspec.lower import Lowered, Options
from fuzzyspec.lower.choice import candidate, strategies
from fuzzyspec.machines.machine import EmulatedMachine
from fuzzyspec.machines.simavr import DoesNotFit
from fuzzyspec.machines.toolchains import TARGETS, find_compiler
from fuzzyspec.native import Death, NativeModule, NativeProcess
from fuzzyspec.native.toolchain import Toolchain
from fuzzyspec.verify.cases import Batch
from fuzzyspec.verify.points import Raws
from fuzzyspec.verify.runner import Runner, differing
from fuzzyspec.verify.subject import Subject, subjects
from tests.lower.test_strategies import same_integers
from tests.random_specs.agreement import OPTIONS, cases, check_c, check_exact, example

ABOVE_32_BITS = {"FZ450", "FZ451"}
"""What a sound spec may be refused for: its numbers do not go."""


@dataclass(frozen=True)
class Effort:
    """``cases`` a function on the host and ``emulated`` on each machine; how many ``machines``, of those that are
    here, by turns; whether also by all strategies and the other compiler."""

    cases: int
    sanitized: bool
    machines: int
    emulated: int = 40
    otherwise: bool = True


FULL = Effort(800, sanitized=True, machines=2)
LIGHT = Effort(100, sanitized=False, machines=0, otherwise=False)


class Failed(AssertionError):
    """A stage did not hold."""

    def __init__(self, stage: str, why: str) -> None:
        self.stage = stage
        super().__init__(f"{stage}: {why}")


@contextmanager
def stage(name: str) -> Iterator[None]:
    """Whatever is raised here fails this stage; a tool that is not installed fails none."""
    try:
        yield
    except MissingTool:
        pass
    except SpecError as error:
        codes = sorted({d.code for d in error.diagnostics if d.severity == "error"})
        raise Failed(f"{name} {' '.join(codes)}", str(error)) from error
    except Exception as error:
        raise Failed(f"{name} {type(error).__name__}", f"{error}\n{getattr(error, 'output', '')}".rstrip()) from error


def trial(text: str, seed: int, effort: Effort) -> bool:
    """Whether the spec could be tried at all: a sound one is refused where its numbers do not go into 32 bits.

    Raises Failed at the first stage that does not hold.
    """
    with stage("checker"):
        spec = load(text)
    options = OPTIONS[seed % len(OPTIONS)]
    try:
        with stage("lowering"):
            lowered = spec.lower(options)
    except Failed as failed:
        refused = failed.__cause__
        if (
            isinstance(refused, SpecError)
            and {d.code for d in refused.diagnostics if d.severity == "error"} <= ABOVE_32_BITS
        ):
            return False
        raise
    tried = _batches(spec, lowered, seed, effort.cases)
    with stage("printing"):
        files = dict(emit(spec.module, lowered, spec.source, options).files)
    with stage("host"), NativeModule(lowered.program, files) as native:
        assert native.selftest() == 0, "a golden vector differs"
        for subject, batch in tried:
            check_c(subject, native, batch)
    with stage("bounds"):
        for subject, batch in tried:
            check_exact(subject, batch)
    if effort.otherwise:
        with stage("strategies"):
            for controller in spec.module.controllers:
                same_integers(controller, 200)
        with stage("another compiler"):
            _otherwise(spec, options, seed, tried)
    if effort.sanitized:
        with stage("sanitizers"), NativeProcess(lowered.program, files, sanitize=True) as process:
            _agrees(process, tried)
    for target in _by_turns(seed, effort.machines):
        with stage(target):
            _on_machine(lowered, files, target, seed, tried, effort.emulated)
    return True


def _batches(spec: Spec, lowered: Lowered, seed: int, n: int) -> list[tuple[Subject, Batch]]:
    chosen = subjects(spec.module, lowered.program, lowered.certificates)
    return [(subject, batch) for subject in chosen for batch in cases(subject, seed, n)]


def _agrees(runner: Runner, tried: list[tuple[Subject, Batch]]) -> None:
    """What runs the C computes what the integer program does."""
    for subject, batch in tried:
        got = runner.run(subject.name, batch.inputs, batch.state or None)
        assert not isinstance(got, Death), f"{got} at {example(batch, got.case)}"
        wanted = run(subject.program, subject.name, batch.inputs, batch.state or None)
        for what, mask in differing(got, wanted).items():
            assert not mask.any(), f"{subject.name}: {what} differs at {example(batch, int(mask.argmax()))}"


def _otherwise(spec: Spec, options: Options, seed: int, tried: list[tuple[Subject, Batch]]) -> None:
    """The C by strategies that nobody would choose, built by the other compiler, is equal too."""
    dice = random.Random(seed)
    chosen = []
    for controller in spec.module.controllers:
        possible = dice.sample(found := strategies(controller), len(found))
        for strategy in possible:
            try:
                candidate(controller, strategy, options.target)
            except RangeError:
                continue
            chosen.append((controller.name, strategy))
            break
    other = replace(options, explicit=tuple(chosen))
    lowered = spec.lower(other)
    files = dict(emit(spec.module, lowered, spec.source, other).files)
    clang = Toolchain(("clang",)) if shutil.which("clang") else None
    with NativeModule(lowered.program, files, clang) as native:
        _agrees(native, tried)


def _by_turns(seed: int, count: int) -> list[str]:
    return random.Random(seed).sample(list(TARGETS), count)


def _on_machine(
    lowered: Lowered, files: dict[str, bytes], target: str, seed: int, tried: list[tuple[Subject, Batch]], n: int
) -> None:
    level = ("O0", "O2", "Os", "O3")[seed % 4]
    few = [
        (subject, Batch(batch.kind, _first(batch.inputs, n), _first(batch.state, n)))
        for subject, batch in tried
        if batch.kind in ("mixed", "special")
    ]
    with EmulatedMachine(lowered.program, files, find_compiler(TARGETS[target]), level) as machine:
        try:
            assert machine.selftest() == 0, "a golden vector differs"
            _agrees(machine, few)
        except DoesNotFit:
            return


def _first(arrays: dict[str, Raws], n: int) -> dict[str, Raws]:
    return {k: v[:n] for k, v in arrays.items()}
