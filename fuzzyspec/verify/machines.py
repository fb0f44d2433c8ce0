"""The same C on other machines: built by every compiler at every level asked for, run over a sample of the cases.

What a machine must compute is what the integer program said of these cases, so a build on a machine costs what it
takes to compile it and to run it.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from typing import Protocol

from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.fixed.program import Program
from fuzzyspec.machines.machine import EmulatedMachine, Emulators, find_emulator
from fuzzyspec.machines.simavr import DoesNotFit
from fuzzyspec.machines.toolchains import KINDS, TARGETS, CrossCompiler, Kind, description_of, find_compiler
from fuzzyspec.native import BuildError, Death, NativeProcess, Toolchain
from fuzzyspec.native.toolchain import host_toolchains
from fuzzyspec.verify.example import single
from fuzzyspec.verify.report import Build, Failure, MachineFound, OnMachine
from fuzzyspec.verify.runner import Runner, any_of, differing
from fuzzyspec.verify.sample import Sample
from fuzzyspec.verify.steps import Steps
from fuzzyspec.verify.witness import death, difference

LEVELS = ("O0", "O2", "Os", "O3")
HOST = "host"
NAMES = (HOST, *TARGETS)

MOST = 100_000
"""Cases of a function that each build runs, unless told otherwise."""
SLOW = 5
"""simavr counts cycles and takes about as many times as long as the others: it runs one in so many."""


@dataclass(frozen=True, slots=True)
class Way:
    """A build and where it runs; for the host ``compiler`` is a plain toolchain, and there is no emulator."""

    build: Build
    compiler: Toolchain | CrossCompiler
    emulator: Emulators | None


@dataclass(frozen=True, slots=True)
class Machines:
    """``cases``: of each function on each build; None for ``MOST``, fewer where the emulator is slow."""

    ways: tuple[Way, ...]
    cases: int | None = None
    missing: Mapping[str, str] = field(default_factory=dict)

    @property
    def most(self) -> int:
        """Cases of a function that are kept for the builds."""
        return MOST if self.cases is None else self.cases

    def every(self, way: Way) -> int:
        """Of the cases kept, one in so many runs on this build."""
        return SLOW if self.cases is None and way.emulator == "simavr" else 1


class _Machine(Runner, Protocol):
    def selftest(self) -> int | Death: ...


def find_machines(
    targets: Sequence[str],
    levels: Sequence[str] = LEVELS,
    kind: Kind | None = None,
    cases: int | None = None,
    emulator: Emulators | None = None,
) -> Machines:
    """Every compiler that is here for the targets, at every level; ``kind`` allows only one kind.

    ``emulator``: what runs the images of those targets that it knows.

    ``all`` among the targets stands for those whose tools are here; the others are in ``missing``, with what they
    lack. MissingTool where a target that is named has no compiler, or no emulator.
    """
    found: list[Way] = []
    missing: dict[str, str] = {}
    for name in dict.fromkeys(NAMES if "all" in targets else targets):
        try:
            compilers = _compilers(name, kind, emulator)
        except MissingTool as error:
            if name in targets:
                raise
            missing[name] = str(error)
        else:
            found += (Way(Build(name, said, level), c, runs) for c, said, runs in compilers for level in levels)
    return Machines(tuple(found), cases, missing)


def _compilers(
    name: str, kind: Kind | None, emulator: Emulators | None
) -> list[tuple[Toolchain | CrossCompiler, str, Emulators | None]]:
    """Every compiler of a target, with its name and version, and what runs its images."""
    if name == HOST:
        chosen = [t for t in host_toolchains() if kind is None or (t.name == "zig cc") == (kind == "zig")]
        if not chosen:
            raise MissingTool(f"no compiler of the kind {kind} was found for this machine", "leave out --compiler")
        return [(t, described(t), None) for t in chosen]
    found: list[tuple[Toolchain | CrossCompiler, str, Emulators | None]] = []
    lacking: MissingTool | None = None
    for one in KINDS if kind is None else (kind,):
        try:
            compiler = find_compiler(TARGETS[name], one)
        except MissingTool as error:
            lacking = error if lacking is None else lacking
        else:
            found.append((compiler, compiler.description, find_emulator(compiler, emulator)))
    if not found:
        find_compiler(TARGETS[name], kind)
        assert lacking is not None
        raise lacking
    return found


def described(toolchain: Toolchain) -> str:
    """Name and version of a compiler for this machine."""
    return description_of("zig" if toolchain.name == "zig cc" else "gcc", toolchain.command)


def on_machines(
    program: Program,
    files: Mapping[str, bytes],
    samples: Sequence[Sample],
    machines: Machines,
    steps: Steps,
    *,
    strict: bool,
) -> tuple[tuple[MachineFound, ...], tuple[Failure, ...]]:
    """Run every build, as many at once as there are processors; of each target's failures the first of a kind.

    ``strict``: the host's warnings are errors, as they are for what was generated.
    """
    pool = ThreadPoolExecutor(os.cpu_count())
    try:
        done = list(
            pool.map(lambda way: _on(way, program, files, samples, machines.every(way), steps, strict), machines.ways)
        )
    finally:
        pool.shutdown(cancel_futures=True)
    failures: dict[tuple[str, str | None, str], Failure] = {}
    for way, (_, failed) in zip(machines.ways, done, strict=True):
        for failure in failed:
            failures.setdefault((way.build.target, failure.function, failure.kind), failure)
    return tuple(found for found, _ in done), tuple(failures.values())


def _on(
    way: Way,
    program: Program,
    files: Mapping[str, bytes],
    samples: Sequence[Sample],
    every: int,
    steps: Steps,
    strict: bool,
) -> tuple[MachineFound, list[Failure]]:
    """One build: its self-test, and every function's sample."""
    record = MachineFound(way.build, way.emulator or "", None, ())
    failures: list[Failure] = []
    try:
        opened = _opened(way, program, files, strict)
    except BuildError as error:
        steps.add(sum(s.size for s in samples), way.build.target)
        failed = Failure("build", None, f"{error} (for {way.build})", output=error.output, on=way.build)
        return replace(record, left_out="the compiler rejected the C"), [failed]
    with opened as machine:
        try:
            returned = machine.selftest()
            record = replace(record, selftest=returned if isinstance(returned, int) else None)
            if returned != 0:
                said = returned.what if isinstance(returned, Death) else f"golden vector {returned - 1} differs"
                failures.append(Failure("selftest", None, f"the self-test on {way.build}: {said}", on=way.build))
        except (DoesNotFit, BuildError) as reason:
            record = replace(record, left_out=f"the self-test does not fit: {reason}")
        found: list[OnMachine] = []
        for sample in samples:
            name = sample.subject.name
            try:
                one, failure = _sampled(machine, sample, every, way)
            except (DoesNotFit, BuildError) as reason:
                one, failure = OnMachine(name, 0, 0, str(reason)), None
            found.append(one)
            failures += [] if failure is None else [failure]
            steps.add(sample.size, way.build.target)
    return replace(record, functions=tuple(found)), failures


def _opened(way: Way, program: Program, files: Mapping[str, bytes], strict: bool) -> AbstractContextManager[_Machine]:
    if isinstance(way.compiler, CrossCompiler):
        return EmulatedMachine(program, files, way.compiler, way.build.level, emulator=way.emulator)
    return NativeProcess(program, files, way.compiler, level=way.build.level, warnings_are_errors=strict)


def _sampled(machine: _Machine, sample: Sample, every: int, way: Way) -> tuple[OnMachine, Failure | None]:
    """One function's cases; the first that differs is made small, a death ends them."""
    subject = sample.subject
    cases = mismatches = 0
    failure: Failure | None = None
    where = f" on {way.build}"
    for batch, wanted in sample.parts(every):
        got = machine.run(subject.name, batch.inputs, batch.state)
        if isinstance(got, Death):
            failed = death(subject, batch, got, machine, where, way.build)
            return OnMachine(subject.name, cases + got.case, mismatches + 1), failed
        differs = any_of(differing(got, wanted), batch.n)
        cases += batch.n
        mismatches += int(differs.sum())
        if failure is None and differs.any():
            failure = difference(subject, single(batch, int(differs.argmax())), machine, where, way.build)
    return OnMachine(subject.name, cases, mismatches), failure
