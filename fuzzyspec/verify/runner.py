"""Anything that runs C over a batch of raws."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from fuzzyspec.fixed.run import Run
from fuzzyspec.native import Death, Result
from fuzzyspec.verify.subject import Arrays


class Runner(Protocol):
    """``NativeModule`` and ``NativeProcess`` are runners."""

    def run(self, function: str, inputs: Arrays, state: Arrays | None = None) -> Result | Death: ...


Bools = npt.NDArray[np.bool_]


def differing(got: Result, wanted: Run | Result) -> dict[str, Bools]:
    """Where C and model differ: ``output.<name>``, ``status`` and ``state.<key>`` to (N,)."""
    found: dict[str, Bools] = {}
    for name, values in wanted.outputs.items():
        found[f"output.{name}"] = got.outputs[name] != values
    found["status"] = got.status != wanted.status
    for key in got.state:
        found[f"state.{key}"] = got.state[key] != wanted.state[key]
    return found


def any_of(masks: dict[str, Bools], n: int) -> Bools:
    """Lanes at which any of the masks is set."""
    total = np.zeros(n, dtype=np.bool_)
    for mask in masks.values():
        total |= mask
    return total
