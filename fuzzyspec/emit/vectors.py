"""Golden vectors of the self-test: corners, breakpoints and pseudo-random raws, the same on every machine."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from fuzzyspec.emit.ctypes import count_ctype
from fuzzyspec.fixed.build import LIMITS
from fuzzyspec.fixed.program import Function, ListPort, Port, Program, StatePort
from fuzzyspec.fixed.run import run
from fuzzyspec.model.system import Module
from fuzzyspec.model.term import PiecewiseLinear, Shape

COUNT = 32
"""Vectors a function."""

LONGEST = 3
"""Elements of a list that a vector fills at most (one more than the capacity where that is less)."""

Column = tuple[int, ...]


@dataclass(frozen=True)
class Vectors:
    """Columns of ``COUNT`` raws by signal; list fields hold ``lengths[list]`` raws a vector, flat."""

    inputs: Mapping[str, Column]
    lengths: Mapping[str, int]
    state: Mapping[str, Column]
    outputs: Mapping[str, Column]
    status: Column
    after: Mapping[str, Column]


class _Dice:
    """A 32-bit linear congruential generator (Numerical Recipes' constants), read from its upper half."""

    def __init__(self, seed: int) -> None:
        self._word = seed & 0xFFFFFFFF

    def below(self, n: int) -> int:
        """A number in ``0 .. n - 1``; n is at most 2**16 + 1."""
        self._word = (1664525 * self._word + 1013904223) & 0xFFFFFFFF
        return (self._word >> 8) * n >> 24


def golden(module: Module, program: Program, function: Function) -> Vectors:
    """Vectors of one function with what the integer model answers."""
    dice = _Dice(sum(map(ord, function.name)))
    inputs: dict[str, Column] = {}
    lengths: dict[str, int] = {}
    for port in function.inputs:
        if isinstance(port, ListPort):
            lengths[port.name] = length = min(LONGEST, port.capacity + 1, LIMITS[count_ctype(port.capacity)][1])
            inputs[f"{port.name}.count"] = tuple(dice.below(length + 1) for _ in range(COUNT))
            for field in port.fields:
                inputs[f"{port.name}.{field.name}"] = _column(field, (), COUNT * length, dice)
        else:
            inputs[port.name] = _column(port, breakpoints(module, function, port), COUNT, dice)
    state = {key: _column(port, (), COUNT, dice, legal=True) for key, port in states(program, function)}
    arrays: dict[str, npt.NDArray[np.int64]] = {}
    for name, column in inputs.items():
        rows = np.array(column, dtype=np.int64)
        length = len(column) // COUNT
        arrays[name] = rows if name.endswith(".count") or "." not in name else rows.reshape(COUNT, length)
    answer = run(program, function.name, arrays, {k: np.array(v, dtype=np.int64) for k, v in state.items()} or None)
    return Vectors(
        inputs,
        lengths,
        state,
        {port.name: _plain(answer.outputs[port.name]) for port in function.outputs},
        _plain(answer.status),
        {key: _plain(answer.state[key]) for key in state},
    )


def states(program: Program, function: Function) -> list[tuple[str, StatePort]]:
    """Everything that the function remembers, its calls' parts under ``<call>.<output>``."""
    found = [(s.name, s) for s in function.state]
    for name, callee in function.nested:
        found += [(f"{name}.{key}", s) for key, s in states(program, program.function(callee))]
    return found


def breakpoints(module: Module, function: Function, port: Port) -> tuple[int, ...]:
    """Raws nearest to where the memberships of a controller's input bend."""
    for controller in module.controllers:
        if function.kind == "controller" and controller.name == function.name:
            for given in controller.inputs:
                if given.name == port.name:
                    points = {x for t in given.terms for x in _bends(t.shape)}
                    return tuple(sorted({given.variable.raw.nearest(x) for x in points}))
    return ()


def _bends(shape: Shape) -> Iterable[Fraction]:
    return [x for x, _ in shape.points] if isinstance(shape, PiecewiseLinear) else [shape.at]


def _column(port: Port | StatePort, bends: Sequence[int], length: int, dice: _Dice, legal: bool = False) -> Column:
    """First the ends of the legal raws and of the type, then breakpoints and anything legal in turn."""
    low, high = (port.lo, port.hi) if legal else LIMITS[port.ctype]
    first = [port.lo, port.hi, low, high]
    notable = sorted({port.lo, port.hi, *bends, *(b + 1 for b in bends if b < port.hi)})
    rest = [
        notable[dice.below(len(notable))] if dice.below(3) == 0 else port.lo + dice.below(port.hi - port.lo + 1)
        for _ in range(length)
    ]
    return tuple((first + rest)[:length])


def _plain(column: npt.NDArray[np.int64]) -> Column:
    return tuple(int(x) for x in column)
