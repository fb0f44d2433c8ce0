"""Fuzzification: a raw becomes the degrees of its input's terms.

In a strong partition at most two neighbouring terms are active: their degrees are ``2**15 - d`` and ``d``, kept in an
array of two beside the index of the lower term. Other terms each get a chain of straight pieces.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    Assign,
    AssignElement,
    Branch,
    Compare,
    Const,
    CType,
    Define,
    DefineArray,
    Element,
    Expr,
    Local,
    SetStatus,
    Stmt,
    Test,
)
from fuzzyspec.lower.arrays import zeroed
from fuzzyspec.lower.lines import DEGREE_ONE, Line, fit
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.controller import Input
from fuzzyspec.model.term import PiecewiseLinear, Shape, Singleton
from fuzzyspec.model.variable import Raw, Variable


@dataclass(frozen=True, slots=True)
class Degrees:
    """Where an input's degrees are.

    Slot j of ``array`` holds the degree of term ``first + j``: two slots and a local ``first`` in a strong partition,
    else a slot a term and 0. ``upper`` is the local with the upper term's degree where the two are kept without an
    array (firing by minors then reads it). ``errors`` bound each term's degree's error, in degrees [0, 1].
    Where terms are not a strong partition and are fuzzified by zones (``lower.zones``), ``first`` says which of
    ``groups`` of terms can be active, and the locals ``members`` hold the degrees of the terms in it, in their order.
    """

    array: str
    slots: int
    first: Expr
    errors: tuple[Fraction, ...]
    upper: Local | None = None
    groups: tuple[tuple[int, ...], ...] = ()
    members: tuple[Local, ...] = ()

    def slot(self, index: Expr) -> Element:
        return Element(self.array, "uint16", index, 0, DEGREE_ONE, False)


@dataclass(frozen=True, slots=True)
class Piece:
    """Raw positions ``start .. end`` on which a membership is the straight ``line`` over ``u - start``."""

    start: int
    end: int
    line: Line


@dataclass(frozen=True, slots=True)
class Reading:
    """A raw as it was read: a local that may still lie outside the legal raws, where ``bit`` is to tell of that."""

    variable: Variable
    value: Local
    bit: str

    @property
    def top(self) -> int:
        """The last position."""
        return self.variable.raw.hi - self.variable.raw.lo

    def before(self, at: int) -> Test:
        """Whether its position lies before another."""
        raw = self.variable.raw
        if raw.step > 0:
            return build.compare("<", self.value, Const(raw.lo + at))
        return build.compare(">", self.value, Const(raw.hi - at))

    def beyond(self, start: int, length: int) -> Expr:
        """Its position from another one on, where it is known to lie so far beyond that at most."""
        raw = self.variable.raw
        if raw.step < 0:
            return build.sub_guarded(Const(raw.hi - start), self.value, length)
        if raw.lo + start < 0:
            return build.add_bounded(self.value, Const(-raw.lo - start), length)
        return build.sub_guarded(self.value, Const(raw.lo + start), length)

    def within(self, start: int, end: int) -> list[Stmt]:
        """Statements that saturate it, where its position may be one of these, or beyond an end that is among them."""
        raw, steps = self.variable.raw, []
        low, high = (start == 0, end == self.top) if raw.step > 0 else (end == self.top, start == 0)
        if low and self.value.lo < raw.lo:
            below = build.compare("<", self.value, Const(raw.lo))
            steps.append(Branch(below, (Assign(self.value, Const(raw.lo)), SetStatus(self.bit))))
        if high and self.value.hi > raw.hi:
            above = build.compare(">", self.value, Const(raw.hi))
            steps.append(Branch(above, (Assign(self.value, Const(raw.hi)), SetStatus(self.bit))))
        return list(steps)


Run = tuple[int, int, list[Stmt]]
"""Positions from the first to the last, and what is to be done there."""


def search(runs: list[Run], given: Reading) -> list[Stmt]:
    """What leads to the runs, which are in order and hold all positions, by few comparisons: the longer the fewer.

    A raw is saturated where it has led to a run at an end.
    """
    if len(runs) == 1:
        ((start, end, steps),) = runs
        return given.within(start, end) + steps
    lengths = [end - start for start, end, _ in runs]
    cut = min(range(1, len(runs)), key=lambda c: abs(sum(lengths[:c]) - sum(lengths[c:])))
    return [Branch(given.before(runs[cut][0]), tuple(search(runs[:cut], given)), tuple(search(runs[cut:], given)))]


STEEP = 2
"""A last rise over fewer raws is not run past its peak and capped: that could leave 32 bits."""


def position(raw: Raw, value: Fraction) -> Fraction:
    """Counts from the end of the legal raws that has the lowest value; increases with the value."""
    return raw.position(value) - raw.lo if raw.step > 0 else raw.hi - raw.position(value)


def position_expr(raw: Raw, value: Expr) -> Expr:
    """The same in the program, for a saturated raw."""
    return build.sub(value, Const(raw.lo)) if raw.step > 0 else build.sub(Const(raw.hi), value)


def fuzzify(
    item: Input, raw: Expr, scope: Scope, dense: bool, bare: bool = False, one: int = DEGREE_ONE, bit: str = ""
) -> tuple[list[Stmt], Degrees]:
    """Statements that compute the degrees of one input from its raw.

    ``dense`` asks for a slot for every term even in a strong partition (sentence rules name terms); ``bare`` for no
    array at all where the partition is strong, and then ``one`` is the integer that stands for a degree of 1. Where the
    partition is strong the raw may be a local outside the legal raws, which then is saturated, and ``bit`` set.
    """
    variable = item.variable
    body: list[Stmt] = []
    if item.peaks is not None and len(item.peaks) > 1:
        if not isinstance(raw, Local):
            bound = build.local(scope.name(item.name), raw)
            body.append(Define(bound, raw, True))
            raw = bound
        return _strong(item, item.peaks, Reading(variable, raw, bit), scope, dense, bare, body, one)
    at = position_expr(variable.raw, raw)
    if not isinstance(at, Local):
        bound = build.local(scope.name(f"{item.name}_at"), at)
        body.append(Define(bound, at, True))
        at = bound
    array = scope.name(f"{item.name}_mu")
    body += zeroed(array, "uint16", len(item.terms), scope)
    errors: list[Fraction] = []
    for k, term in enumerate(item.terms):
        pieces = straight_pieces(term.shape, variable.raw)
        errors.append(max((p.line.error for p in pieces), default=Fraction(0)) / DEGREE_ONE)
        body.extend(_chain(pieces, at, lambda e, k=k: AssignElement(array, "uint16", Const(k), e)))
    return body, Degrees(array, len(item.terms), Const(0), tuple(errors))


def _strong(
    item: Input,
    peaks: tuple[Fraction, ...],
    given: Reading,
    scope: Scope,
    dense: bool,
    bare: bool,
    body: list[Stmt],
    one: int,
) -> tuple[list[Stmt], Degrees]:
    places = [position(item.variable.raw, p) for p in peaks]
    last = len(places) - 2
    degree = Local(scope.name(f"{item.name}_d"), "uint16", 0, one)
    first = Local(scope.name(f"{item.name}_term"), "uint8", 0, last)
    body.append(Define(degree, Const(0), False))
    if last:
        body.append(Define(first, Const(0), False))
    errors = [Fraction(0)] * len(places)
    runs: list[Run] = []
    for k, (low, high) in enumerate(pairwise(places)):
        start = max(0, math.ceil(low))
        end = given.top if k == last else min(given.top, math.ceil(high) - 1)
        beyond: list[Run] = []
        if k == last and high - low < STEEP and math.ceil(high) <= given.top:
            own: list[Stmt] = [Assign(first, Const(k))] if k else []
            end = math.ceil(high) - 1
            beyond = [(end + 1, given.top, [*own, Assign(degree, Const(one))])]
        if start <= end:
            # Beyond the last peak the degree stays 1 (a peak between two raws is passed, and capped), below the first
            # it is 0.
            straight = min(end, math.ceil(high)) if k == last else end
            slope = one / (high - low)
            # Up to a peak that is a raw itself, so that even pieces have one line (`slide` relies on that).
            length = straight - start if k == last else math.floor(high) - start
            line = fit((start - low) * slope, slope, max(0, length))
            for term in (k, k + 1):
                errors[term] = max(errors[term], line.error / one)
            steps: list[Stmt] = [Assign(first, Const(k))] if k else []
            runs.append(
                (start, straight, [*steps, *_piece(line, given, start, straight, degree, scope, item.name, one)])
            )
            if straight < end:
                beyond = [(straight + 1, end, [*steps, Assign(degree, Const(one))])]
        runs += beyond
    if runs[0][0]:
        runs.insert(0, (0, runs[0][0] - 1, []))
    body.extend(search(runs, given))
    index: Expr = first if last else Const(0)
    if bare:
        return body, Degrees("", 2, index, tuple(errors), degree)
    if dense:
        array = scope.name(f"{item.name}_mu")
        low_degree = build.sub(Const(one), degree)
        body += zeroed(array, "uint16", len(places), scope)
        body.append(AssignElement(array, "uint16", index, low_degree))
        body.append(AssignElement(array, "uint16", build.add(index, Const(1)), degree))
        return body, Degrees(array, len(places), Const(0), tuple(errors))
    return in_array(item, body, Degrees("", 2, index, tuple(errors), degree), scope)


def in_array(item: Input, body: list[Stmt], found: Degrees, scope: Scope) -> tuple[list[Stmt], Degrees]:
    """Two degrees that were kept without an array, in one."""
    assert found.upper is not None
    array = scope.name(f"{item.name}_mu")
    low = build.sub(Const(DEGREE_ONE), found.upper)
    own: list[Stmt] = [
        DefineArray(array, "uint16", 2),
        AssignElement(array, "uint16", Const(0), low),
        AssignElement(array, "uint16", Const(1), found.upper),
    ]
    return body + own, replace(found, array=array, upper=None)


def _piece(
    line: Line, given: Reading, start: int, end: int, degree: Local, scope: Scope, name: str, one: int
) -> list[Stmt]:
    steps: list[Stmt] = []
    u = given.beyond(start, end - start)
    if not isinstance(u, Local):
        bound = Local(scope.name(f"{name}_u"), "uint16", 0, end - start)
        steps.append(Define(bound, u, True))
        u = bound
    value = line.expr(u)
    if line.top > one:
        wide = build.local(scope.name(f"{name}_y"), value)
        steps.append(Define(wide, value, True))
        value = build.least(wide, Const(one))
    steps.append(Assign(degree, value))
    return steps


def straight_pieces(shape: Shape, raw: Raw) -> list[Piece]:
    """The integer positions of a raw cut into runs on which the membership is one straight line, in order.

    At a jump that falls on a raw the largest of the values there holds, so such a raw joins the side that has it, or
    stands alone.
    """
    top = raw.hi - raw.lo
    if isinstance(shape, Singleton):
        at = position(raw, shape.at)
        if at.denominator != 1 or not 0 <= at <= top:
            return []
        below = [Piece(0, int(at) - 1, fit(Fraction(0), Fraction(0), int(at) - 1))] if at else []
        return [*below, Piece(int(at), int(at), fit(Fraction(DEGREE_ONE), Fraction(0), 0))]
    runs: list[tuple[int, int, Fraction, Fraction]] = []
    for low, high, y_low, y_high in _segments(shape, raw, top):
        start, end = max(0, math.ceil(low)), min(top, math.floor(high))
        slope = (y_high - y_low) / (high - low)
        if start > end:
            continue
        if runs and runs[-1][1] == start:
            before = runs[-1]
            there = before[2] + before[3] * (start - before[0])
            here = y_low + slope * (start - low)
            if here >= there:
                runs[-1] = (before[0], start - 1, before[2], before[3])
            else:
                start += 1
        runs = [r for r in runs if r[0] <= r[1]]
        if start <= end:
            runs.append((start, end, y_low + slope * (start - low), slope))
    for x, y in _spikes(shape, raw, top):
        runs = _with_spike(runs, x, y)
    pieces: list[Piece] = []
    for start, end, y, slope in runs:
        if pieces and slope == 0 and y == 0 and pieces[-1].line.top == 0:
            pieces[-1] = Piece(pieces[-1].start, end, fit(Fraction(0), Fraction(0), end - pieces[-1].start))
        else:
            pieces.append(Piece(start, end, fit(y * DEGREE_ONE, slope * DEGREE_ONE, end - start)))
    return pieces


def _segments(shape: PiecewiseLinear, raw: Raw, top: int) -> list[tuple[Fraction, Fraction, Fraction, Fraction]]:
    """Open segments (low, high, membership just after low, just before high) that cover ``0 .. top``."""
    points = [(position(raw, x), y) for x, y in shape.points]
    before = (min(points[0][0], Fraction(0)) - 1, points[0][1])
    after = (max(points[-1][0], Fraction(top)) + 1, points[-1][1])
    chain = [before, *points, after]
    return [(a[0], b[0], a[1], b[1]) for a, b in pairwise(chain) if a[0] < b[0]]


def _spikes(shape: PiecewiseLinear, raw: Raw, top: int) -> list[tuple[int, Fraction]]:
    """Points of a jump whose own value is above both sides' limits (three or more points at one x)."""
    found: list[tuple[int, Fraction]] = []
    for x in sorted({x for x, _ in shape.points}):
        values = [y for px, y in shape.points if px == x]
        at = position(raw, x)
        if len(values) > 2 and at.denominator == 1 and 0 <= at <= top and max(values) > max(values[0], values[-1]):
            found.append((int(at), max(values)))
    return found


