"""The exact centroid of the union of clipped sets, in closed form (docs/numbers.md, "The centroid").

The program adds, for each set of terms with common support, its area and moment at its clip height; runs of sets with
the same shape (the interior triangles of an even partition, their overlaps) share a loop.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    Assign,
    Branch,
    Comment,
    Const,
    Define,
    Division,
    Element,
    Expr,
    Local,
    Loop,
    Stmt,
    Table,
)
from fuzzyspec.lower.clipped import ClippedSet, clipped_sets
from fuzzyspec.lower.even import EvenOutput, evaluate_even, even_output
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.mean import Tail, mean_to_raw
from fuzzyspec.lower.scope import Scope
from fuzzyspec.lower.sets import Floats, Scale, closed_form, evaluate, scale_of
from fuzzyspec.lower.strategy import Precision
from fuzzyspec.model.controller import Output

HALF = Fraction(1, 2)


@dataclass(frozen=True)
class SetNumbers:
    """One set's integer evaluation against its closed form, by exhaustion over all 32,769 clip heights.

    ``area_error[c]`` and ``moment_error[c]`` bound |integer - exact| at clip height c / 2**15, in units of
    relative position
    (area) and its product with it (moment). ``weight_error`` bounds the rounding of the reference.
    """

    form: ClippedSet
    area_error: Floats
    moment_error: Floats
    weight_error: float
    product_error: float


@dataclass(frozen=True)
class CentroidNumbers:
    """``area_slip`` and ``moment_slip`` bound, in the sets' units, what shortening both sums for the division costs."""

    sets: tuple[SetNumbers, ...]
    tail: Tail
    area_slip: float = 0.0
    moment_slip: float = 0.0


@dataclass(frozen=True)
class _Group:
    """Consecutive sets of one shape: the members of the i-th are ``first.members + i``."""

    sets: tuple[ClippedSet, ...]

    @property
    def first(self) -> ClippedSet:
        return self.sets[0]


def centroid(
    output: Output,
    levels: str,
    division: Division,
    scope: Scope,
    fires: bool = False,
    precision: Precision = "full",
    used: frozenset[int] | None = None,
) -> tuple[list[Stmt], Expr, list[Table], CentroidNumbers]:
    """Statements, the output's raw, tables and numbers, from the array ``levels`` of clip heights (Q15, a slot a term).

    ``used``: the terms that some rule sets; without it all.
    ``fires``: some term is always reached to 1/2 or more, which keeps the area from 0. Raises TooManySets.
    """
    forms = clipped_sets(output)
    even = even_output(output, precision)
    scale = scale_of(forms) if even is None else even.scale
    name = output.name
    reached = [f for f in forms if used is None or used.issuperset(f.members)]
    positive = [f for f in reached if f.sign > 0]
    negative = [f for f in reached if f.sign < 0]
    tables: list[Table] = []
    body: list[Stmt] = [Comment(f"centroid of {name}: area and moment of the union of the clipped terms")]
    sums = declared_sums(output, forms, body, scope)
    for group in (*_groups(positive), *_groups(negative)):
        steps, more = _group(group, even, levels, scale, sums, scope, name)
        body += steps
        tables += more
    area, moment = differences(output, sums, body, scope)
    if even is not None:
        steps, raw, found_numbers = even_mean(output, even, area, moment, division, scope, fires)
    else:
        steps, raw, found_numbers = any_mean(output, forms, area, moment, division, scope, fires)
    return body + steps, raw, tables, found_numbers


def declared_sums(output: Output, forms: tuple[ClippedSet, ...], body: list[Stmt], scope: Scope) -> dict[str, Local]:
    """Append the statements that declare what the sets add up to: ``area`` and ``moment``, and where some set is taken
    off, ``overlap`` and ``moment_off``."""
    negative = any(f.sign < 0 for f in forms)
    names = ["area", "moment"] + (["overlap"] if negative else [])
    if negative or any(_lowers(f) for f in forms):
        names.append("moment_off")
    sums = {n: Local(scope.name(f"{output.name}_{n}"), "uint32", 0, build.UINT32_MAX) for n in names}
    body += [Define(s, Const(0), False) for s in sums.values()]
    return sums


