"""Where a signal's behaviour changes: breakpoints, thresholds and ends, as exact values and as raws around them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from fuzzyspec.fixed.program import Port
from fuzzyspec.model.controller import Controller, Input
from fuzzyspec.model.system import Compare, Const, Expr, ReadField, ReadInput, System
from fuzzyspec.model.term import PiecewiseLinear, Shape, Singleton
from fuzzyspec.model.variable import RAW_LIMITS, Raw
from fuzzyspec.verify.subject import Subject
from fuzzyspec.verify.walk import nodes

Raws = npt.NDArray[np.int64]
Piece = tuple[Fraction, Fraction, Fraction, Fraction]
"""A sloping line from (x0, y0) to (x1, y1), flattened."""

AROUND = 2
"""How many raws on each side of a special value are tried."""


@dataclass(frozen=True, slots=True)
class Special:
    """A signal's raws worth trying.

    ``peaks``: one a term, where it is highest (for a system's signals as ``main``). ``main``: breakpoints, ends and
    half-ways between. ``all``: these and their surroundings.
    """

    peaks: Raws
    main: Raws
    all: Raws
    inverse: tuple[tuple[float, float, float, float], ...]
    """Sloping pieces of the terms as (raw position, degree) pairs, where a given degree can be aimed at."""


def special_raws(subject: Subject) -> dict[str, Special]:
    """Special raws by signal name (counts excluded)."""
    if isinstance(subject.model, Controller):
        inputs = {i.name: i for i in subject.model.inputs}
        values = {name: _of_input(i) for name, i in inputs.items()}
        pieces = {name: _slopes(i) for name, i in inputs.items()}
    else:
        values, pieces = _of_system(subject.model, subject)
        inputs = {}
    return {
        key: _special(port, values.get(key, set()), pieces.get(key, []), inputs.get(key))
        for key, port in subject.ports.items()
    }


def _special(port: Port, values: Iterable[Fraction], pieces: Iterable[Piece], item: Input | None) -> Special:
    assert port.variable is not None
    raw = port.variable.raw
    low, high = RAW_LIMITS[raw.ctype]
    marks = sorted({port.variable.lo, port.variable.hi, *values})
    main = {raw.nearest(v) for v in marks} | {raw.nearest((a + b) / 2) for a, b in itertools.pairwise(marks)}
    around = {low, high, 0, port.lo, port.hi}
    around |= {math.floor(raw.position(v)) for v in marks}
    around |= {math.floor(raw.position((a + b) / 2)) for a, b in itertools.pairwise(marks)}
    near = {r + d for r in around for d in range(-AROUND, AROUND + 2)} | main
    inverse = tuple(
        (float(raw.position(x0)), float(y0), float(raw.position(x1)), float(y1)) for x0, y0, x1, y1 in pieces
    )
    peaks = main if item is None else {raw.nearest(_highest(t.shape, item)) for t in item.terms}
    return Special(_sorted(peaks), _sorted(main), _sorted(r for r in near if low <= r <= high), inverse)


def _sorted(raws: Iterable[int]) -> Raws:
    return np.array(sorted(set(raws)), dtype=np.int64)


def _highest(shape: Shape, item: Input) -> Fraction:
    """A place in the range where a term is as high as at any of its points there: the middle of a plateau."""
    if isinstance(shape, Singleton):
        return shape.at
    lo, hi = item.variable.lo, item.variable.hi
    inside = [(x, y) for x, y in shape.points if lo <= x <= hi] or [(lo, Fraction(0)), (hi, Fraction(0))]
    top = max(y for _, y in inside)
    high = [x for x, y in inside if y == top]
    return (high[0] + high[-1]) / 2


def _of_input(item: Input) -> set[Fraction]:
    """Term breakpoints inside the range."""
    found: set[Fraction] = set()
    for term in item.terms:
        match term.shape:
            case PiecewiseLinear(points):
                found |= {x for x, _ in points}
            case Singleton(at):
                found.add(at)
    return {x for x in found if item.variable.lo <= x <= item.variable.hi}


def _slopes(item: Input) -> list[Piece]:
    """Pieces of the terms that are neither level nor a jump, cut to the range at whole pieces."""
    found: list[Piece] = []
    for term in item.terms:
        if isinstance(term.shape, PiecewiseLinear):
            for (x0, y0), (x1, y1) in itertools.pairwise(term.shape.points):
                if x0 < x1 and y0 != y1 and x1 > item.variable.lo and x0 < item.variable.hi:
                    found.append((x0, y0, x1, y1))
    return found


def _of_system(system: System, subject: Subject) -> tuple[dict[str, set[Fraction]], dict[str, list[Piece]]]:
    """Literals that a signal is compared with, and the breakpoints of inputs that it is handed to as it is."""
    ports = subject.ports
    values: dict[str, set[Fraction]] = {}
    pieces: dict[str, list[Piece]] = {}

    def unit_of(key: str) -> tuple[Fraction, Fraction]:
        variable = ports[key].variable
        assert variable is not None
        return variable.unit.scale, variable.unit.offset

    for compare in _compares(system):
        for one, other in ((compare.left, compare.right), (compare.right, compare.left)):
            key = _signal(one)
            if key is not None and isinstance(other, Const):
                scale, offset = unit_of(key)
                values.setdefault(key, set()).add((other.value - offset) / scale)
    for call in system.calls:
        for argument, item in zip(call.arguments, call.controller.inputs, strict=True):
            key = _signal(argument)
            if key is None:
                continue
            scale, offset = unit_of(key)

            def mine(x: Fraction, item: Input = item, scale: Fraction = scale, offset: Fraction = offset) -> Fraction:
                return (item.variable.unit.to_coherent(x) - offset) / scale

            values.setdefault(key, set()).update(mine(x) for x in _of_input(item))
            pieces.setdefault(key, []).extend((mine(x0), y0, mine(x1), y1) for x0, y0, x1, y1 in _slopes(item))
    return values, pieces


def _signal(expr: Expr) -> str | None:
    match expr:
        case ReadInput(name):
            return name
        case ReadField(listed, field):
            return f"{listed}.{field}"
        case _:
            return None


def _compares(system: System) -> Iterator[Compare]:
    for node in nodes((system.statements, system.outputs)):
        if isinstance(node, Compare):
            yield node


def nearest_legal(raw: Raw, values: npt.NDArray[np.float64]) -> Raws:
    """Positions rounded and held within the C type."""
    low, high = RAW_LIMITS[raw.ctype]
    held: Raws = np.clip(np.floor(values + 0.5), low, high).astype(np.int64)
    return held
