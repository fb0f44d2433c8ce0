"""Firing and centroids by levels: sets of terms as bits, one polynomial a strength.

With the minors of n inputs sorted (``lower.minors``) there are n + 1 strengths, strongest first. For each of them
the terms that
its cells name are collected as bits; those not seen before take this strength as their level, and pairs of neighbours
complete with it overlap at it. For even outputs the areas of all of them are multiples of two
polynomials, so one evaluation serves all terms of a level, and small tables give the multiples and moments of a
set of bits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    Assign,
    AssignElement,
    Branch,
    Comment,
    Const,
    Define,
    DefineArray,
    Division,
    Element,
    Expr,
    Local,
    Loop,
    Stmt,
    Table,
)
from fuzzyspec.lower.centroid import CentroidNumbers, SetNumbers
from fuzzyspec.lower.clipped import ClippedSet
from fuzzyspec.lower.even import EvenOutput, even_output
from fuzzyspec.lower.fire import Firing, act, owner_table
from fuzzyspec.lower.fuzzify import Degrees
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.mean import mean_to_raw
from fuzzyspec.lower.minors import Minors
from fuzzyspec.lower.minors import applies as minors_apply
from fuzzyspec.lower.scope import Scope
from fuzzyspec.lower.sets import Evaluated, Scale, evaluate, scale_of
from fuzzyspec.model.controller import CellRules, Controller, Output

MASK_BITS = 16


def applies(controller: Controller) -> list[EvenOutput] | None:
    """The outputs' shapes where a controller can be computed this way, else None."""
    if not minors_apply(controller) or controller.infer.defuzzify != "centroid" or controller.cells is None:
        return None
    if not all(controller.always_fires) or any(-1 in c for c in controller.cells.consequents):
        return None
    if sum(len(o.terms) for o in controller.outputs) > MASK_BITS:
        return None
    found: list[EvenOutput] = []
    for output in controller.outputs:
        even = even_output(output)
        if even is None or not scale_of(even.forms).exact:
            return None
        found.append(even)
    return found


@dataclass
class _Sums:
    """One output's accumulators and what it has seen, all locals before the loop over the levels."""

    output: Output
    even: EvenOutput
    scale: Scale
    shift: int
    bits: int
    seen: Local
    joined: Local
    area: Local
    overlap: Local
    moment: Local
    moment_off: Local


Means = list[tuple[list[Stmt], Expr, CentroidNumbers]]


