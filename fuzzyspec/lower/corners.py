"""Sums of places over the corners of a cell, and their interpolation along the outer inputs.

Three programs for the same integers: two outputs in the halves of one word, each output by itself, or loops.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import prod

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    AssignElement,
    Binary,
    Comment,
    Const,
    CType,
    Define,
    DefineArray,
    Element,
    Expr,
    Local,
    Loop,
    Stmt,
    Table,
    Window,
)
from fuzzyspec.lower.formats import Format
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.scope import Scope

HALF_WORD = 16
REACH = 31
"""A load of Thumb reaches so many words beyond its register; for one that lies farther off the distance is loaded
first, each time."""
Lowered = tuple[list[Stmt], list[tuple[list[Stmt], Expr]], list[Table]]
"""What all outputs share, each output's own statements and interpolated place, and the tables."""


@dataclass(frozen=True, slots=True)
class Side:
    """The degrees of an outer input's two active terms; they sum to 1 exactly."""

    rest: Local
    degree: Local


@dataclass(frozen=True)
class Corners:
    """What the sums are made of: ``cell`` is the index of the low corner, ``weights`` those of the inner corners."""

    format: Format
    names: tuple[str, ...]
    shape: tuple[int, ...]
    cell: Local | Const
    weights: tuple[Local, ...]
    sides: tuple[Side, ...]

    @property
    def inner(self) -> list[int]:
        """Offsets of the inner corners from a cell."""
        return self._offsets(len(self.sides), len(self.shape))

    @property
    def outer(self) -> list[int]:
        """Offsets of the cells that the outer inputs' active terms name."""
        return self._offsets(0, len(self.sides))

    def _offsets(self, first: int, end: int) -> list[int]:
        strides = [prod(self.shape[i + 1 :]) for i in range(first, end)]
        return [sum(b * s for b, s in zip(bits, strides, strict=True)) for bits in product((0, 1), repeat=len(strides))]

    def padded(self, words: Sequence[int]) -> tuple[int, ...]:
        """A table by cell, continued to the last corner that is read: beyond the last cell only with a weight of 0."""
        size = self.cell.hi + self.outer[-1] + self.inner[-1] + 1
        return (*words, *[words[-1]] * (size - len(words)))

    def most(self, o: int) -> int:
        """The largest sum of an output, before its shift."""
        return self.format.outputs[o].most << self.format.bits


def packed(corners: Corners, scope: Scope) -> Lowered:
    """Two outputs in the halves of a word: no half's sum leaves it, so no carry passes between them."""
    shared: list[Stmt] = []
    values: list[tuple[list[Stmt], Expr]] = []
    tables: list[Table] = []
    outputs = range(len(corners.names))
    for pair in (list(outputs[i : i + 2]) for i in outputs[::2]):
        places = [corners.format.outputs[o].integers for o in pair]
        words = [sum(p << (HALF_WORD * k) for k, p in enumerate(cell)) for cell in zip(*places, strict=True)]
        name = "_".join(corners.names[o] for o in pair)
        steps, found, table = _written(corners, name, pair, words, scope, REACH)
        shared += steps
        values += [([], value) for value in found]
        tables.append(table)
    return shared, values, tables


def written(corners: Corners, scope: Scope) -> Lowered:
    """Every output by itself, in the narrowest table that holds its places."""
    values: list[tuple[list[Stmt], Expr]] = []
    tables: list[Table] = []
    for o, name in enumerate(corners.names):
        steps, found, table = _written(corners, name, [o], corners.format.outputs[o].integers, scope)
        values.append((steps, found[0]))
        tables.append(table)
    return [], values, tables


def _written(
    corners: Corners, name: str, outputs: list[int], words: Sequence[int], scope: Scope, reach: int | None = None
) -> tuple[list[Stmt], list[Expr], Table]:
    """Depth first, so that few values wait at a time; corners beyond ``reach`` are read from a window of their own."""
    fmt = corners.format
    table = Table(scope.name(f"{name}_places"), build.smallest_type(0, max(words)), corners.padded(words))
    steps: list[Stmt] = [Comment(f"{' and '.join(corners.names[o] for o in outputs)}: places of the active cells")]
    windows = [(0, _window(corners.cell, name, table, steps, scope))]
    highest = sum(corners.most(o) << (HALF_WORD * k) for k, o in enumerate(outputs))

    def at(level: int, offset: int) -> list[Expr]:
        if level == len(corners.sides):
            far = reach is not None and offset + corners.inner[-1] - windows[-1][0] > reach
            if far and isinstance(corners.cell, Local):
                windows.append((offset, _window(build.add(corners.cell, Const(offset)), name, table, steps, scope)))
            begin, source = windows[-1]
            return fields(_sum(corners, source, offset - begin, highest))
        stride = prod(corners.shape[level + 1 :])
        low, high = at(level + 1, offset), at(level + 1, offset + stride)
        shift = fmt.shifts[len(corners.sides) - 1 - level]
        side = corners.sides[level]
        return [bind(corners.names[o], _between(a, b, side, shift)) for o, a, b in zip(outputs, low, high, strict=True)]

    def bind(what: str, value: Expr) -> Local:
        local = build.local(scope.name(f"{what}_along"), value)
        steps.append(Define(local, value, True))
        return local

    def fields(word: Expr) -> list[Expr]:
        if len(outputs) == 1:
            return [bind(name, build.shift_right(word, fmt.dropped))]
        whole = bind(name, word)
        low = Binary("&", whole, Const((1 << HALF_WORD) - 1), 0, corners.most(outputs[0]))
        high = Binary(">>", whole, Const(HALF_WORD), 0, corners.most(outputs[1]))
        return [low, high]

    return steps, at(0, 0), table


