"""Fuzzification for interpolation: a raw becomes the degree of the upper active term and a step through the cells.

Where the peaks are evenly spaced on raws, one line serves all pieces: the raw slides down to the first piece while the
index of the cell moves up.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Assign, Branch, Const, Define, Expr, Local, ReadPort, SetStatus, Stmt
from fuzzyspec.lower.fuzzify import fuzzify, position
from fuzzyspec.lower.lines import fit
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.controller import Input


@dataclass(frozen=True, slots=True)
class Cell:
    """The index of the cell of all lower active terms, as far as it is known; None where there is only one cell."""

    local: Local | None

    def up(self, steps: int) -> list[Stmt]:
        """Statements that move it up."""
        if self.local is None or not steps:
            return []
        return [Assign(self.local, build.add_bounded(self.local, Const(steps), self.local.hi))]


def spacing(item: Input) -> int | None:
    """Raws between neighbouring peaks, where they are as many everywhere from the first legal raw to the last."""
    assert item.peaks is not None
    raw = item.variable.raw
    places = [position(raw, p) for p in item.peaks]
    step = places[1] - places[0]
    even = step.denominator == 1 and all(p == k * step for k, p in enumerate(places))
    return int(step) if even and places[-1] == raw.hi - raw.lo else None


def slide(
    item: Input, one: int, cell: Cell, stride: int, bit: str, scope: Scope
) -> tuple[list[Stmt], Local, Fraction] | None:
    """Statements from the raw on, the local with the degree (``one`` stands for 1) and its error in degrees; None where
    the peaks are not evenly spaced. ``bit`` tells that the raw was outside its range."""
    step = spacing(item)
    if step is None:
        return None
    assert item.peaks is not None
    raw, pieces = item.variable.raw, len(item.peaks) - 1
    body, counts = _from_bottom(item, bit, scope)
    at = build.local(scope.name(f"{item.name}_at"), counts)
    line = fit(Fraction(0), Fraction(one, step), step)
    top = step * pieces
    body.append(Define(at, counts, pieces == 1 and at.hi <= top))
    capped: list[Stmt] = []
    if at.hi > top:
        # Above one piece, once it has slid down, there is only what lies above the range.
        limit = step if pieces <= 2 else top
        capped = [Branch(build.compare(">", at, Const(limit)), (Assign(at, Const(limit)), SetStatus(bit)))]
    if pieces > 2:
        body += capped
    left = pieces
    while left > 1:
        # Halves: as many pieces stay possible whichever way this goes. On a peak both sides give the same.
        over = (left + 1) // 2
        down = build.sub_guarded(at, Const(over * step), at.hi - over * step)
        moves = [Assign(at, down), *cell.up(over * stride), *(capped if pieces == 2 else [])]
        body.append(Branch(build.compare(">", at, Const(over * step)), tuple(moves)))
        left = over
    if pieces == 1:
        body += capped
    degree = Local(scope.name(f"{item.name}_d"), "uint16", 0, one)
    value = line.expr(Local(at.name, at.ctype, 0, step))
    assert line.top <= one and raw.hi - raw.lo == top
    return [*body, Define(degree, value, True)], degree, line.error / one


def _from_bottom(item: Input, bit: str, scope: Scope) -> tuple[list[Stmt], Expr]:
    """Counts from the end of the legal raws with the lowest value; they may still go beyond the other end."""
    variable = item.variable
    raw = variable.raw
    low, high = build.LIMITS[raw.ctype]
    given: ReadPort | Local = ReadPort(variable.name, raw.ctype, low, high)
    body: list[Stmt] = []
    rising = raw.step > 0
    if low < raw.lo if rising else high > raw.hi:
        value = build.local(scope.name(variable.name), given)
        end = Const(raw.lo if rising else raw.hi)
        outside = build.compare("<" if rising else ">", value, end)
        body += [Define(value, given, False), Branch(outside, (Assign(value, end), SetStatus(bit)))]
        given = Local(value.name, value.ctype, raw.lo if rising else low, high if rising else raw.hi)
    return body, build.sub(given, Const(raw.lo)) if rising else build.sub(Const(raw.hi), given)


def chain(
    item: Input, value: Expr, one: int, cell: Cell, stride: int, scope: Scope
) -> tuple[list[Stmt], Local, Fraction]:
    """The same by a chain of pieces, from a saturated raw, for any strong partition."""
    body, found = fuzzify(item, value, scope, dense=False, bare=True, one=one)
    assert found.upper is not None
    if cell.local is not None and found.first.hi:
        steps = build.mul(found.first, Const(stride))
        body.append(Assign(cell.local, build.add_bounded(cell.local, steps, cell.local.hi)))
    return body, found.upper, found.error
