"""Fuzzification for interpolation: a raw becomes the degree of the upper active term and a step through the cells.

Three forms. Two even pieces: the raw slides down to the first while the index of the cell moves up, and one line serves
both (other controllers do so with any number of pieces). More even pieces: one line over all of them, whose upper bits
count pieces and whose lower bits are the degree. Anything else: a chain of pieces.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Literal

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Assign, Branch, Const, Define, Expr, Local, ReadPort, SetStatus, Stmt
from fuzzyspec.lower.fuzzify import fuzzify, position
from fuzzyspec.lower.lines import MAX_SHIFT, fit
from fuzzyspec.lower.saturation import saturated
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.controller import Input

HALF = Fraction(1, 2)
Form = Literal["slide", "scale", "chain"]


@dataclass(frozen=True, slots=True)
class Cell:
    """The index of the cell of all lower active terms, as far as it is known; None where there is only one cell."""

    local: Local | None

    def up(self, steps: Expr) -> list[Stmt]:
        """Statements that move it up."""
        if self.local is None or not steps.hi:
            return []
        return [Assign(self.local, build.add_bounded(self.local, steps, self.local.hi))]


@dataclass(frozen=True, slots=True)
class Fuzzified:
    """Statements from the raw on, those that tell of its saturation later, the local with the degree, and its error in
    degrees."""

    steps: list[Stmt]
    told: list[Stmt]
    degree: Local
    error: Fraction


def slides(item: Input) -> bool:
    """Whether the peaks are evenly spaced raws, the first and the last legal one among them."""
    places = _even(item)
    raw = item.variable.raw
    return bool(places) and places[0] == 0 and places[1].denominator == 1 and places[-1] == raw.hi - raw.lo


def _even(item: Input) -> list[Fraction]:
    """Positions of evenly spaced peaks; none where they are not."""
    if item.peaks is None or len(item.peaks) < 2:
        return []
    places = [position(item.variable.raw, p) for p in item.peaks]
    step = places[1] - places[0]
    return places if all(p == places[0] + k * step for k, p in enumerate(places)) else []


def form_of(item: Input) -> Form:
    """How an input is fuzzified for interpolation."""
    places = _even(item)
    if not places:
        return "chain"
    if len(places) <= 3 and slides(item):
        return "slide"
    first, top = places[0], item.variable.raw.hi - item.variable.raw.lo
    if len(places) > 2 and -1 < first <= 0 and top <= places[-1] < top + 1:
        return "scale"
    return "chain"


def highest(item: Input) -> int:
    """The largest lower term that an input's index can name: in one line it is the last term itself, with a degree of 0
    for the one above, which is not there."""
    return len(item.terms) - (1 if form_of(item) == "scale" else 2)


def fuzzified(item: Input, one: int, cell: Cell, stride: int, bit: str, scope: Scope) -> Fuzzified:
    """The degree of an input's upper active term, ``one`` standing for 1, and the cell moved up by its lower one.

    ``bit`` tells that the raw was outside its range.
    """
    forms: dict[Form, Callable[[Input, int, Cell, int, str, Scope], Fuzzified]] = {
        "slide": _slide,
        "scale": _scale,
        "chain": _chain,
    }
    return forms[form_of(item)](item, one, cell, stride, bit, scope)


def _slide(item: Input, one: int, cell: Cell, stride: int, bit: str, scope: Scope) -> Fuzzified:
    return slide(item, one, lambda k: cell.up(Const(k * stride)), bit, scope)


def slide(item: Input, one: int, moves: Callable[[int], list[Stmt]], bit: str, scope: Scope) -> Fuzzified:
    """An input that :func:`slides`; ``moves`` are made where a piece above the first is active."""
    assert item.peaks is not None
    raw, pieces = item.variable.raw, len(item.peaks) - 1
    step = (raw.hi - raw.lo) // pieces
    body, at = _from_bottom(item, pieces > 1, bit, scope)
    over = at.hi > raw.hi - raw.lo
    # Above the last piece, once it has slid down, there is only what lies above the range.
    capped: list[Stmt] = []
    if over:
        capped = [Branch(build.compare(">", at, Const(step)), (Assign(at, Const(step)), SetStatus(bit)))]
    chain: tuple[Stmt, ...] = ()
    for k in range(1, pieces):
        down = build.sub_guarded(at, Const(k * step), at.hi - k * step)
        inside = (Assign(at, down), *moves(k), *(capped if k == pieces - 1 else []))
        chain = (Branch(build.compare(">=", at, Const(k * step)), inside, chain),)
    body += chain if pieces > 1 else capped
    line = fit(Fraction(0), Fraction(one, step), step)
    degree = Local(scope.name(f"{item.name}_d"), "uint16", 0, one)
    value = line.expr(Local(at.name, at.ctype, 0, step))
    assert line.top <= one
    return Fuzzified([*body, Define(degree, value, True)], [], degree, line.error / one)


def _from_bottom(item: Input, moves: bool, bit: str, scope: Scope) -> tuple[list[Stmt], Local]:
    """Counts from the end of the legal raws with the lowest value, of which none lies below it; they may still go
    beyond the other end. ``moves``: they are to be set again, as they are where they go beyond it."""
    variable = item.variable
    raw = variable.raw
    given = ReadPort(variable.name, raw.ctype, *build.LIMITS[raw.ctype])
    counts = build.sub(given, Const(raw.lo)) if raw.step > 0 else build.sub(Const(raw.hi), given)
    fixed = not moves and counts.hi <= raw.hi - raw.lo
    if counts.lo >= 0:
        at = build.local(scope.name(f"{item.name}_at"), counts)
        return [Define(at, counts, fixed)], at
    # Counted first: an addition tells of a sign by itself, where the raw would be compared with another constant.
    counted = build.local(scope.name(f"{item.name}_counts"), counts)
    below = Branch(build.compare("<", counted, Const(0)), (Assign(counted, Const(0)), SetStatus(bit)))
    risen = replace(counted, lo=0)
    at = build.local(scope.name(f"{item.name}_at"), risen)
    return [Define(counted, counts, False), below, Define(at, risen, fixed)], at


def _scale(item: Input, one: int, cell: Cell, stride: int, bit: str, scope: Scope) -> Fuzzified:
    """Lemma "scale" of docs/numbers.md."""
    assert item.peaks is not None
    raw, pieces = item.variable.raw, len(item.peaks) - 1
    body, at = _from_bottom(item, False, bit, scope)
    top = raw.hi - raw.lo
    if at.hi > top:
        body.append(Branch(build.compare(">", at, Const(top)), (Assign(at, Const(top)), SetStatus(bit))))
        at = Local(at.name, at.ctype, 0, top)
    first = position(raw, item.peaks[0])
    slope = one * pieces / (position(raw, item.peaks[-1]) - first)
    start = -first * slope
    shift = MAX_SHIFT
    while math.ceil(slope * 2**shift) * top + (one << shift) > build.UINT32_MAX:
        shift -= 1
    factor = math.ceil(slope * 2**shift)
    drift = (Fraction(factor, 2**shift) - slope) * top
    # Below 1 all that is added on the way leaves a peak that is a raw where it is.
    lift = min(HALF, max(1 - drift, Fraction(0)))
    offset = max(math.ceil((start + lift) * 2**shift) - 1, 0)
    whole = build.shift_right(build.add(build.mul(at, Const(factor)), Const(offset)), shift)
    along = build.local(scope.name(f"{item.name}_along"), whole)
    body.append(Define(along, whole, True))
    if along.hi > one * pieces:
        capped = build.least(along, Const(one * pieces))
        along = build.local(scope.name(f"{item.name}_along"), capped)
        body.append(Define(along, capped, True))
    bits = one.bit_length() - 1
    body += cell.up(build.mul(build.shift_right(along, bits), Const(stride)))
    degree = Local(scope.name(f"{item.name}_d"), "uint16", 0, one - 1)
    body.append(Define(degree, build.bits_and(along, Const(one - 1)), True))
    off = Fraction(offset, 2**shift) - start
    return Fuzzified(body, [], degree, max(1 - off, drift + off) / one)


def _chain(item: Input, one: int, cell: Cell, stride: int, bit: str, scope: Scope) -> Fuzzified:
    variable = item.variable
    given = ReadPort(variable.name, variable.raw.ctype, *build.LIMITS[variable.raw.ctype])
    body, value, told = saturated(variable, given, variable.name, bit, scope)
    steps, found = fuzzify(item, value, scope, dense=False, bare=True, one=one)
    assert found.upper is not None
    return Fuzzified(
        [*body, *steps, *cell.up(build.mul(found.first, Const(stride)))], told, found.upper, max(found.errors)
    )
