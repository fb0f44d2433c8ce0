"""How fast this machine evaluates: the C in batches, the integer program and the exact meaning in numpy."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.workloads import Workload
from fuzzyspec.fixed.program import Port
from fuzzyspec.fixed.run import run
from fuzzyspec.lower import Options
from fuzzyspec.native import NativeModule
from fuzzyspec.native.layout import DTYPES

_TIMES = 3
"""The best of so many: caches that others fill only ever add."""


@dataclass(frozen=True, slots=True)
class Speed:
    """Evaluations a second of one core's own time, over arrays of ``inputs`` inputs."""

    workload: str
    inputs: int
    native: float
    fixed: float
    exact: float


def measure_speed(workload: Workload, inputs: int) -> Speed:
    """``inputs`` for the C; a tenth of them for numpy."""
    spec, name = workload.spec, workload.function
    ports = spec.lowered.program.function(name).inputs
    cases = workload.cases(min(inputs, 10_000))
    many = {p.name: np.resize(cases[p.name], inputs).astype(DTYPES[p.ctype]) for p in ports if isinstance(p, Port)}
    fewer = {k: v[: max(1, inputs // 10)] for k, v in many.items()}
    values = spec.dequantise(name, fewer)
    count = len(next(iter(fewer.values())))
    # The target most like a host, as Spec.native takes it.
    files = spec.compile(Options(optimize="speed", target="cortex-m7")).files
    with NativeModule(spec.lowered.program, files) as native:
        return Speed(
            workload.name,
            inputs,
            inputs / _best(lambda: native.run(name, many)),
            count / _best(lambda: run(spec.lowered.program, name, fewer)),
            count / _best(lambda: spec.exact(name, values)),
        )


def _best(call: Callable[[], object]) -> float:
    """Seconds of the processor: what others do meanwhile does not count."""
    call()
    took = []
    for _ in range(_TIMES):
        start = time.process_time()
        call()
        took.append(time.process_time() - start)
    return min(took)
