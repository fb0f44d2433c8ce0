"""``verify``: the C against the integer program, and the integer program against the exact meaning."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from fuzzyspec.emit import Plan
from fuzzyspec.emit.names import name_module
from fuzzyspec.fixed.program import Program
from fuzzyspec.native import BuildError, Death, NativeModule, NativeProcess, Toolchain, find_toolchain
from fuzzyspec.verify.bench import BLOCK, Bench
from fuzzyspec.verify.cases import DEFAULT_CASES, Batch, batches, bulk, planned
from fuzzyspec.verify.directed import Directed, Effort, search
from fuzzyspec.verify.exhaust import Sweep, exhaust, spaces
from fuzzyspec.verify.machines import Machines, described, on_machines
from fuzzyspec.verify.report import Failure, MachineFound, Report
from fuzzyspec.verify.runner import Runner
from fuzzyspec.verify.sample import Sample
from fuzzyspec.verify.steps import Progress, Steps
from fuzzyspec.verify.subject import Subject
from fuzzyspec.version import __version__

DEFAULT_SEED = 20_240_229

CHUNK = 64
"""Blocks that are hashed in one go: the time limit is for that many."""


@dataclass(frozen=True, slots=True)
class Options:
    """``only``: functions to verify (all if empty). ``replayed``: batches to run instead of the generated ones.

    ``directed``: whether to search for each output's largest error, from the worst of the other cases.
    ``machines``: where else a sample of the cases is to run. ``sweep``: whether to try every input there is, and how.
    """

    seed: int = DEFAULT_SEED
    cases: int = DEFAULT_CASES
    only: tuple[str, ...] = ()
    sanitize: bool = True
    seconds: float = 20.0
    replayed: Mapping[str, Sequence[Batch]] | None = None
    directed: bool = False
    machines: Machines | None = None
    sweep: Sweep | None = None


@dataclass(frozen=True, slots=True)
class TheirC:
    """C that a user has: files that stand in for the generated ones of the same names."""

    files: Mapping[str, bytes]


def verify(
    program: Program,
    subjects: Sequence[Subject],
    files: Mapping[str, bytes],
    options: Options = Options(),
    theirs: TheirC | None = None,
    progress: Progress | None = None,
) -> Report:
    """Verify the functions of a module. ``files`` is what was generated for it.

    The generated C is loaded into this process; a user's C runs in one of its own, under a time limit, and is held to
    the generated C over many more cases besides. Raises MissingTool where there is no C compiler.
    """
    toolchain = find_toolchain()
    chosen = [s for s in subjects if not options.only or s.name in options.only]
    swept = () if options.sweep is None else spaces(chosen)
    report = Report(program.name, options.seed, toolchain.name, (), None, (), ())
    tested = {**files, **theirs.files} if theirs is not None else files
    with contextlib.ExitStack() as stack:
        try:
            generated = stack.enter_context(NativeModule(program, files, toolchain))
            runner: Runner = generated
            selftest: int | Death = generated.selftest()
            theirs_in_bulk: NativeProcess | None = None
            if theirs is not None:
                user = NativeProcess(program, tested, toolchain, warnings_are_errors=False, seconds=options.seconds)
                runner = stack.enter_context(user)
                selftest = user.selftest()
                theirs_in_bulk = user if options.replayed is None else None
        except BuildError as error:
            return replace(report, failures=(Failure("build", None, str(error), output=error.output),))
        sanitized, notes = _sanitizers(program, tested, toolchain, options, strict=theirs is None)
        if sanitized is not None:
            stack.enter_context(sanitized)
        benches = [Bench(subject, runner, sanitized, _sample(subject, options)) for subject in chosen]
        total = sum(_planned(s, options, theirs_in_bulk is not None) for s in chosen)
        steps = Steps(total + _elsewhere(benches, options) + sum(s.inputs for s in swept), progress)
        for bench in benches:
            for batch in _cases(bench, options):
                steps.add(batch.n, bench.subject.name)
            if theirs_in_bulk is not None:
                most = bulk(bench.subject, options.cases) // BLOCK
                for start in range(0, most, CHUNK):
                    blocks = range(start, min(start + CHUNK, most))
                    bench.in_bulk(theirs_in_bulk, generated, options.seed, blocks)
                    steps.add(len(blocks) * BLOCK, bench.subject.name)
        if options.sweep is not None and not any(b.failures for b in benches):

            def another() -> contextlib.AbstractContextManager[Runner]:
                if theirs is None:
                    return contextlib.nullcontext(generated)
                seconds = max(options.seconds, 120.0)
                return NativeProcess(program, tested, toolchain, warnings_are_errors=False, seconds=seconds)

            key = {"tool": __version__, "compiler": described(toolchain)}
            key |= {"generated": Plan(files).digest, "c": Plan(tested).digest}
            notes += exhaust(benches, another, options.sweep, steps, key)
    machines: tuple[MachineFound, ...] = ()
    elsewhere: tuple[Failure, ...] = ()
    if options.machines is not None:
        samples = [b.sample for b in benches if b.sample is not None]
        machines, elsewhere = on_machines(program, tested, samples, options.machines, steps, strict=theirs is None)
    failures = _selftest_failures(selftest, name_module(program).selftest)
    return replace(
        report,
        sanitizers=sanitized.sanitizers if sanitized is not None else (),
        selftest=selftest if isinstance(selftest, int) else None,
        functions=tuple(b.tally.found() for b in benches),
        failures=(*failures, *(f for b in benches for f in b.failures), *elsewhere),
        notes=(*notes, *(f"not run on {name}: {why}" for name, why in _missing(options).items())),
        machines=machines,
    )


def _sample(subject: Subject, options: Options) -> Sample | None:
    """What keeps the cases for other machines, where there are any."""
    if options.machines is None:
        return None
    return Sample(subject, options.seed, _planned(subject, options, with_bulk=False), options.machines.most)


def _missing(options: Options) -> Mapping[str, str]:
    return {} if options.machines is None else options.machines.missing


def _elsewhere(benches: Sequence[Bench], options: Options) -> int:
    """How many calls the other machines will make, about."""
    if options.machines is None:
        return 0
    return len(options.machines.ways) * sum(min(s.total, s.most) for b in benches if (s := b.sample) is not None)


def _cases(bench: Bench, options: Options) -> Iterator[Batch]:
    """Every batch that was put on the bench."""
    subject = bench.subject
    directed = Directed(subject, options.seed, Effort.beside(options.cases)) if options.directed else None
    replayed = None if options.replayed is None else options.replayed.get(subject.name, ())
    for batch in batches(subject, options.seed, options.cases) if replayed is None else replayed:
        errors = bench.put(batch)
        if directed is not None:
            directed.tell(batch, errors)
        yield batch
    if directed is not None:
        yield from search(bench, directed)


def _planned(subject: Subject, options: Options, with_bulk: bool) -> int:
    if options.replayed is not None:
        cases = sum(b.n for b in options.replayed.get(subject.name, ()))
    else:
        cases = planned(subject, options.cases, with_bulk=with_bulk)
    return cases + Effort.beside(options.cases).cases if options.directed else cases


def _sanitizers(
    program: Program, files: Mapping[str, bytes], toolchain: Toolchain, options: Options, *, strict: bool
) -> tuple[NativeProcess | None, tuple[str, ...]]:
    """A sanitized build, or a note why there is none."""
    if not options.sanitize:
        return None, ("the sanitizers were not asked for",)
    try:
        process = NativeProcess(
            program, files, toolchain, sanitize=True, warnings_are_errors=strict, seconds=options.seconds
        )
    except BuildError:
        return None, (f"{toolchain.name} has no sanitizers here: undefined behaviour was not looked for",)
    if "address" not in process.sanitizers:
        return process, (f"{toolchain.name} has no address sanitizer here: bounds were not looked at",)
    return process, ()


def _selftest_failures(selftest: int | Death, name: str) -> tuple[Failure, ...]:
    match selftest:
        case 0:
            return ()
        case Death(what=what, output=output):
            return (Failure("selftest", None, f"{name}() did not return: {what}", output=output),)
        case _:
            return (Failure("selftest", None, f"{name}() returned {selftest}: golden vector {selftest - 1} differs"),)