def _with_spike(
    runs: list[tuple[int, int, Fraction, Fraction]], x: int, y: Fraction
) -> list[tuple[int, int, Fraction, Fraction]]:
    result: list[tuple[int, int, Fraction, Fraction]] = []
    for start, end, y0, slope in runs:
        if start <= x <= end:
            if start < x:
                result.append((start, x - 1, y0, slope))
            result.append((x, x, y, Fraction(0)))
            if x < end:
                result.append((x + 1, end, y0 + slope * (x + 1 - start), slope))
        else:
            result.append((start, end, y0, slope))
    return result


def _chain(pieces: list[Piece], at: Local, assign: object) -> list[Stmt]:
    """An if-chain over the pieces; a degree of 0 needs no statement, the array is zeroed."""
    assert callable(assign)
    chain: tuple[Stmt, ...] = ()
    last = len(pieces) - 1
    for i in range(last, -1, -1):
        piece = pieces[i]
        if piece.line.top == 0:
            steps: tuple[Stmt, ...] = ()
        else:
            u: Expr = at
            if piece.line.slope:
                u = build.sub_guarded(at, Const(piece.start), piece.end - piece.start)
            value = piece.line.expr(u) if piece.line.slope else Const(piece.line.offset >> piece.line.shift)
            if value.hi > DEGREE_ONE:
                value = _capped(value)
            steps = (assign(value),)
        inside: Compare | None = None
        if i < last or piece.end < at.hi:
            test = build.compare("<=", at, Const(piece.end))
            assert isinstance(test, Compare)
            inside = test
        if inside is None:
            chain = steps
        elif not steps and not chain:
            chain = ()
        else:
            chain = (Branch(inside, steps, chain),)
    return list(chain)


def _capped(value: Expr) -> Expr:
    """A line that a rounding takes above 1 is capped; both arms are cheap to name twice."""
    return build.select(build.compare("<", value, Const(DEGREE_ONE)), value, Const(DEGREE_ONE))


DEGREE_TYPE: CType = "uint16"
