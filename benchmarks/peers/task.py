"""What a library is given, and what is told of it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import version
from typing import Any

import numpy as np

from benchmarks.workloads import Error, Floats, Workload, error_of, ranges_of
from fuzzyspec.model.controller import Controller
from fuzzyspec.model.term import PiecewiseLinear, Singleton, Term

SAMPLES = 100
"""Parts that the libraries cut an output's range into: fuzzylite's own choice, asked of all."""


class Skipped(Exception):
    """A library that is not here, or has no way to say the workload; the text says which."""


@dataclass(frozen=True, slots=True)
class Task:
    """A controller, inputs in declared units ((N,) each), and the exact outputs there. ``shorter`` divides the number
    of timed calls."""

    workload: str
    controller: Controller
    values: Mapping[str, Floats]
    exact: Mapping[str, Floats]
    ranges: Mapping[str, float]
    shorter: int = 1

    def first(self, n: int) -> Task:
        """The first inputs only, fewer still where a short run is asked for."""
        kept = max(1, n // self.shorter)
        return Task(
            self.workload,
            self.controller,
            {k: v[:kept] for k, v in self.values.items()},
            {k: v[:kept] for k, v in self.exact.items()},
            self.ranges,
            self.shorter,
        )

    @property
    def rows(self) -> list[tuple[float, ...]]:
        """The inputs one by one."""
        return list(zip(*(v.tolist() for v in self.values.values()), strict=True))

    def error(self, found: Mapping[str, Any]) -> Error:
        """Of outputs in declared units."""
        return error_of(found, self.exact, self.ranges)


@dataclass(frozen=True, slots=True)
class PeerEntry:
    """One library on one workload, on the host. ``nanoseconds`` an evaluation, ``timed`` of them; ``instructions`` an
    evaluation where they can be counted."""

    workload: str
    peer: str
    version: str = ""
    error: Error | None = None
    timed: int = 0
    nanoseconds: float | None = None
    instructions: float | None = None
    left_out: str = ""


def task_of(workload: Workload, inputs: int, shorter: int = 1) -> Task:
    """The first inputs of the fixed sequence, as values, and what they mean."""
    controller = workload.controller
    assert controller is not None, "peers are asked for controllers"
    spec = workload.spec
    values = spec.dequantise(workload.function, workload.cases(inputs))
    exact = spec.exact(workload.function, values).outputs
    return Task(workload.name, controller, values, exact, ranges_of(workload), shorter)


def imported(module: str) -> Any:
    """A library, or Skipped."""
    try:
        return import_module(module)
    except ImportError as error:
        raise Skipped("not installed") from error


def installed(package: str) -> str:
    """The version of a package that could be imported."""
    return version(package)


def evaluated(
    task: Task, evaluate: Callable[[tuple[float, ...]], Mapping[str, float]]
) -> tuple[dict[str, Floats], float]:
    """Every input by itself, and the processor's nanoseconds an evaluation.

    The first input comes once more before: a first call may set things up.
    """
    rows = task.rows
    evaluate(rows[0])
    start = time.process_time_ns()
    found = [evaluate(row) for row in rows]
    took = (time.process_time_ns() - start) / len(rows)
    return {name: np.array([f[name] for f in found], dtype=float) for name in task.exact}, took


def corners(term: Term) -> tuple[tuple[float, float], ...]:
    """The points of a term's membership."""
    assert isinstance(term.shape, PiecewiseLinear)
    return tuple((float(x), float(y)) for x, y in term.shape.points)


def triangle(term: Term) -> tuple[float, float, float]:
    """Left foot, peak, right foot; a shoulder has its foot in its peak."""
    points = corners(term)
    top = next(k for k, (_, y) in enumerate(points) if y == 1)
    return points[max(0, top - 1)][0], points[top][0], points[min(len(points) - 1, top + 1)][0]


def place(term: Term) -> float:
    """Of a singleton."""
    assert isinstance(term.shape, Singleton)
    return float(term.shape.at)


def rules(controller: Controller) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Every cell: its terms' indices by input, its consequents by output."""
    cells = controller.cells
    assert cells is not None
    indices = [tuple(int(i) for i in np.unravel_index(c, cells.shape)) for c in range(len(cells.owner))]
    return [(at, tuple(o[c] for o in cells.consequents)) for c, at in enumerate(indices)]


def averages(controller: Controller) -> bool:
    """Whether singletons are averaged, not areas."""
    return controller.infer.defuzzify == "weighted_average"
