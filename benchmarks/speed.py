"""How fast this machine evaluates: the C in batches, the integer program and the exact meaning in numpy."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

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


HOST = Options(optimize="speed", target="cortex-m7")
"""The target most like a host, as ``Spec.native`` takes it."""


def measure_speed(workload: Workload, inputs: int) -> Speed:
    """``inputs`` for the C; a tenth of them for numpy."""
    spec, name = workload.spec, workload.function
    fewer = _cases(workload, max(1, inputs // 10))
    values = spec.dequantise(name, fewer)
    count = max(1, inputs // 10)
    return Speed(
        workload.name,
        inputs,
        measure_native(workload, inputs),
        count / _best(lambda: run(spec.lowered.program, name, fewer)),
        count / _best(lambda: spec.exact(name, values)),
    )


def measure_native(workload: Workload, inputs: int) -> float:
    """The C in batches, evaluations a second."""
    spec, cases = workload.spec, _cases(workload, inputs)
    with NativeModule(spec.lowered.program, spec.compile(HOST).files) as native:
        return inputs / _best(lambda: native.run(workload.function, cases))


def _cases(workload: Workload, n: int) -> dict[str, npt.NDArray[Any]]:
    """The fixed sequence's beginning as often as needed, in the C types."""
    ports = workload.spec.lowered.program.function(workload.function).inputs
    cases = workload.cases(min(n, 10_000))
    return {p.name: np.resize(cases[p.name], n).astype(DTYPES[p.ctype]) for p in ports if isinstance(p, Port)}


def _best(call: Callable[[], object]) -> float:
    """Seconds of the processor: what others do meanwhile does not count."""
    call()
    took = []
    for _ in range(_TIMES):
        start = time.process_time()
        call()
        took.append(time.process_time() - start)
    return min(took)
