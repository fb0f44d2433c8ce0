"""What is measured: W1 to W3s in both raw forms, the robot's two controllers and its whole step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fuzzyspec import api
from fuzzyspec.api import Spec
from fuzzyspec.estimate.inputs import draw_cases
from fuzzyspec.model.controller import Controller

ROOT = Path(__file__).resolve().parent.parent

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Workload:
    """One function. ``short`` names the four that peers are asked for too, and that the page begins with."""

    name: str
    file: str
    function: str
    what: str
    short: bool = False

    @property
    def spec(self) -> Spec:
        """The checked spec."""
        return load(self.file)

    @property
    def controller(self) -> Controller | None:
        """The controller; None for a system."""
        return self.spec.controllers.get(self.function)

    def cases(self, n: int) -> dict[str, Ints]:
        """The first n raws of the fixed sequence (docs/cost.md). Nothing that is measured here keeps a state."""
        program = self.spec.lowered.program
        inputs, state = draw_cases(program, program.function(self.function), n)
        assert state is None
        return inputs


@cache
def load(file: str) -> Spec:
    """A spec of this repository, checked once."""
    return api.load(ROOT / file)


def _both(name: str, function: str, what: str) -> tuple[Workload, Workload]:
    lower = name.lower()
    return (
        Workload(name, f"benchmarks/{lower}.fz", function, what, short=True),
        Workload(f"{name} raw16", f"benchmarks/{lower}_raw16.fz", function, f"{name} with raws 0..65535"),
    )


WORKLOADS = (
    *_both("W1", "tipper", "2 inputs of 3 terms, 9 rules, 1 output, centroid"),
    *_both("W2", "danger", "2 inputs of 3 terms, 9 rules, 1 output, centroid"),
    *_both("W3", "velocity", "4 inputs of 3 terms, 81 rules, 2 outputs, centroid"),
    *_both("W3s", "velocity", "W3 with product, singletons and weighted average"),
    Workload("nav danger", "examples/nav.fz", "danger", "the robot's first layer"),
    Workload(
        "nav velocity", "examples/nav.fz", "velocity", "its second layer: behaviors over 81 cells, 2 outputs, acting"
    ),
    Workload(
        "nav step",
        "examples/nav.fz",
        "nav",
        "the whole step: up to 16 obstacles through the first layer, then the second",
    ),
)


@dataclass(frozen=True, slots=True)
class Error:
    """Against the exact meaning over ``inputs`` inputs, in % of the output's range: the worst output's largest, and the
    mean over inputs and outputs."""

    inputs: int
    largest: float
    mean: float


def error_of(
    found: Mapping[str, npt.ArrayLike], exact: Mapping[str, npt.ArrayLike], ranges: Mapping[str, float]
) -> Error:
    """The error of outputs in declared units; ``ranges`` names the outputs that have one."""
    errors = [
        np.abs(np.asarray(found[name], dtype=float) - np.asarray(exact[name], dtype=float)) * (100 / ranges[name])
        for name in ranges
    ]
    return Error(len(errors[0]), float(max(e.max() for e in errors)), float(np.mean([e.mean() for e in errors])))


def ranges_of(workload: Workload) -> dict[str, float]:
    """The width of every output's range, in its unit; those without one (an acting behavior) are left out."""
    function = workload.spec.lowered.program.function(workload.function)
    return {o.name: float(o.variable.hi - o.variable.lo) for o in function.outputs if o.variable is not None}
