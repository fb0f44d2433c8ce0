"""Product, sum and weighted average over strong partitions: interpolation between the rules' places.

The degrees of an input's two active terms are d and 1 - d, so the strengths of the active cells sum to 1, nothing
is divided, and the weighted average is the multilinear interpolation of the places that the cells name. The weights of
the last two inputs' four corners multiply places straight from the table; the other inputs follow one by one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Comment, Const, Define, Expr, Local, StatusBit, Stmt, Table
from fuzzyspec.lower.corners import Corners, Side, in_loops, packed, written
from fuzzyspec.lower.formats import Format, as_counts, format_of
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.scope import Scope
from fuzzyspec.lower.slide import Cell, fuzzified, highest
from fuzzyspec.lower.strategy import Interpolation
from fuzzyspec.model.controller import CellRules, Controller

MOST_WRITTEN = 6
"""Inputs at most whose corners, 2^inputs of an output, are written out."""
MOST_WORDS = 1024
"""Of a table with two outputs in a word. Larger ones take too much room for what they save."""


@dataclass(frozen=True)
class MultilinearNumbers:
    """``edges[i]`` is the largest distance between two neighbouring cells' places along input i, relative to the range.

    ``rounding`` bounds, in raw counts, what places, interpolations and the last step are rounded by.
    """

    edges: tuple[Fraction, ...]
    rounding: Fraction


@dataclass(frozen=True)
class Interpolated:
    """A whole controller's body up to its outputs: what they share, then for each its statements, raw and numbers."""

    body: list[Stmt]
    status: list[StatusBit]
    degree_errors: tuple[tuple[Fraction, ...], ...]
    outputs: list[tuple[list[Stmt], Expr, MultilinearNumbers]]
    tables: list[Table]


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
        and all(i.peaks is not None and len(i.peaks) > 1 for i in controller.inputs)
        and all(controller.always_fires)
        and all(-1 not in c for c in controller.cells.consequents)
    )


def ways(controller: Controller) -> tuple[Interpolation, ...]:
    """How a controller that this applies to can be computed."""
    assert controller.cells is not None
    if len(controller.inputs) > MOST_WRITTEN:
        return ("loops",)
    small = math.prod(controller.cells.shape) <= MOST_WORDS
    if small and len(controller.outputs) > 1 and format_of(controller, controller.cells).narrow:
        return ("loops", "written", "packed")
    return ("loops", "written")


def corners_of(controller: Controller) -> int:
    """How many sums of inner corners there are, over all outputs."""
    return len(controller.outputs) << max(0, len(controller.inputs) - 2)


def interpolate(controller: Controller, cells: CellRules, way: Interpolation, scope: Scope) -> Interpolated:
    """Lower by one of the controller's :func:`ways`."""
    fmt = format_of(controller, cells)
    body, status, cell, degrees, errors = _fuzzified(controller, cells, fmt, scope)
    weights = _weights(controller, degrees[len(degrees) - fmt.inner :], fmt.bits, body, scope)
    sides: list[Side] = []
    for item, degree in zip(controller.inputs, degrees[: len(degrees) - fmt.inner], strict=False):
        rest = Local(scope.name(f"{item.name}_rest"), "uint16", 0, DEGREE_ONE)
        body.append(Define(rest, build.sub(Const(DEGREE_ONE), degree), True))
        sides.append(Side(rest, degree))
    names = tuple(o.name for o in controller.outputs)
    corners = Corners(fmt, names, cells.shape, cell.local or Const(0), tuple(weights), tuple(sides))
    lower = {"packed": packed, "written": written, "loops": in_loops}[way]
    shared, values, tables = lower(corners, scope)
    body += shared
    found: list[tuple[list[Stmt], Expr, MultilinearNumbers]] = []
    for o, output in enumerate(controller.outputs):
        raw, places = output.variable.raw, fmt.outputs[o]
        steps, value = values[o]
        near, off = as_counts(fmt, o, value, output.name, steps, scope)
        result = build.add(near, Const(raw.lo)) if raw.step > 0 else build.sub(Const(raw.hi), near)
        numbers = MultilinearNumbers(places.edges, max(fmt.rounding(o) + off, places.sliver))
        found.append((steps, result, numbers))
    return Interpolated(body, status, errors, found, tables)


def _fuzzified(
    controller: Controller, cells: CellRules, fmt: Format, scope: Scope
) -> tuple[list[Stmt], list[StatusBit], Cell, list[Local], tuple[tuple[Fraction, ...], ...]]:
    strides = [math.prod(cells.shape[i + 1 :]) for i in range(len(cells.shape))]
    top = sum(highest(i) * s for i, s in zip(controller.inputs, strides, strict=True))
    cell = Cell(Local(scope.name("cell"), build.smallest_type(0, top), 0, top) if top else None)
    body: list[Stmt] = []
    if cell.local is not None:
        body += [Comment("the cell of the lower active terms, counted up input by input")]
        body += [Define(cell.local, Const(0), False)]
    status: list[StatusBit] = []
    degrees: list[Local] = []
    errors: list[tuple[Fraction, ...]] = []
    saturations: list[Stmt] = []
    for i, (item, stride) in enumerate(zip(controller.inputs, strides, strict=True)):
        variable = item.variable
        low, high = build.LIMITS[variable.raw.ctype]
        bit = f"SATURATED_{variable.name.upper()}"
        if low < variable.raw.lo or high > variable.raw.hi:
            status.append(StatusBit(bit, f"{variable.name} was outside its range and was saturated"))
        body.append(Comment(f"{item.name}: degrees of {', '.join(t.name for t in item.terms)}"))
        one = 1 << fmt.bits if i >= len(strides) - fmt.inner else DEGREE_ONE
        found = fuzzified(item, one, cell, stride, bit, scope)
        body += found.steps
        saturations += found.told
        degrees.append(found.degree)
        errors.append((found.error,) * len(item.terms))
    return body + saturations, status, cell, degrees, tuple(errors)


def _weights(controller: Controller, degrees: list[Local], bits: int, body: list[Stmt], scope: Scope) -> list[Local]:
    """Of the corners of the last inputs, the low one first; they sum to 1 exactly. Their product is rounded once."""
    one = Const(1 << bits)

    def bound(name: str, value: Expr) -> Local:
        local = Local(scope.name(name), "uint16", 0, 1 << bits)
        body.append(Define(local, value, True))
        return local

    last = degrees[-1]
    if len(degrees) == 1:
        return [bound(f"{controller.inputs[-1].name}_rest", build.sub(one, last)), last]
    first = degrees[0]
    body.append(Comment(f"weights of the corners of {controller.inputs[-2].name} and {controller.inputs[-1].name}"))
    both = bound("both", build.rounded_shift(build.mul(first, last), bits))
    only_last = bound(f"only_{controller.inputs[-1].name}", build.sub_guarded(last, both, 1 << bits))
    only_first = bound(f"only_{controller.inputs[-2].name}", build.sub_guarded(first, both, 1 << bits))
    neither = bound("neither", build.sub_guarded(build.sub(one, first), only_last, 1 << bits))
    return [neither, only_last, only_first, both]