def in_loops(corners: Corners, scope: Scope) -> Lowered:
    """The sums of all outputs in one array, halved along one outer input after the other."""
    fmt = corners.format
    each = len(corners.names)
    tables = [corners.padded(places.integers) for places in fmt.outputs]
    integers = tuple(itertools.chain(*tables))
    table = Table(scope.name("places"), build.smallest_type(0, max(integers)), integers)
    offsets = tuple(o * len(tables[0]) + c for o in range(each) for c in corners.outer)
    starts = Table(scope.name("corners"), build.smallest_type(0, max(offsets)), offsets)
    highest = max(corners.most(o) for o in range(each))
    array = scope.name("along")
    counter = Local(scope.name("c"), "uint8", 0, len(offsets) - 1)
    start: Expr = Element(starts.name, starts.ctype, counter, 0, max(offsets), True)
    if isinstance(corners.cell, Local):
        start = build.add_bounded(corners.cell, start, len(integers) - 1)
    place = build.local(scope.name("place"), start)
    inner: list[Stmt] = [Define(place, start, True)]
    source = _window(place, "corner", table, inner, scope)
    total = build.shift_right(_sum(corners, source, 0, highest), fmt.dropped)
    most = [corners.most(o) >> fmt.dropped for o in range(each)]
    count = len(offsets)
    inner.append(AssignElement(array, "uint32", counter, total, _each(most, count)))
    steps: list[Stmt] = [
        Comment("sums over the inner corners, then along the other inputs"),
        DefineArray(array, "uint32", len(offsets)),
        Loop(counter, len(offsets), tuple(inner)),
    ]
    for side, shift in zip(reversed(corners.sides), fmt.shifts, strict=True):
        count //= 2
        half = Local(scope.name("c"), "uint8", 0, count - 1)
        twice = build.mul(half, Const(2))
        low = Element(array, "uint32", twice, 0, max(most), False)
        high = Element(array, "uint32", build.add(twice, Const(1)), 0, max(most), False)
        between = _between(low, high, side, shift)
        most = [m * DEGREE_ONE >> shift for m in most]
        steps.append(Loop(half, count, (AssignElement(array, "uint32", half, between, _each(most, count)),)))
    values: list[tuple[list[Stmt], Expr]] = []
    for o, name in enumerate(corners.names):
        value = Local(scope.name(f"{name}_along"), "uint32", 0, most[o])
        values.append(([Define(value, Element(array, "uint32", Const(o), 0, most[o], False), True)], value))
    return steps, values, [table, starts]


def _each(most: Sequence[int], count: int) -> tuple[int, ...]:
    """By element: the outputs' stand one after the other."""
    return tuple(m for m in most for _ in range(count // len(most)))


def _window(start: Expr, name: str, table: Table, steps: list[Stmt], scope: Scope) -> Table | Window:
    """Where the cell varies its corners are read through a window, at constant indices."""
    if isinstance(start, Const):
        return table
    window = Window(scope.name(f"{name}_at"), table.ctype, table.name, start)
    steps.append(window)
    return window


def _sum(corners: Corners, source: Table | Window, offset: int, highest: int) -> Expr:
    """The weights sum to 1, so the sum is at most the largest word times it."""
    ctype: CType = source.ctype
    total: Expr | None = None
    bits = corners.format.bits
    for weight, inner in zip(corners.weights, corners.inner, strict=True):
        place = Element(source.name, ctype, Const(offset + inner), 0, highest >> bits, True)
        term = build.mul(place, weight)
        total = term if total is None else build.add_bounded(total, term, highest)
    assert total is not None
    return total


def _between(low: Expr, high: Expr, side: Side, shift: int) -> Expr:
    """``low (1 - d) + high d``; floored by the shift."""
    most = max(low.hi, high.hi) * DEGREE_ONE
    total = build.add_bounded(build.mul(low, side.rest), build.mul(high, side.degree), most)
    return build.shift_right(total, shift)