def differences(output: Output, sums: dict[str, Local], body: list[Stmt], scope: Scope) -> tuple[Expr, Expr]:
    """Area and moment of the union: what was added less what was taken off."""
    area: Expr = sums["area"]
    if "overlap" in sums:
        area = build.above(area, sums["overlap"])
    if "moment_off" not in sums:
        return area, sums["moment"]
    moment = Local(scope.name(f"{output.name}_m"), "uint32", 0, build.UINT32_MAX)
    body.append(Define(moment, build.above(sums["moment"], sums["moment_off"]), True))
    return area, moment


def any_mean(
    output: Output,
    forms: tuple[ClippedSet, ...],
    area: Expr,
    moment: Expr,
    division: Division,
    scope: Scope,
    fires: bool = False,
) -> tuple[list[Stmt], Expr, CentroidNumbers]:
    """The raw of an output from the sums of its sets; ``fires``: some term is reached to 1/2 or more."""
    scale = scale_of(forms)
    numbers = _sets(forms, scale)
    area = build.capped(area, scale.largest_area)
    if fires:
        area = build.floored(area, _least_area(scale, numbers))
    bound = Local(scope.name(f"{output.name}_a"), "uint32", area.lo, area.hi)
    divisor = build.mul(bound, Const(scale.weight_denominator if scale.exact else 1))
    steps, raw, tail = mean_to_raw(output.variable, moment, divisor, division, scope)
    return [Define(bound, area, True), *steps], raw, CentroidNumbers(numbers, tail)


def weight_of(form: ClippedSet, scale: Scale) -> int:
    """A set's reference as an integer."""
    return math.floor(form.reference * (scale.weight_denominator if scale.exact else 2**16) + HALF)


def _sets(forms: tuple[ClippedSet, ...], scale: Scale) -> tuple[SetNumbers, ...]:
    """The numbers of an output's sets, whichever program adds them."""
    height = Local("h", "uint16", 0, DEGREE_ONE)
    sets: list[SetNumbers] = []
    for f in forms:
        found, weight = evaluate(f, scale, height, Scope(), "set"), weight_of(f, scale)
        off = float(abs(Fraction(weight, scale.weight_denominator if scale.exact else 2**16) - f.reference))
        product = 0.0 if scale.exact or weight in (0, 2**16) else float(1 / scale.area)
        sets.append(SetNumbers(f, found.area_error, found.moment_error, off, product))
    return tuple(sets)


@lru_cache(maxsize=64)
def _even_sets(even: EvenOutput) -> tuple[SetNumbers, ...]:
    """The numbers of an even output's sets, whichever program adds them."""
    height = Local("h", "uint16", 0, DEGREE_ONE)
    sets: list[SetNumbers] = []
    for f in even.forms:
        found = evaluate_even(f, even, height, Scope(), "set")
        count = even.halves[f.members[0]] if len(f.members) == 1 else 1
        sets.append(SetNumbers(f, found.area_error * count, found.moment_error, 0.0, 0.0))
    return tuple(sets)


def even_mean(
    output: Output,
    even: EvenOutput,
    area: Expr,
    moment: Expr,
    division: Division,
    scope: Scope,
    fires: bool = False,
) -> tuple[list[Stmt], Expr, CentroidNumbers]:
    """The raw of an even output from its sums.

    ``fires``: some term is reached to 1/2 or more, so the area is at least the smallest term's there.
    """
    name, shift = output.name, even.shift
    least = min(even.counts) * (3 << (even.bits.area - 2)) if fires else 0
    area = build.floored(build.capped(area, even.domain << even.bits.area), least)
    a_value = build.shift_right(build.mul(area, Const(even.span)), shift)
    m_value = build.shift_right(moment, shift)
    a, m = build.local(scope.name(f"{name}_a"), a_value), build.local(scope.name(f"{name}_m"), m_value)
    body: list[Stmt] = [Define(a, a_value, True), Define(m, m_value, True)]
    steps, raw, tail = mean_to_raw(output.variable, m, a, division, scope)
    slip = float(2**shift / (even.scale.area * even.span)) if shift else 0.0
    return body + steps, raw, CentroidNumbers(_even_sets(even), tail, slip, slip)


