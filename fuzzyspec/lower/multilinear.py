"""Product, sum and weighted average over strong partitions: interpolation between the rules' places.

The degrees of an input's two active terms are d and 1 - d, so the strengths of the active cells sum to 1, nothing
is divided,
and the weighted average is the multilinear interpolation of the places that the cells name: along the last input first,
2**n - 1 interpolations between neighbours in all. One program serves every goal, whether written out or as loops.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    AssignElement,
    Comment,
    Const,
    Define,
    DefineArray,
    Element,
    Expr,
    Local,
    Loop,
    Stmt,
    Table,
)
from fuzzyspec.lower.fuzzify import Degrees
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.controller import CellRules, Controller
from fuzzyspec.model.term import Singleton

HALF = Fraction(1, 2)
PLACE_MAX = 65535
"""Places are uint16: raw counts with as many fraction bits as fit."""
EXTRA_BITS = 1
"""Interpolated values keep 17 bits: times a degree they still fit 32."""
MOST_INPUTS = 5
WRITTEN_OUT = 4
"""Up to this many inputs the interpolations are written out, unless size is asked for."""


@dataclass(frozen=True)
class MultilinearNumbers:
    """``edges[i]`` is the largest distance between two neighbouring cells' places along input i, relative to the range.

    ``rounding`` bounds, in raw counts, what places, interpolations and the last step are rounded by.
    """

    edges: tuple[Fraction, ...]
    rounding: Fraction


def applies(controller: Controller) -> bool:
    """Whether a controller's outputs are such interpolations."""
    infer = controller.infer
    return (
        controller.cells is not None
        and not controller.sentences
        and not controller.behaviors
        and infer.and_ == "product"
        and infer.aggregate == "sum"
        and infer.defuzzify == "weighted_average"
        and len(controller.inputs) <= MOST_INPUTS
        and all(i.peaks is not None and len(i.peaks) > 1 for i in controller.inputs)
        and all(controller.always_fires)
        and all(-1 not in c for c in controller.cells.consequents)
    )


def interpolate(
    controller: Controller, cells: CellRules, degrees: list[Degrees], compact: bool, body: list[Stmt], scope: Scope
) -> tuple[list[tuple[list[Stmt], Expr, MultilinearNumbers]], list[Table]]:
    """For every output its statements, raw and numbers; what they share goes to ``body``."""
    strides = [math.prod(cells.shape[i + 1 :]) for i in range(len(cells.shape))]
    base: Expr = Const(0)
    for d, stride in zip(degrees, strides, strict=True):
        base = build.add(base, build.mul(d.first, Const(stride)))
    body.append(Comment("the cell of the lower active terms"))
    if not isinstance(base, Const | Local):
        bound = build.local(scope.name("cell"), base)
        body.append(Define(bound, base, True))
        base = bound
    sides: list[tuple[Local, Local]] = []
    for item, d in zip(controller.inputs, degrees, strict=True):
        assert d.upper is not None
        rest = Local(scope.name(f"{item.name}_rest"), "uint16", 0, DEGREE_ONE)
        body.append(Define(rest, build.sub(Const(DEGREE_ONE), d.upper), True))
        sides.append((rest, d.upper))
    offsets = [sum(b * s for b, s in zip(bits, strides, strict=True)) for bits in product((0, 1), repeat=len(strides))]
    tables: list[Table] = []
    found: list[tuple[list[Stmt], Expr, MultilinearNumbers]] = []
    in_loops = compact or len(strides) > WRITTEN_OUT
    corners = Table(scope.name("corners"), build.smallest_type(0, max(offsets)), tuple(offsets))
    if in_loops:
        tables.append(corners)
    for o, output in enumerate(controller.outputs):
        places = _places(controller, o)
        named = [places[t] for t in cells.consequents[o]]
        raw = output.variable.raw
        at_lo, at_hi = raw.position(output.variable.lo), raw.position(output.variable.hi)
        low = at_lo - raw.lo if raw.step > 0 else raw.hi - at_lo
        exact = [low + abs(at_hi - at_lo) * p for p in named]
        counts = raw.hi - raw.lo
        bits = 0
        while (counts + 1) << (bits + 1) <= PLACE_MAX:
            bits += 1
        integers = tuple(max(0, math.floor(e * 2**bits + HALF)) for e in exact)
        table = Table(scope.name(f"{output.name}_places"), "uint16", integers)
        tables.append(table)
        steps: list[Stmt] = [Comment(f"{output.name}: interpolated between the places of the active cells")]
        walk = _loops if in_loops else _written_out
        value = walk(output.name, table, base, corners, sides, steps, scope)
        near = build.rounded_shift(value, bits + EXTRA_BITS)
        steps_up = build.local(scope.name(f"{output.name}_steps"), near)
        steps.append(Define(steps_up, near, True))
        capped = build.least(steps_up, Const(counts))
        result = build.add(capped, Const(raw.lo)) if raw.step > 0 else build.sub(Const(raw.hi), capped)
        worst = max(abs(Fraction(i, 2**bits) - e) for i, e in zip(integers, exact, strict=True))
        # The last step rounds once; each input's interpolations half a unit of the values they make.
        rounding = worst + Fraction(len(strides), 2 ** (bits + EXTRA_BITS + 1)) + HALF
        sliver = low + abs(at_hi - at_lo) - counts
        found.append((steps, result, MultilinearNumbers(_edges(cells.shape, named), max(rounding, sliver))))
    return found, tables


