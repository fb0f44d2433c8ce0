"""A function's interface as a row of arrays: what a batch passes in, and what it brings back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fuzzyspec.emit.names import Names
from fuzzyspec.fixed.program import CType, Function, ListPort, Port, Program, StatePort

Ints = npt.NDArray[np.integer[Any]]

DTYPES: dict[CType, type[np.integer[Any]]] = {
    "uint8": np.uint8,
    "int8": np.int8,
    "uint16": np.uint16,
    "int16": np.int16,
    "uint32": np.uint32,
    "int32": np.int32,
}


def count_ctype(capacity: int) -> CType:
    """The C type of a list's count."""
    return "uint8" if capacity <= 255 else "uint16"


@dataclass(frozen=True, slots=True)
class Slot:
    """One array: ``key`` as in the signal dictionaries, ``member`` its C member (``drive.v`` inside a state).

    ``list`` is the index of the list that the array is a field of (shape (N, M)), or None (shape (N,)).
    """

    key: str
    member: str
    ctype: CType
    list: int | None = None

    @property
    def dtype(self) -> type[np.integer[Any]]:
        return DTYPES[self.ctype]


@dataclass(frozen=True, slots=True)
class ListSlot:
    """A list and the positions of its count and fields among the input slots."""

    name: str
    capacity: int
    count: int
    fields: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Layout:
    """The arrays of one function, in the order in which they are handed over.

    In: ``inputs`` then ``state``. Out: ``outputs``, the status (uint32), then ``state``.
    """

    function: str
    inputs: tuple[Slot, ...]
    lists: tuple[ListSlot, ...]
    outputs: tuple[Slot, ...]
    state: tuple[Slot, ...]


@dataclass(frozen=True, slots=True)
class Result:
    """What N calls returned: raws by output name, status words, and the states after the call, each (N,) int64."""

    outputs: dict[str, npt.NDArray[np.int64]]
    status: npt.NDArray[np.int64]
    state: dict[str, npt.NDArray[np.int64]]


def appended(results: list[Result]) -> Result:
    """One batch's results after another's."""
    outputs = {k: np.concatenate([r.outputs[k] for r in results]) for k in results[0].outputs}
    state = {k: np.concatenate([r.state[k] for r in results]) for k in results[0].state}
    return Result(outputs, np.concatenate([r.status for r in results]), state)


@dataclass(frozen=True, slots=True)
class Packed:
    """N cases as contiguous arrays in a layout's order; ``widths`` is M of each list."""

    n: int
    widths: tuple[int, ...]
    arrays: tuple[Ints, ...]


def layout_of(program: Program, function: Function, names: Names) -> Layout:
    """The layout of one function's C interface."""
    c = names.functions[function.name]
    inputs: list[Slot] = []
    lists: list[ListSlot] = []
    for port in function.inputs:
        match port:
            case Port():
                inputs.append(Slot(port.name, c.inputs[port.name], port.ctype))
            case ListPort():
                count, members = len(inputs), c.record_fields[port.name]
                inputs.append(Slot(f"{port.name}.count", c.counts[port.name], count_ctype(port.capacity)))
                inputs.extend(Slot(f"{port.name}.{f.name}", members[f.name], f.ctype, len(lists)) for f in port.fields)
                fields = tuple(range(count + 1, len(inputs)))
                lists.append(ListSlot(port.name, port.capacity, count, fields))
    state = [Slot(s.name, c.state[s.name], s.ctype) for s in function.state]
    for name, callee in function.nested:
        inner = names.functions[callee].state
        for s in program.function(callee).state:
            state.append(Slot(f"{name}.{s.name}", f"{c.state[name]}.{inner[s.name]}", s.ctype))
    outputs = tuple(Slot(o.name, c.outputs[o.name], o.ctype) for o in function.outputs)
    return Layout(function.name, tuple(inputs), tuple(lists), outputs, tuple(state))