def fire_masks(
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
    minors = Minors.of(controller, cells, degrees, body, scope)
    shifts = [sum(len(o.terms) for o in controller.outputs[:i]) for i in range(len(controller.outputs))]
    masks = _mask_table(controller, cells, shifts, scope)
    firing.tables.append(masks)
    owners = owner_table(controller, cells, firing, scope)
    count = len(minors.sorted) + 1
    strengths, named = scope.name("strength"), scope.name("named")
    body += [DefineArray(strengths, "uint16", count), DefineArray(named, masks.ctype, count)]
    top = (1 << sum(len(o.terms) for o in controller.outputs)) - 1

    def look(place: Expr) -> Expr:
        return Element(masks.name, masks.ctype, place, 0, top, True)

    groups = minors.groups(len(masks.values) - 1, body, scope)
    for level, (strength, places) in enumerate(groups):
        together: Expr = look(places[0])
        for place in places[1:]:
            together = build.bits_or(together, look(place))
        body.append(AssignElement(strengths, "uint16", Const(level), strength))
        body.append(AssignElement(named, masks.ctype, Const(level), together))
    if owners is not None:
        majors, (first,) = groups[0]
        body += act(owners, first, majors, firing, scope)
        minors.ties(groups, lambda p, s: act(owners, p, s, firing, scope), body)
    sums = [_sums(o, e, shift, body, scope) for o, e, shift in zip(controller.outputs, evens, shifts, strict=True)]
    body.append(Comment("levels, the strongest first: the areas of the terms that are new at each"))
    counter = Local(scope.name("level"), "uint8", 0, count - 1)
    height = Local(scope.name("h"), "uint16", 0, DEGREE_ONE)
    mask = Local(scope.name("terms"), masks.ctype, 0, top)
    inner, numbers = _level(sums, height, mask, firing, scope)
    body.append(
        Loop(
            counter,
            count,
            (
                Define(height, Element(strengths, "uint16", counter, 0, DEGREE_ONE, False), True),
                Define(mask, Element(named, masks.ctype, counter, 0, top, False), True),
                Branch(build.compare(">", height, Const(0)), tuple(inner)),
            ),
        )
    )
    return [_mean(s, sets, division, scope) for s, sets in zip(sums, numbers, strict=True)]


def _mask_table(controller: Controller, cells: CellRules, shifts: list[int], scope: Scope) -> Table:
    values = [
        sum(1 << (shift + terms[cell]) for shift, terms in zip(shifts, cells.consequents, strict=True))
        for cell in range(math.prod(cells.shape))
    ]
    total = sum(len(o.terms) for o in controller.outputs)
    return Table(scope.name("rules"), "uint8" if total <= 8 else "uint16", tuple(values))


def _sums(output: Output, even: EvenOutput, shift: int, body: list[Stmt], scope: Scope) -> _Sums:
    bits = len(output.terms)

    def start(name: str, hi: int) -> Local:
        local = Local(scope.name(f"{output.name}_{name}"), "uint32", 0, hi)
        body.append(Define(local, Const(0), False))
        return local

    everything, most = (1 << bits) - 1, build.UINT32_MAX
    return _Sums(
        output,
        even,
        scale_of(even.forms),
        shift,
        bits,
        start("seen", everything),
        start("joined", everything >> 1),
        start("area", most),
        start("overlap", most),
        start("moment", most),
        start("moment_off", most),
    )


def _level(
    sums: list[_Sums], height: Local, mask: Local, firing: Firing, scope: Scope
) -> tuple[list[Stmt], list[tuple[SetNumbers, ...]]]:
    """What one level adds to every output."""
    inner: list[Stmt] = []
    shared: dict[object, Local] = {}
    numbers: list[tuple[SetNumbers, ...]] = []
    for s in sums:
        name, even = s.output.name, s.even
        part: Expr = mask if len(sums) == 1 else build.shift_right(mask, s.shift)
        if s is not sums[-1]:
            part = build.bits_and(part, Const((1 << s.bits) - 1))
        part = replace(part, hi=(1 << s.bits) - 1) if not isinstance(part, Const) else part
        own = build.local(scope.name(f"{name}_terms"), part)
        fresh_value = build.bits_xor(build.bits_or(own, s.seen), s.seen)
        fresh = build.local(scope.name(f"{name}_new"), fresh_value)
        inner += [
            Define(own, part, True),
            Define(fresh, fresh_value, True),
            Assign(s.seen, build.bits_or(s.seen, fresh)),
        ]
        single = _shared(replace(even.single, moment_sign=0), s.scale, height, inner, shared, scope, f"{name}_one")
        multiples = list(even.multiples)
        inner.append(_add(s.area, single.area, _lookup(fresh, multiples, f"{name}_areas", firing, scope)))
        places = [int(f.reference * s.scale.weight_denominator) for f in even.singles]
        weights = [m * p for m, p in zip(multiples, places, strict=True)]
        inner.append(_add(s.moment, single.area, _lookup(fresh, weights, f"{name}_moments", firing, scope)))
        turned = _turns(s, fresh, height, inner, scope)
        pair: Evaluated | None = None
        if even.pair is not None:
            now_value = build.bits_and(s.seen, build.shift_right(s.seen, 1))
            now = Local(scope.name(f"{name}_pairs"), "uint32", 0, (1 << (s.bits - 1)) - 1)
            pairs = build.local(scope.name(f"{name}_met"), build.bits_xor(now, s.joined))
            inner += [
                Define(now, replace_hi(now_value, now.hi), True),
                Define(pairs, build.bits_xor(now, s.joined), True),
                Assign(s.joined, now),
            ]
            pair = _shared(even.pair, s.scale, height, inner, shared, scope, f"{name}_both")
            ones = [1] * len(even.pairs)
            inner.append(_add(s.overlap, pair.area, _lookup(pairs, ones, f"{name}_overlaps", firing, scope)))
            middles = [int(f.reference * s.scale.weight_denominator) for f in even.pairs]
            inner.append(_add(s.moment_off, pair.area, _lookup(pairs, middles, f"{name}_middles", firing, scope)))
        numbers.append(_numbers(s, single, turned, pair))
    return inner, numbers


def replace_hi(expr: Expr, hi: int) -> Expr:
    """The same expression with a smaller upper end, where the caller's proof gives one."""
    return expr if isinstance(expr, Const) else replace(expr, hi=min(expr.hi, hi))


def _shared(
    form: ClippedSet,
    scale: Scale,
    height: Local,
    inner: list[Stmt],
    shared: dict[object, Local],
    scope: Scope,
    name: str,
) -> Evaluated:
    """Evaluate a polynomial once for all outputs that have the same one."""
    found = evaluate(form, scale, height, scope, name)
    if found.key in shared:
        return replace(found, area=shared[found.key])
    shared[found.key] = found.area
    inner += found.steps
    return found


def _turns(s: _Sums, fresh: Local, height: Local, inner: list[Stmt], scope: Scope) -> Evaluated | None:
    """Moments of the terms that are not symmetric, where they are new."""
    if s.even.turning is None:
        return None
    ups = sum(1 << f.members[0] for f in s.even.singles if f.moment_sign > 0)
    downs = sum(1 << f.members[0] for f in s.even.singles if f.moment_sign < 0)
    found = evaluate(s.even.turning, s.scale, height, scope, f"{s.output.name}_end")
    assert found.moment is not None
    steps: list[Stmt] = list(found.steps)
    for bits, into in ((ups, s.moment), (downs, s.moment_off)):
        if bits:
            test = build.compare("!=", build.bits_and(fresh, Const(bits)), Const(0))
            steps.append(Branch(test, (_add(into, found.moment, Const(1)),)))
    test = build.compare("!=", build.bits_and(fresh, Const(ups | downs)), Const(0))
    inner.append(Branch(test, tuple(steps)))
    return found


def _add(total: Local, value: Expr, times: Expr) -> Stmt:
    """``total += value * times``: all levels together stay within the sums that the scale was chosen for."""
    product = value if times == Const(1) else build.mul(value, times)
    return Assign(total, build.add_bounded(total, product, build.UINT32_MAX))


def _lookup(bits: Local, weights: list[int], name: str, firing: Firing, scope: Scope) -> Expr:
    """The sum of the weights of a set of bits, from a table of all sets."""
    values = tuple(sum(w for i, w in enumerate(weights) if m >> i & 1) for m in range(1 << len(weights)))
    table = next((t for t in firing.tables if t.values == values and "rules" not in t.name), None)
    if table is None:
        table = Table(scope.name(name), build.smallest_type(0, max(values)), values)
        firing.tables.append(table)
    return Element(table.name, table.ctype, bits, 0, max(values), True)


def _numbers(s: _Sums, single: Evaluated, turned: Evaluated | None, pair: Evaluated | None) -> tuple[SetNumbers, ...]:
    found: list[SetNumbers] = []
    for f in s.even.forms:
        if len(f.members) == 2:
            assert pair is not None
            area, moment = pair.area_error, pair.moment_error
        else:
            area = single.area_error * s.even.multiples[f.members[0]]
            moment = turned.moment_error if f.moment_sign and turned is not None else single.moment_error
        found.append(SetNumbers(f, area, moment, 0.0, 0.0))
    return tuple(found)


def _mean(
    s: _Sums, sets: tuple[SetNumbers, ...], division: Division, scope: Scope
) -> tuple[list[Stmt], Expr, CentroidNumbers]:
    name = s.output.name
    area = replace_hi(build.above(s.area, s.overlap), s.scale.largest_area)
    moment = build.above(s.moment, s.moment_off)
    a = Local(scope.name(f"{name}_a"), "uint32", 0, area.hi)
    m = Local(scope.name(f"{name}_m"), "uint32", 0, build.UINT32_MAX)
    body: list[Stmt] = [Comment(f"centroid of {name}"), Define(a, area, True), Define(m, moment, True)]
    divisor = build.mul(a, Const(s.scale.weight_denominator))
    steps, raw, tail = mean_to_raw(s.output.variable, m, divisor, division, scope)
    return body + steps, raw, CentroidNumbers(sets, tail)