def _places(controller: Controller, o: int) -> list[Fraction]:
    variable = controller.outputs[o].variable
    places: list[Fraction] = []
    for term in controller.outputs[o].terms:
        assert isinstance(term.shape, Singleton)
        places.append((term.shape.at - variable.lo) / (variable.hi - variable.lo))
    return places


def _edges(shape: tuple[int, ...], named: list[Fraction]) -> tuple[Fraction, ...]:
    edges: list[Fraction] = []
    for i in range(len(shape)):
        stride = math.prod(shape[i + 1 :])
        inner = [c for c in range(len(named)) if c // stride % shape[i] < shape[i] - 1]
        edges.append(max((abs(named[c + stride] - named[c]) for c in inner), default=Fraction(0)))
    return tuple(edges)


def _between(low: Expr, high: Expr, side: tuple[Local, Local], lift: int) -> Expr:
    """``low (1 - d) + high d``, rounded, with ``lift`` more fraction bits than its operands."""
    rest, d = side
    hi = max(low.hi, high.hi)
    total = build.add_bounded(build.mul(low, rest), build.mul(high, d), hi * DEGREE_ONE)
    shift = DEGREE_ONE.bit_length() - 1 - lift
    return build.shift_right(
        build.add_bounded(total, Const(1 << (shift - 1)), min(hi * DEGREE_ONE + (1 << (shift - 1)), 2**32 - 1)), shift
    )


def _written_out(
    name: str,
    table: Table,
    base: Expr,
    corners: Table,
    sides: list[tuple[Local, Local]],
    steps: list[Stmt],
    scope: Scope,
) -> Expr:
    """Depth first, so that few values wait at a time."""

    def at(level: int, first: int) -> Expr:
        if level == len(sides):
            place = build.add(base, Const(corners.values[first]))
            return Element(table.name, "uint16", place, 0, PLACE_MAX, True)
        half = 1 << (len(sides) - level - 1)
        last = level == len(sides) - 1
        low, high = at(level + 1, first), at(level + 1, first + half)
        if last:
            low, high = bound(low, "low"), bound(high, "high")
        return bound(_between(low, high, sides[level], EXTRA_BITS if last else 0), "along")

    def bound(value: Expr, what: str) -> Local:
        hi = min(value.hi, PLACE_MAX << EXTRA_BITS)
        local = Local(scope.name(f"{name}_{what}"), "uint32" if what == "along" else "uint16", 0, hi)
        steps.append(Define(local, value, True))
        return local

    return at(0, 0)


def _loops(
    name: str,
    table: Table,
    base: Expr,
    corners: Table,
    sides: list[tuple[Local, Local]],
    steps: list[Stmt],
    scope: Scope,
) -> Expr:
    """All corners in an array, halved along one input after the other."""
    count = len(corners.values)
    array = scope.name(f"{name}_corner")
    most = PLACE_MAX << EXTRA_BITS
    counter = Local(scope.name("c"), "uint8", 0, count - 1)
    offset = Element(corners.name, corners.ctype, counter, 0, max(corners.values), True)
    place = Local(scope.name("place"), "uint32", 0, len(table.values) - 1)
    steps += [
        DefineArray(array, "uint32", count),
        Loop(
            counter,
            count,
            (
                Define(place, build.add_bounded(base, offset, len(table.values) - 1), True),
                AssignElement(array, "uint32", counter, Element(table.name, "uint16", place, 0, PLACE_MAX, True)),
            ),
        ),
    ]
    for i in range(len(sides) - 1, -1, -1):
        first = i == len(sides) - 1
        hi = PLACE_MAX if first else most
        half = Local(scope.name("c"), "uint8", 0, (1 << i) - 1)
        twice = build.mul(half, Const(2))
        low = Element(array, "uint32", twice, 0, hi, False)
        high = Element(array, "uint32", build.add(twice, Const(1)), 0, hi, False)
        value = _between(low, high, sides[i], EXTRA_BITS if first else 0)
        steps.append(Loop(half, 1 << i, (AssignElement(array, "uint32", half, value),)))
    result = Local(scope.name(f"{name}_along"), "uint32", 0, most)
    steps.append(Define(result, Element(array, "uint32", Const(0), 0, most, False), True))
    return result
