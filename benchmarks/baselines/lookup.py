"""A 16-bit lookup table with multilinear interpolation: what is used today where fuzzy inference is too slow.

The nodes lie evenly over each input's legal raws, and hold the exact meaning there, rounded to the output's raw.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.baselines.interface import DoesNotFit, InputC, interface_of, template
from fuzzyspec.fixed.program import Program
from fuzzyspec.fixed.quantise import quantise
from fuzzyspec.model.controller import Controller

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]
Exact = Callable[[Mapping[str, Floats]], Mapping[str, Floats]]
"""Outputs of N inputs, by name, in declared units."""

_NODE_BITS = {1: 6, 2: 4, 3: 3, 4: 3}
"""By the number of inputs: what the flash of a small part has room for (2 inputs: 578 bytes an output; 4: 13 KB)."""
_PLACE_BITS = 15
"""Of a place along an input, in all: node and way to the next one fit a uint16_t."""


@dataclass(frozen=True, slots=True)
class Axis:
    """``(raw - lo) * multiplier >> shift`` counts nodes, with ``bits`` bits behind the point."""

    name: str
    lo: int
    hi: int
    bits: int
    multiplier: int
    shift: int

    @property
    def nodes(self) -> int:
        return (1 << (_PLACE_BITS - self.bits)) + 1

    def node_raws(self) -> list[Fraction]:
        """Where the nodes are, in raws."""
        return [self.lo + Fraction((self.hi - self.lo) * k, self.nodes - 1) for k in range(self.nodes)]

    def place(self, raws: npt.ArrayLike) -> tuple[Ints, Ints]:
        """The node below (the last but one at the top), and the way to the next in parts of ``2^bits``."""
        above = np.clip(np.asarray(raws, dtype=np.int64), self.lo, self.hi) - self.lo
        at = (above * self.multiplier) >> self.shift
        node = at >> self.bits
        top = node > self.nodes - 2
        return np.where(top, self.nodes - 2, node), np.where(top, 1 << self.bits, at - (node << self.bits))


@dataclass(frozen=True, slots=True)
class Lookup:
    """A controller as tables. ``tables``: by output the raws above the lowest, of shape (nodes, nodes, ..)."""

    axes: tuple[Axis, ...]
    lows: Mapping[str, int]
    tables: Mapping[str, Ints]

    @property
    def bits(self) -> int:
        """Of the way from one node to the next."""
        return self.axes[0].bits

    def run(self, raws: Mapping[str, npt.ArrayLike]) -> dict[str, Ints]:
        """The integers that the C computes, by output."""
        places = [axis.place(raws[axis.name]) for axis in self.axes]
        return {name: self.lows[name] + self._interpolated(table, places) for name, table in self.tables.items()}

    def _interpolated(self, table: Ints, places: list[tuple[Ints, Ints]], *before: Ints) -> Ints:
        """Along the last input first."""
        if len(before) == len(places):
            found: Ints = table[before]
            return found
        node, part = places[len(before)]
        low = self._interpolated(table, places, *before, node)
        high = self._interpolated(table, places, *before, node + 1)
        one = 1 << self.bits
        joined: Ints = (low * (one - part) + high * part + one // 2) >> self.bits
        return joined


def lookup_of(controller: Controller, exact: Exact) -> Lookup:
    """The tables of a controller. DoesNotFit where they would have no place for what it returns, or for its inputs."""
    if controller.behaviors:
        raise DoesNotFit("a table has no place for the acting behavior")
    if any(o.fallback is not None and o.fallback.hold for o in controller.outputs):
        raise DoesNotFit("it keeps a state")
    if len(controller.inputs) not in _NODE_BITS:
        raise DoesNotFit(f"a table of {len(controller.inputs)} inputs has no room in a small part's flash")
    bits = _PLACE_BITS - _NODE_BITS[len(controller.inputs)]
    axes = tuple(_axis(i.name, i.variable.raw.lo, i.variable.raw.hi, bits) for i in controller.inputs)
    raws = [i.variable.raw for i in controller.inputs]
    values = [
        [float(raw.origin + raw.step * at) for at in axis.node_raws()] for axis, raw in zip(axes, raws, strict=True)
    ]
    grid = np.meshgrid(*values, indexing="ij")
    found = exact({axis.name: g.reshape(-1) for axis, g in zip(axes, grid, strict=True)})
    shape = tuple(axis.nodes for axis in axes)
    lows = {o.name: o.variable.raw.lo for o in controller.outputs}
    tables = {
        o.name: np.asarray(quantise(o.variable, found[o.name]), dtype=np.int64).reshape(shape) - lows[o.name]
        for o in controller.outputs
    }
    return Lookup(axes, lows, tables)


def _axis(name: str, lo: int, hi: int, bits: int) -> Axis:
    """The finest multiplier whose product stays within 32 bits, rounded up: the top raw is to reach the top node."""
    span, whole = hi - lo, 1 << _PLACE_BITS
    for shift in range(16, -1, -1):
        multiplier = math.ceil(Fraction(whole << shift, span))
        if multiplier * span < 1 << 32 and (multiplier * span) >> shift < 1 << 16:
            while multiplier % 2 == 0 and shift > 0:
                multiplier, shift = multiplier // 2, shift - 1
            return Axis(name, lo, hi, bits, multiplier, shift)
    raise DoesNotFit(f"{name} has too few raws for a table")


def lookup_c(lookup: Lookup, program: Program, controller: Controller, option: str = "O2") -> str:
    """The C, behind the generated header: written out, or with ``Os`` as loops over the corners. The same integers."""
    interface = interface_of(program, controller)
    c = interface.c
    strides = [lookup.axes[0].nodes ** k for k in reversed(range(len(lookup.axes)))]
    outputs = []
    for port in program.function(controller.name).outputs:
        member = c.outputs[port.name]
        low = lookup.lows[port.name]
        outputs.append(
            {
                "member": member,
                "table": f"{member}_table",
                "ctype": f"{port.ctype}_t",
                "entries": [f"{v}U" for v in lookup.tables[port.name].reshape(-1).tolist()],
                "raw": member if low == 0 else f"(int32_t){member} {low:+d}".replace("-", "- ").replace("+", "+ "),
                "interpolated": _nested(f"{member}_cell", [i.member for i in interface.inputs], strides, 0, 8),
            }
        )
    return template("lookup.c.j2").render(
        header=interface.names.header,
        status_t=interface.names.status_t,
        ok=interface.names.ok,
        function=c.function,
        input_t=c.input_t,
        output_t=c.output_t,
        inputs=interface.inputs,
        axes=[_axis_c(axis, of) for axis, of in zip(lookup.axes, interface.inputs, strict=True)],
        cell=" + ".join(f"{i.member}_node * {s}U" for i, s in zip(interface.inputs, strides, strict=True)),
        outputs=outputs,
        loops=option == "Os",
        corners=[sum(s for k, s in enumerate(reversed(strides)) if i >> k & 1) for i in range(1 << len(strides))],
        nodes=lookup.axes[0].nodes,
        bits=lookup.bits,
        one=1 << lookup.bits,
    )


def _axis_c(axis: Axis, of: InputC) -> dict[str, Any]:
    above = of.name if axis.lo == 0 else f"(int32_t){of.name} {'-' if axis.lo > 0 else '+'} {abs(axis.lo)}"
    product = f"{of.member}_above" if axis.multiplier == 1 else f"(uint32_t){of.member}_above * {axis.multiplier}U"
    at = product if axis.shift == 0 else f"({product}) >> {axis.shift}"
    return {"member": of.member, "above": above, "at": at}


def _nested(cell: str, members: list[str], strides: list[int], offset: int, indent: int) -> str:
    """The interpolation as one expression, a line a call."""
    pad = " " * indent
    if not members:
        return f"{pad}READ_16({cell}[{offset}])"
    if len(members) == 1:
        return f"{pad}between(READ_16({cell}[{offset}]), READ_16({cell}[{offset + strides[0]}]), {members[0]}_part)"
    low = _nested(cell, members[1:], strides[1:], offset, indent + 4)
    high = _nested(cell, members[1:], strides[1:], offset + strides[0], indent + 4)
    return f"{pad}between(\n{low},\n{high},\n{pad}    {members[0]}_part)"
