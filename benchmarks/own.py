"""fuzzyc and the plain baselines on microcontrollers: cost from the emulators, error against the exact meaning."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from benchmarks.baselines import SAMPLES, DoesNotFit, Lookup, float_c, lookup_c, lookup_of
from benchmarks.baselines.interface import alone, product_files
from benchmarks.workloads import Error, Ints, Workload, error_of, load, ranges_of
from fuzzyspec.cost import TARGETS, Conditions, CrossCompiler, Record, find_compiler, measure
from fuzzyspec.exact import dequantise
from fuzzyspec.fixed.program import Program
from fuzzyspec.fixed.run import Run, run
from fuzzyspec.lower import Options
from fuzzyspec.model.controller import Controller
from fuzzyspec.native import NativeModule, Toolchain

Kind = Literal["fuzzyc", "lookup table", "float C"]
KINDS: tuple[Kind, ...] = ("fuzzyc", "lookup table", "float C")

GCC_FPU = ("-mfpu=fpv4-sp-d16", "-mfloat-abi=softfp")
ZIG_FPU = {"thumb-freestanding-eabi": "thumb-freestanding-eabihf", "-mcpu=cortex_m4": "-mcpu=cortex_m4+vfp4d16sp"}
"""Float C on a Cortex-M4 may use the unit that most of them have."""


@dataclass(frozen=True, slots=True)
class Effort:
    """``cost_inputs`` for fuzzyc and the tables, ``error_inputs`` for errors.

    Float C gets ``float_inputs``: it is thousands of times as slow to emulate and nearly the same for all. Where it
    need not sample it gets ``single_inputs``.
    """

    targets: tuple[str, ...]
    cost_inputs: int = 1_000
    float_inputs: int = 4
    single_inputs: int = 100
    error_inputs: int = 10_000
    compiler: Literal["gcc", "zig"] | None = None


@dataclass(frozen=True, slots=True)
class Entry:
    """What one kind of C costs and errs on one workload; ``left_out`` says why there is nothing.

    ``certified``: the largest certified error of an output in % of range, for what has one.
    """

    workload: str
    kind: str
    records: tuple[Record, ...] = ()
    error: Error | None = None
    certified: float | None = None
    form: str = ""
    left_out: str = ""

    def record(self, target: str, option: str) -> Record | None:
        """The record of one build."""
        return next((r for r in self.records if (r.target, r.option) == (target, option)), None)


class WrongResult(Exception):
    """C that does not build, or whose emulated output is not its own model's: figures would be of something else."""


def measure_own(workload: Workload, kind: Kind, targets: tuple[str, ...], effort: Effort) -> Entry:
    """Build for these targets, run, compare. WrongResult where the C does not compute what it should."""
    if kind == "fuzzyc":
        return _fuzzyc(workload, targets, effort)
    controller = workload.controller
    try:
        if controller is None:
            raise DoesNotFit("a baseline is one controller")
        return (
            _lookup(workload, controller, targets, effort)
            if kind == "lookup table"
            else _float(workload, controller, targets, effort)
        )
    except DoesNotFit as reason:
        return Entry(workload.name, kind, left_out=str(reason))


def _fuzzyc(workload: Workload, targets: tuple[str, ...], effort: Effort) -> Entry:
    spec, name = workload.spec, workload.function

    def files(target: Any, option: str) -> Mapping[str, bytes]:
        return _generated(workload.file, target, option)

    conditions = Conditions(_compilers(targets, effort), inputs=effort.cost_inputs, only=(name,), worst=True)
    measured = measure(spec.lowered.program, files, conditions)
    if measured.mismatches:
        raise WrongResult(f"{workload.name}: {measured.mismatches[0]}")
    for record in measured.records:
        if record.exceeds:
            raise WrongResult(f"{workload.name}: a call took more than its worst case: {record}")
    raws = workload.cases(effort.error_inputs)
    found = spec.fixed(name, raws, raw=True)
    exact = spec.exact(name, spec.dequantise(name, raws), decisions=found.decisions)
    certified = [o.percent_of_range for o in spec.certificate(name).outputs if o.percent_of_range is not None]
    return Entry(
        workload.name,
        "fuzzyc",
        measured.records,
        error_of(found.outputs, exact.outputs, ranges_of(workload)),
        float(max(certified)),
    )


