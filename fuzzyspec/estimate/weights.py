"""What a feature costs on a machine: the weights that ship with the compiler, and how far they were off.

``weights.json`` is written by ``scripts/fit_costs.py`` from the measurements in ``benchmarks/measured_costs.json``.
What divides is weighed by what it takes alone, whatever was fitted: ``dividers.json``, by
``scripts/measure_dividers.py``.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Literal

from fuzzyspec.estimate.features import Features

Option = Literal["O2", "Os"]
Figure = Literal["instructions", "cycles", "flash", "stack"]
MACHINES = ("cortex-m0plus", "cortex-m4", "cortex-m7", "rv32imc", "avr")


@dataclass(frozen=True)
class Weights:
    """One figure on one machine under one option of the compiler.

    ``by`` is keyed by feature, or by what stands before its point. The others are relative errors on the specs that
    were held out of a fit: half of them, nine in ten of them, and all of them were no further off.
    """

    by: Mapping[str, float]
    median: float
    nine_in_ten: float
    worst: float

    def of(self, features: Features) -> float:
        """The weight of features that occur so often."""
        by = self.by
        found = 0.0
        for name, count in features.items():
            weight = by.get(name)
            found += count * (by.get(name.partition(".")[0], 0.0) if weight is None else weight)
        return found


def weights(machine: str, option: Option, figure: Figure) -> Weights | None:
    """None where there is no honest figure: instructions on AVR, cycles on all but it and the Cortex-M0+.

    Raises KeyError for a machine that was never measured.
    """
    return _all()[machine].get((option, figure))


def dividers(machine: str, option: str, figure: str) -> Mapping[str, float]:
    """What the kernels that divide take alone, by feature."""
    found: Mapping[str, float] = _data("dividers.json")["machines"][machine][option].get(figure, {})
    return found


def divides(feature: str) -> bool:
    """Whether a feature is weighed by what a divider takes alone, and so by no fit."""
    return feature in _dividing()


def unseen(found: Iterable[str]) -> int:
    """How many of these features neither the fit saw in any program nor is a divider that was measured alone."""
    return len(set(found) - _seen() - _dividing())


@cache
def _dividing() -> frozenset[str]:
    machines = _data("dividers.json")["machines"]
    known = {f for options in machines.values() for figures in options.values() for by in figures.values() for f in by}
    stems = {name.removeprefix("kernel_") for name in known if name.startswith("kernel_")}
    return frozenset(known | {f"quotient_{stem}" for stem in stems})


@cache
def _seen() -> frozenset[str]:
    return frozenset(_data("weights.json")["seen"])


@cache
def _all() -> Mapping[str, Mapping[tuple[str, str], Weights]]:
    def by(fitted: Mapping[str, float], machine: str, option: str, figure: str) -> Mapping[str, float]:
        alone = dividers(machine, option, figure)
        return {**{k: w for k, w in fitted.items() if not (alone and divides(k))}, **alone}

    return {
        machine: {
            (option, figure): Weights(
                by(found["weights"], machine, option, figure), found["median"], found["nine_in_ten"], found["worst"]
            )
            for option, figures in options.items()
            for figure, found in figures.items()
        }
        for machine, options in _data("weights.json")["machines"].items()
    }


@cache
def _data(name: str) -> Any:
    return json.loads(files("fuzzyspec.estimate").joinpath(name).read_text(encoding="utf-8"))
