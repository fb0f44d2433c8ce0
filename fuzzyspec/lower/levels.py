"""Firing and centroids by levels: sets of terms as bits, one square a strength, shared by all outputs.

With the minors of n inputs sorted (``lower.minors``) there are n + 1 strengths, strongest first, and of those only the
first, which one cell has, can exceed 1/2. Between two neighbouring strengths the union of an even output's clipped
terms is as wide as a linear function of the height: of the set of terms that are reached there, and of nothing else. So
area and moment are sums, over the strengths, of the differences of h and h**2 times small integers from a table of all
sets (docs/numbers.md, "Levels"). Half triangles at the ends add their cube where they are first reached.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    Assign,
    Branch,
    Comment,
    Const,
    CType,
    Define,
    Division,
    Element,
    Expr,
    Local,
    Stmt,
    Table,
    Test,
)
from fuzzyspec.lower.centroid import CentroidNumbers, even_mean
from fuzzyspec.lower.even import (
    EvenOutput,
    cube,
    even_output,
    square,
)
from fuzzyspec.lower.fire import Firing, act_equal, act_first, owner_table
from fuzzyspec.lower.fuzzify import Degrees
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.minors import Group, Minors
from fuzzyspec.lower.minors import applies as minors_apply
from fuzzyspec.lower.scope import Scope
from fuzzyspec.lower.strategy import Precision
from fuzzyspec.model.controller import CellRules, Controller, Output

BYTES: dict[int, CType] = {1: "uint8", 2: "uint16", 3: "uint32", 4: "uint32"}
"""The type of a cell's sets, a byte an output."""


def applies(controller: Controller, precision: Precision = "full") -> list[EvenOutput] | None:
    """The outputs' shapes where a controller can be computed this way, else None."""
    if not minors_apply(controller) or controller.infer.defuzzify != "centroid" or controller.cells is None:
        return None
    if not all(controller.always_fires) or any(-1 in c for c in controller.cells.consequents):
        return None
    found = [even_output(output, precision) for output in controller.outputs]
    return [e for e in found if e is not None] if all(found) and len(found) in BYTES else None


@dataclass
class _Sums:
    """One output's sums, the place of its byte in the sets, and its table of a set's four factors."""

    output: Output
    even: EvenOutput
    place: int
    rows: Table
    area: Local
    moment: Local


Means = list[tuple[list[Stmt], Expr, CentroidNumbers]]


def fire_levels(
    controller: Controller,
    cells: CellRules,
    evens: list[EvenOutput],
    degrees: list[Degrees],
    firing: Firing,
    division: Division,
    scope: Scope,
) -> Means:
    """Append the statements up to every output's sums to ``firing``; the rest of each output is returned."""
    body = firing.body
    minors = Minors.of(controller, cells, degrees, body, scope, packed=True)
    values = [
        sum(1 << (8 * o + terms[cell]) for o, terms in enumerate(cells.consequents))
        for cell in range(math.prod(cells.shape))
    ]
    rules = Table(scope.name("rules"), BYTES[len(evens)], tuple(values))
    firing.tables.append(rules)
    owners = owner_table(controller, cells, firing, scope)
    everything = sum(((1 << len(e.peaks)) - 1) << 8 * o for o, e in enumerate(evens))

    def look(place: Expr) -> Expr:
        return Element(rules.name, rules.ctype, place, 0, everything, True)

    sums = [_sums(o, e, i, firing, scope) for i, (o, e) in enumerate(zip(controller.outputs, evens, strict=True))]
    groups: list[Group] = []
    reached: list[tuple[Local, Local]] = []
    seen: Expr = Const(0)
    # All sets come before all sums: what leads to the cells need not be kept beside the sums.
    for strength, places in minors.groups(len(values) - 1, body, scope):
        groups.append((strength, places))
        terms: Expr = look(places[0])
        for place in places[1:]:
            terms = build.bits_or(terms, look(place))
        named = build.local(scope.name("terms"), terms, ctype="uint32")
        together = build.bits_or(named, seen) if reached else named
        seen = build.local(scope.name("seen"), together, ctype="uint32")
        body += [Define(named, terms, True), Define(seen, together, True)]
        reached.append((strength, seen))
    body.append(Comment("from level to level, the strongest first: what the terms seen so far cover"))
    body += [s for t in sums for s in _started(t)]
    levels: list[tuple[Local, Local]] = []
    for i, (strength, seen) in enumerate(reached):
        squared = square(strength, evens[0].bits, "level", scope)
        body.append(squared)
        fresh: Local = seen
        if i:
            last = reached[i - 1][1]
            body += _covered(sums, last, levels[-1], (strength, squared.local), scope)
            value = build.bits_xor(seen, last)
            fresh = build.local(scope.name("fresh"), value, ctype="uint32")
            body.append(Define(fresh, value, True))
        body += _ends(sums, fresh, strength, squared.local, scope)
        levels.append((strength, squared.local))
    body += _covered(sums, reached[-1][1], levels[-1], (Const(0), Const(0)), scope)
    if owners is not None:
        majors, (first,) = groups[0]
        body += act_first(owners, first, majors, firing, scope)
        minors.ties(groups, lambda place: act_equal(owners, place, firing, scope), body)
    return [_mean(t, division, scope) for t in sums]