def ports_of(function: Function) -> dict[str, Port]:
    """Every input raw by signal name, without the counts."""
    found: dict[str, Port] = {}
    for port in function.inputs:
        match port:
            case Port():
                found[port.name] = port
            case ListPort():
                found.update({f"{port.name}.{f.name}": f for f in port.fields})
    return found


def states_of(program: Program, function: Function) -> dict[str, StatePort]:
    """What survives a call, by state key."""
    found = {s.name: s for s in function.state}
    for name, callee in function.nested:
        found.update({f"{name}.{s.name}": s for s in program.function(callee).state})
    return found


def out_types(layout: Layout) -> list[CType]:
    """The C types of what comes back, in order."""
    return [*(s.ctype for s in layout.outputs), "uint32", *(s.ctype for s in layout.state)]


def _as(values: npt.ArrayLike, slot: Slot) -> Ints:
    """The array in the slot's C type; ValueError where a raw does not fit it."""
    given = np.asarray(values)
    if given.dtype.kind not in "iub":
        raise ValueError(f"`{slot.key}` wants integers (raws), not {given.dtype}")
    converted = np.ascontiguousarray(given, dtype=slot.dtype)
    if given.dtype != slot.dtype and not np.array_equal(given, converted):
        raise ValueError(f"`{slot.key}` holds raws outside {slot.ctype}_t")
    return converted


def pack(layout: Layout, inputs: Mapping[str, npt.ArrayLike], state: Mapping[str, npt.ArrayLike] | None) -> Packed:
    """Arrange signals and states (None: none needed) for a batch. ValueError names what is missing or does not fit."""
    given = dict(inputs)
    arrays: list[Ints] = []
    for slot in layout.inputs:
        if slot.key not in given:
            raise ValueError(f"`{layout.function}` wants an input `{slot.key}`")
        arrays.append(_as(given.pop(slot.key), slot))
    if given:
        raise ValueError(f"`{layout.function}` has no input `{next(iter(given))}`")
    for slot in layout.state:
        if state is None or slot.key not in state:
            raise ValueError(f"`{layout.function}` wants a state `{slot.key}`")
        arrays.append(_as(state[slot.key], slot))
    slots = layout.inputs + layout.state
    n = len(arrays[0]) if arrays and arrays[0].ndim else 0
    for slot, array in zip(slots, arrays, strict=True):
        if array.ndim != (1 if slot.list is None else 2) or len(array) != n:
            shape = f"({n},)" if slot.list is None else f"({n}, M)"
            raise ValueError(f"`{slot.key}` has shape {array.shape}, not {shape}")
    return Packed(n, _widths(layout, arrays), tuple(arrays))


def _widths(layout: Layout, arrays: list[Ints]) -> tuple[int, ...]:
    widths: list[int] = []
    for listed in layout.lists:
        found = {arrays[f].shape[1] for f in listed.fields}
        if len(found) != 1:
            raise ValueError(f"the fields of `{listed.name}` differ in width")
        width = found.pop()
        count = arrays[listed.count]
        needed = min(int(count.max(initial=0)), listed.capacity)
        if needed > width:
            raise ValueError(f"`{listed.name}.count` reaches {needed}, but its fields hold {width} elements")
        widths.append(width)
    return tuple(widths)


def out_arrays(layout: Layout, n: int) -> tuple[Ints, ...]:
    """Empty arrays for a batch of n to write into, in the layout's order."""
    return tuple(np.zeros(n, dtype=DTYPES[t]) for t in out_types(layout))


def unpack(layout: Layout, arrays: tuple[Ints, ...]) -> Result:
    """Name the arrays that a batch wrote."""
    wide = [a.astype(np.int64) for a in arrays]
    after = len(layout.outputs)
    return Result(
        dict(zip((s.key for s in layout.outputs), wide[:after], strict=True)),
        wide[after],
        dict(zip((s.key for s in layout.state), wide[after + 1 :], strict=True)),
    )