@cache
def _generated(file: str, target: Any, option: str) -> Mapping[str, bytes]:
    """As ``fuzzyc cost`` compiles it: for speed under -O2, for size under -Os. One file may hold several workloads."""
    return load(file).compile(Options(optimize="size" if option == "Os" else "speed", target=target)).files


def _lookup(workload: Workload, controller: Controller, targets: tuple[str, ...], effort: Effort) -> Entry:
    spec = workload.spec
    program = alone(spec.lowered.program, controller)
    lookup = lookup_of(controller, lambda values: spec.exact(controller.name, values).outputs)
    generated = spec.compile().files
    files = {o: product_files(program, generated, lookup_c(lookup, program, controller, o)) for o in ("O2", "Os")}

    def meaning(function: str, inputs: Mapping[str, Ints], state: object) -> Run:
        return replace(run(program, function, inputs), outputs=lookup.run(inputs))

    conditions = Conditions(_compilers(targets, effort), inputs=effort.cost_inputs)
    measured = measure(program, lambda _, option: files[option], conditions, meaning=meaning)
    if measured.mismatches:
        raise WrongResult(f"{workload.name}, lookup table: {measured.mismatches[0]}")
    error = _error(workload, lookup.run(workload.cases(effort.error_inputs)), effort)
    return Entry(workload.name, "lookup table", measured.records, error, form=_shape(lookup))


def _float(workload: Workload, controller: Controller, targets: tuple[str, ...], effort: Effort) -> Entry:
    """Held against the same C on this machine: float rounds alike everywhere, or nearly so."""
    spec = workload.spec
    program = alone(spec.lowered.program, controller)
    files = product_files(program, spec.compile().files, float_c(program, controller))
    sampled = controller.infer.defuzzify == "centroid"
    n = effort.float_inputs if sampled else effort.single_inputs
    with NativeModule(program, files) as native:

        def meaning(function: str, inputs: Mapping[str, Ints], state: object) -> Run:
            return replace(run(program, function, inputs), outputs=native.run(function, inputs).outputs)

        compilers = tuple(_with_fpu(c) for c in _compilers(targets, effort))
        conditions = Conditions(compilers, inputs=n, long_calls=True)
        slack = float_slack(program, controller)
        measured = measure(program, lambda _, __: files, conditions, meaning=meaning, slack=slack)
        if measured.mismatches:
            raise WrongResult(f"{workload.name}, float C: {measured.mismatches[0]}")
        error = _error(workload, native.run(controller.name, workload.cases(effort.error_inputs)).outputs, effort)
    form = f"{SAMPLES} samples" if sampled else "singletons"
    return Entry(workload.name, "float C", measured.records, error, form=form)


def float_slack(program: Program, controller: Controller) -> int:
    """Raws by which float C may differ between machines whose float operations are off by up to one unit.

    Area and moment add up as many numbers as there are samples or terms, each of a few operations; the quotient is off
    by the sum of their relative errors, and the nearest raw by one more.
    """
    span = max(o.hi - o.lo for o in program.function(controller.name).outputs)
    operations = 2 * (SAMPLES + 16)
    return math.ceil(operations * 2.0**-23 * span) + 1


def _error(workload: Workload, raws: Mapping[str, Ints], effort: Effort) -> Error:
    """Of raws that were computed for the error's inputs."""
    spec, name = workload.spec, workload.function
    exact = spec.exact(name, spec.dequantise(name, workload.cases(effort.error_inputs)))
    ports = spec.lowered.program.function(name).outputs
    found: dict[str, npt.NDArray[np.float64]] = {
        p.name: dequantise(p.variable, raws[p.name]) for p in ports if p.variable is not None
    }
    return error_of(found, exact.outputs, ranges_of(workload))


def _shape(lookup: Lookup) -> str:
    return " x ".join(str(axis.nodes) for axis in lookup.axes)


def _compilers(targets: tuple[str, ...], effort: Effort) -> tuple[CrossCompiler, ...]:
    return tuple(find_compiler(TARGETS[t], effort.compiler) for t in targets)


def _with_fpu(compiler: CrossCompiler) -> CrossCompiler:
    """A Cortex-M4's compiler with its float unit."""
    if compiler.target.name != "cortex-m4":
        return compiler
    words = compiler.toolchain.command
    if compiler.kind == "gcc":
        return replace(compiler, toolchain=Toolchain((*words, *GCC_FPU)))
    return replace(compiler, toolchain=Toolchain(tuple(ZIG_FPU.get(w, w) for w in words)))