def _sums(output: Output, even: EvenOutput, place: int, firing: Firing, scope: Scope) -> _Sums:
    values = tuple(f for terms in range(1 << len(even.peaks)) for f in _factors(even, terms))
    rows = next((t for t in firing.tables if t.values == values), None)
    if rows is None:
        rows = Table(scope.name(f"{output.name}_covers"), build.smallest_type(0, max(values)), values)
        firing.tables.append(rows)

    def total(name: str) -> Local:
        return Local(scope.name(f"{output.name}_{name}"), "uint32", 0, build.UINT32_MAX)

    return _Sums(output, even, place, rows, total("area"), total("moment"))


def _started(t: _Sums) -> list[Stmt]:
    return [Define(t.area, Const(0), False), Define(t.moment, Const(_bias(t.even)), False)]


def _bias(even: EvenOutput) -> int:
    return even.bits.moment_bias if any(even.ends) else 0


def _factors(even: EvenOutput, terms: int) -> tuple[int, int, int, int]:
    """How often a set of terms covers a difference of heights and of squares: in area, and in moment."""
    own = [k for k in range(len(even.peaks)) if terms >> k & 1]
    met = [k for k in own if k in even.met and k + 1 in own]
    area = sum(even.counts[k] for k in own)
    moment = sum(even.counts[k] * even.peaks[k] for k in own)
    middle = sum(even.peaks[k] + 1 for k in met)
    turn = sum(even.ends[k] for k in own)
    return area - len(met), area - 2 * len(met), moment - middle + turn, moment - 2 * middle + 2 * turn


def _covered(
    sums: list[_Sums], seen: Local, before: tuple[Local, Local], now: tuple[Expr, Expr], scope: Scope
) -> list[Stmt]:
    """What the terms seen so far cover between the last level and this one: heights and their squares."""
    # Levels come in order, so both differences are never negative.
    drop_value = build.shift_left(build.sub_guarded(before[0], now[0], DEGREE_ONE), sums[0].even.bits.height_shift)
    drop = build.local(scope.name("drop"), drop_value, ctype="uint32")
    square_value = build.sub_guarded(before[1], now[1], before[1].hi)
    drop_square = build.local(scope.name("drop_square"), square_value, ctype="uint32")
    body: list[Stmt] = [Define(drop, drop_value, True), Define(drop_square, square_value, True)]
    for t in sums:
        part: Expr = build.shift_right(seen, 8 * t.place)
        if t is not sums[-1]:
            part = build.bits_and(part, Const(0xFF))
        row_value = build.mul(_within(part, (1 << len(t.even.peaks)) - 1), Const(4))
        row = build.local(scope.name(f"{t.output.name}_row"), row_value)
        body.append(Define(row, row_value, True))
        for i, total in ((0, t.area), (2, t.moment)):
            up, down = (_factor(t.rows, row, i + j) for j in (0, 1))
            # Together never below 0: docs/numbers.md, "Levels".
            grown = build.add_bounded(total, build.mul(up, drop), build.UINT32_MAX)
            body.append(
                Assign(total, build.sub_guarded(grown, build.mul(down, drop_square), build.UINT32_MAX)),
            )
    return body


def _within(expr: Expr, hi: int) -> Expr:
    return build.bits_and(expr, Const(hi)) if expr.hi > 0xFF else build.capped(expr, hi)


def _factor(rows: Table, row: Local, i: int) -> Expr:
    return Element(rows.name, rows.ctype, build.add(row, Const(i)), 0, max(rows.values[i::4]), True)


def _ends(sums: list[_Sums], fresh: Local, strength: Local, squared: Local, scope: Scope) -> list[Stmt]:
    """The cubes of half triangles that are reached for the first time."""
    bits = {(t.output.name, k): 1 << (8 * t.place + k) for t in sums for k, e in enumerate(t.even.ends) if e}
    if not bits:
        return []
    value = cube(strength, squared, sums[0].even.bits)
    cubed = build.local(scope.name("level_cube"), value, ctype="uint32")
    steps: list[Stmt] = [Define(cubed, value, True)]
    for t in sums:
        for k, end in enumerate(t.even.ends):
            if not end:
                continue
            hi = build.UINT32_MAX
            turned = (build.add_bounded if end > 0 else build.sub_guarded)(t.moment, cubed, hi)
            steps.append(Branch(_any(fresh, bits[t.output.name, k]), (Assign(t.moment, turned),)))
    return [Branch(_any(fresh, sum(bits.values())), tuple(steps))]


def _any(terms: Local, bits: int) -> Test:
    return build.compare("!=", build.bits_and(terms, Const(bits)), Const(0))


def _mean(t: _Sums, division: Division, scope: Scope) -> tuple[list[Stmt], Expr, CentroidNumbers]:
    moment = build.sub_guarded(t.moment, Const(_bias(t.even)), build.UINT32_MAX - _bias(t.even))
    comment = Comment(f"centroid of {t.output.name}")
    steps, raw, numbers = even_mean(t.output, t.even, t.area, moment, division, scope, fires=True)
    return [comment, *steps], raw, numbers
