"""A system's inputs as arrays of one length, saturated, and unit conversion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fuzzyspec.exact.result import Arrays, Bools, Floats
from fuzzyspec.model.system import ListInput, System
from fuzzyspec.model.units import Unit
from fuzzyspec.model.variable import Variable


@dataclass(frozen=True, slots=True)
class Signals:
    """``scalars`` (N,), ``fields`` (N, capacity), declared units; ``elements`` (N, capacity) True within the count."""

    cases: int
    scalars: dict[str, Floats]
    fields: dict[tuple[str, str], Floats]
    elements: dict[str, Bools]


def signals(system: System, inputs: Arrays, others: Arrays) -> Signals:
    """Take a step's inputs; ``others`` (decisions, state) have a say in the number of cases only.

    Raises KeyError where a signal is missing, ValueError where a count exceeds the records given.
    """
    lists = [i for i in system.inputs if isinstance(i, ListInput)]
    scalars = {i.name: np.asarray(inputs[i.name], dtype=np.float64) for i in system.inputs if isinstance(i, Variable)}
    counts = {i.name: np.asarray(inputs[f"{i.name}.count"]) for i in lists}
    records = {
        (i.name, f.name): np.atleast_2d(np.asarray(inputs[f"{i.name}.{f.name}"], dtype=np.float64))
        for i in lists
        for f in i.fields
    }
    (cases,) = np.broadcast_shapes(
        (1,),
        *(v.shape for v in (*scalars.values(), *counts.values())),
        *(v.shape[:1] for v in records.values()),
        *(np.shape(v)[:1] for v in others.values()),
    )
    found = Signals(cases, {}, {}, {})
    for i in system.inputs:
        if isinstance(i, ListInput):
            _take_list(found, i, counts[i.name], records)
        else:
            found.scalars[i.name] = np.broadcast_to(_saturated(scalars[i.name], i), (cases,))
    return found


def _take_list(found: Signals, of: ListInput, counts: Floats, records: dict[tuple[str, str], Floats]) -> None:
    count = np.broadcast_to(np.clip(counts, 0, of.capacity), (found.cases,))
    elements = np.arange(of.capacity) < count[:, None]
    found.elements[of.name] = elements
    for f in of.fields:
        given = records[of.name, f.name][:, : of.capacity]
        if count.max(initial=0) > given.shape[1]:
            raise ValueError(f"{of.name}.{f.name} has {given.shape[1]} records, the count says {count.max()}")
        whole = np.full((found.cases, of.capacity), float(f.lo))
        whole[:, : given.shape[1]] = given
        # what lies beyond the count may be anything, nan included
        found.fields[of.name, f.name] = _saturated(np.where(elements, whole, float(f.lo)), f)


def _saturated(values: Floats, variable: Variable) -> Floats:
    return np.asarray(np.clip(values, float(variable.lo), float(variable.hi)))


def saturated_into(values: Floats, variable: Variable) -> Floats:
    """Coherent values put into a variable: its unit, its range."""
    return _saturated(from_coherent(values, variable.unit), variable)


def to_coherent(values: Floats, unit: Unit) -> Floats:
    """One rounding less where the scale or its reciprocal is whole."""
    scale = unit.scale
    if scale.numerator == 1:
        values = values / scale.denominator if scale.denominator != 1 else values
    else:
        values = values * float(scale)
    return values + float(unit.offset) if unit.offset else values


def from_coherent(values: Floats, unit: Unit) -> Floats:
    """The inverse of ``to_coherent``, up to rounding."""
    if unit.offset:
        values = values - float(unit.offset)
    scale = unit.scale
    if scale.numerator == 1:
        return values * scale.denominator if scale.denominator != 1 else values
    return values / float(scale)
