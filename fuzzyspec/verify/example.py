"""One case taken out of a batch, for showing and for shrinking."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from fuzzyspec.model.variable import Variable
from fuzzyspec.verify.cases import Batch
from fuzzyspec.verify.points import Raws
from fuzzyspec.verify.report import Example
from fuzzyspec.verify.subject import Subject


def single(batch: Batch, at: int) -> Batch:
    """The case ``at`` as a batch of its own."""
    inputs = {k: v[at : at + 1] for k, v in batch.inputs.items()}
    return Batch(batch.kind, inputs, {k: v[at : at + 1] for k, v in batch.state.items()})


def example_at(subject: Subject, batch: Batch, at: int) -> Example:
    """The case ``at`` with its values; list elements beyond the count are left out."""
    inputs: dict[str, int | tuple[int, ...]] = {}
    values: dict[str, str | tuple[str, ...]] = {}
    ports = subject.ports
    for key, array in batch.inputs.items():
        port = ports.get(key)
        if port is None:
            inputs[key] = int(array[at])
            continue
        assert port.variable is not None
        if array.ndim == 1:
            inputs[key] = int(array[at])
            values[key] = spoken(port.variable, int(array[at]))
        else:
            used = int(batch.inputs[f"{key.partition('.')[0]}.count"][at])
            raws = tuple(int(r) for r in array[at][:used])
            inputs[key] = raws
            values[key] = tuple(spoken(port.variable, r) for r in raws)
    state = {k: int(v[at]) for k, v in batch.state.items()}
    for key, raw in state.items():
        values[f"state {key}"] = spoken(subject.state[key].variable, raw)
    return Example(inputs, state, values)


def spoken(variable: Variable, raw: int) -> str:
    """A raw's value with its unit, short but exact enough to tell raws apart."""
    return f"{decimal(variable.raw.value(raw))} {variable.unit.symbol}".strip()


def decimal(value: Fraction) -> str:
    """Six significant digits."""
    return f"{float(value):.6g}"


def joined(batches: list[Batch]) -> Batch:
    """Batches of one function as one; lists are padded with zeros to the widest."""

    def stack(arrays: list[Raws]) -> Raws:
        if arrays[0].ndim == 1:
            return np.concatenate(arrays)
        width = max(a.shape[1] for a in arrays)
        return np.concatenate([np.pad(a, ((0, 0), (0, width - a.shape[1]))) for a in arrays])

    inputs = {k: stack([b.inputs[k] for b in batches]) for k in batches[0].inputs}
    state = {k: np.concatenate([b.state[k] for b in batches]) for k in batches[0].state}
    return Batch(batches[0].kind, inputs, state)