def _least_area(scale: Scale, numbers: tuple[SetNumbers, ...]) -> int:
    """Of the union, in integers, where some term is reached to 1/2: what that one covers, less all roundings."""
    alone = min(float(closed_form(n.form)[0][DEGREE_ONE // 2]) for n in numbers if len(n.form.members) == 1)
    off = sum(float(n.area_error.max()) for n in numbers)
    return max(0, math.floor(float(scale.area) * (alone - off)) - 1)


def _lowers(form: ClippedSet) -> bool:
    return form.moment_sign * form.sign < 0


def _groups(forms: Sequence[ClippedSet]) -> list[_Group]:
    groups: list[_Group] = []
    for form in forms:
        if groups:
            last = groups[-1].sets[-1]
            follows = tuple(m + 1 for m in last.members) == form.members
            if follows and last.pieces == form.pieces and last.moment_sign == form.moment_sign:
                groups[-1] = _Group((*groups[-1].sets, form))
                continue
        groups.append(_Group((form,)))
    return groups


def _group(
    group: _Group,
    even: EvenOutput | None,
    levels: str,
    scale: Scale,
    sums: dict[str, Local],
    scope: Scope,
    name: str,
) -> tuple[list[Stmt], list[Table]]:
    form = group.first
    single = len(group.sets) == 1
    counter = Local(scope.name("k"), "uint8", 0, len(group.sets) - 1)

    def member(k: int) -> Expr:
        index: Expr = Const(k) if single else build.add(counter, Const(k))
        return Element(levels, "uint16", index, 0, DEGREE_ONE, False)

    body: list[Stmt] = []
    height = Local(scope.name(f"{name}_h"), "uint16", 0, DEGREE_ONE)
    body.append(Define(height, member(form.members[0]), len(form.members) == 1))
    for k in form.members[1:]:
        other = Local(scope.name(f"{name}_h"), "uint16", 0, DEGREE_ONE)
        body += [
            Define(other, member(k), True),
            Branch(build.compare("<", other, height), (Assign(height, other),)),
        ]
    multiple = even.counts[form.members[0]] if even is not None and len(form.members) == 1 else 1
    if even is None:
        found = evaluate(form, scale, height, scope, name)
    else:
        found = evaluate_even(form, even, height, scope, name)
    inner, area, moment = list(found.steps), found.area, found.moment
    tables: list[Table] = []
    target, moment_target = ("area", "moment") if form.sign > 0 else ("overlap", "moment_off")
    inner.append(_accumulate(sums[target], build.mul(area, Const(multiple))))
    integers = [weight_of(f, scale) for f in group.sets]
    if any(integers):
        weight = _weight([multiple * w for w in integers], counter, single, scope, name, tables)
        value = build.mul(area, weight) if scale.exact else build.mul_high(area, weight)
        inner.append(_accumulate(sums[moment_target], value))
    if moment is not None:
        own = "moment" if form.sign * form.moment_sign > 0 else "moment_off"
        inner.append(_accumulate(sums[own], moment))
    body.append(Branch(build.compare(">", height, Const(0)), tuple(inner)))
    if single:
        return body, tables
    return [Loop(counter, len(group.sets), tuple(body))], tables


def _accumulate(total: Local, value: Expr) -> Stmt:
    """``total += value``: the scale keeps the areas of either sign below 2**31 in sum, and moments below twice that."""
    return Assign(total, build.add_bounded(total, value, build.UINT32_MAX))


def _weight(integers: list[int], counter: Local, single: bool, scope: Scope, name: str, tables: list[Table]) -> Expr:
    if single:
        return Const(integers[0])
    step = integers[1] - integers[0]
    if step >= 0 and all(b - a == step for a, b in pairwise(integers)):
        return build.add(build.mul(counter, Const(step)), Const(integers[0]))
    ctype = build.smallest_type(0, max(integers))
    table = Table(scope.name(f"{name}_weight"), ctype, tuple(integers))
    tables.append(table)
    return Element(table.name, ctype, counter, min(integers), max(integers), True)
