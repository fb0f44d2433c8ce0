"""A function's input signals by name, and a user's arrays brought into their full shapes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fuzzyspec.model.controller import Controller
from fuzzyspec.model.system import ListInput, System
from fuzzyspec.model.variable import Variable


@dataclass(frozen=True, slots=True)
class Signals:
    """``variables``: every signal but the counts, ``list.field`` for fields. ``lists``: capacity by list name."""

    function: str
    variables: Mapping[str, Variable]
    lists: Mapping[str, int]

    def is_field(self, key: str) -> bool:
        """Whether a signal is a field of a list."""
        return key.partition(".")[0] in self.lists

    def fields(self, listed: str) -> list[str]:
        """The signals that are fields of a list."""
        return [k for k in self.variables if k.startswith(f"{listed}.")]

    @property
    def names(self) -> list[str]:
        """Every signal, the counts included."""
        return [*self.variables, *(f"{name}.count" for name in self.lists)]


def signals_of(model: Controller | System) -> Signals:
    """The input signals of a controller or system."""
    if isinstance(model, Controller):
        return Signals(model.name, {i.name: i.variable for i in model.inputs}, {})
    variables: dict[str, Variable] = {}
    lists: dict[str, int] = {}
    for item in model.inputs:
        if isinstance(item, ListInput):
            lists[item.name] = item.capacity
            variables.update({f"{item.name}.{f.name}": f for f in item.fields})
        else:
            variables[item.name] = item
    return Signals(model.name, variables, lists)


def arranged(signals: Signals, inputs: Mapping[str, npt.ArrayLike]) -> tuple[dict[str, npt.NDArray[Any]], int]:
    """Every signal as an array of its full shape, and N; what has no case axis is the same for all cases.

    Scalars become (N,), fields (N, M), counts (N,): all M where left out. ValueError names what does not fit.
    """
    given = {k: np.asarray(v) for k, v in inputs.items()}
    for key in given:
        if key not in signals.names:
            raise ValueError(f"`{signals.function}` has no input `{key}`; it has {', '.join(signals.names)}")
    for key in signals.variables:
        if key not in given:
            raise ValueError(f"`{signals.function}` wants an input `{key}`")
    axes = {k: 1 if k in signals.variables and signals.is_field(k) else 0 for k in given}
    for key, array in given.items():
        if array.ndim not in (axes[key], axes[key] + 1):
            raise ValueError(f"`{key}` has shape {array.shape}, not {'(N, M)' if axes[key] else '(N,)'}")
    lengths = {len(a) for k, a in given.items() if a.ndim > axes[k]}
    if len(lengths) > 1:
        raise ValueError(f"the signals differ in length: {', '.join(str(n) for n in sorted(lengths))}")
    n = lengths.pop() if lengths else 1
    found = {k: np.broadcast_to(given[k], (n, *given[k].shape[-1:] * axes[k])) for k in signals.variables}
    for name in signals.lists:
        widths = {found[k].shape[1] for k in signals.fields(name)}
        if len(widths) != 1:
            raise ValueError(f"the fields of `{name}` differ in width")
        width = widths.pop()
        count = given.get(f"{name}.count", np.asarray(width))
        if count.dtype.kind not in "iu" or count.min(initial=0) < 0 or count.max(initial=0) > 255:
            raise ValueError(f"`{name}.count` wants integers from 0 to 255")
        if min(count.max(initial=0), signals.lists[name]) > width:
            raise ValueError(f"`{name}.count` reaches {count.max()}, but the fields hold {width} elements")
        found[f"{name}.count"] = np.broadcast_to(count, (n,))
    return found, n
