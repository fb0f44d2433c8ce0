"""One run: fuzzyc and the baselines side by side in processes, then, alone on the machine, whatever is timed."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from itertools import groupby
from multiprocessing import get_context
from typing import Literal

from benchmarks.own import KINDS, Effort, Entry, Kind, WrongResult, measure_own
from benchmarks.peers import PEERS, PeerEntry, measure_generated, measure_peer, task_of
from benchmarks.results import Results, Setting
from benchmarks.speed import Speed, measure_speed
from benchmarks.workloads import Workload
from fuzzyspec.cost import TARGETS, find_compiler
from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.native import BuildError, find_toolchain

Told = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Plan:
    """What is asked for. ``jobs``: processes, 0 for as many as seem fit."""

    workloads: tuple[Workload, ...]
    targets: tuple[str, ...]
    compiler: Literal["gcc", "zig"] | None = None
    jobs: int = 0
    peers: bool = True
    short: bool = False


def run(plan: Plan, told: Told) -> Results:
    """Measure everything. Raises MissingTool where no target has a compiler, WrongResult."""
    compilers: dict[str, str] = {}
    missing: dict[str, str] = {}
    for name in plan.targets:
        try:
            compilers[name] = find_compiler(TARGETS[name], plan.compiler).description
        except MissingTool as error:
            missing[name] = str(error)
    if not compilers:
        raise MissingTool("no compiler for any target was found", "run `pip install 'fuzzyc[targets]'`")
    if "avr" in compilers and shutil.which("simavr") is None:
        missing["avr"] = "simavr was not found: sizes only"
    effort = Effort(tuple(compilers), compiler=plan.compiler)
    if plan.short:
        effort = Effort(tuple(compilers), 20, 1, 2, 200, plan.compiler)
    own = _own(plan, effort, told)
    peers = tuple(_peers(plan, effort, told)) if plan.peers else ()
    speeds = tuple(_speeds(plan, told))
    return Results(Setting(effort, compilers, missing, _versions(), _host()), own, peers, speeds)


Job = tuple[tuple[Workload, ...], Kind, Effort]


def _own(plan: Plan, effort: Effort, told: Told) -> tuple[Entry, ...]:
    """A job a file and kind: what a file compiles to serves all its functions."""
    by_file = [tuple(group) for _, group in groupby(plan.workloads, key=lambda w: w.file)]
    jobs: list[Job] = [(workloads, kind, effort) for workloads in by_file for kind in KINDS]
    jobs.sort(key=lambda job: -sum(len(w.spec.functions) for w in job[0]))
    found: dict[tuple[str, str], Entry] = {}
    processes = min(plan.jobs or min(os.cpu_count() or 1, 4), len(jobs))
    for entries in _mapped(jobs, processes):
        for entry in entries:
            told(f"{entry.workload}: {entry.kind}")
            found[entry.workload, entry.kind] = entry
    return tuple(found[w.name, kind] for w in plan.workloads for kind in KINDS)


def _mapped(jobs: list[Job], processes: int) -> Iterator[tuple[Entry, ...]]:
    if processes < 2:
        yield from map(_measured, jobs)
        return
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        for done in as_completed([pool.submit(_measured, job) for job in jobs]):
            yield done.result()


def _measured(job: Job) -> tuple[Entry, ...]:
    workloads, kind, effort = job
    try:
        return tuple(measure_own(workload, kind, effort.targets, effort) for workload in workloads)
    except BuildError as error:  # which does not pass from process to process
        raise WrongResult(f"{workloads[0].file}, {kind}: {error}\n{error.output}") from error


def _peers(plan: Plan, effort: Effort, told: Told) -> Iterator[PeerEntry]:
    for workload in plan.workloads:
        if workload.short:
            yield measure_generated(workload, effort.error_inputs)
            told(f"{workload.name}: fuzzyc on the host")
            task = task_of(workload, effort.error_inputs, 20 if plan.short else 1)
            for peer in PEERS:
                yield measure_peer(peer, task)
                told(f"{workload.name}: {peer}")


def _speeds(plan: Plan, told: Told) -> Iterator[Speed]:
    for workload in plan.workloads:
        if workload.short:
            yield measure_speed(workload, 10_000 if plan.short else 1_000_000)
            told(f"{workload.name}: speed on the host")


def _versions() -> dict[str, str]:
    """The tools that figures may depend on."""
    found = {}
    for package in ("fuzzyc", "unicorn", "numpy", "matplotlib"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "of unknown version"
    return found


def _host() -> str:
    """Architecture, Python and C compiler."""
    toolchain = find_toolchain()
    done = subprocess.run([*toolchain.command, "-dumpversion"], capture_output=True, text=True, check=False)
    return f"{platform.machine()}, Python {platform.python_version()}, {toolchain.name} {done.stdout.strip()}"
