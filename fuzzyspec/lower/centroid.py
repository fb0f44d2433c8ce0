"""The exact centroid of the union of clipped sets, in closed form (docs/numbers.md, "The centroid").

The program adds, for each set of terms with common support, its area and moment at its clip height; runs of sets with
the same shape (the interior triangles of an even partition, their overlaps) share a loop.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    Assign,
    Branch,
    Comment,
    Const,
    Define,
    Element,
    Expr,
    Function,
    Local,
    Loop,
    Port,
    Program,
    ReadPort,
    SetOutput,
    Stmt,
    Table,
)
from fuzzyspec.fixed.run import run
from fuzzyspec.lower.clipped import ClippedSet, clipped_sets
from fuzzyspec.lower.horner import Horner, fit
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.machine import Machine
from fuzzyspec.lower.mean import Tail, mean_to_raw
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.controller import Output

HALF = Fraction(1, 2)
SUM_LIMIT = 2**24 - 2**9
"""Area sums stay below the quotient's 2**31, with room for every rounding in them."""
MAX_DENOMINATOR = 64
"""References with a common denominator up to this are exact integer weights."""

Floats = npt.NDArray[np.float64]


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
    sets: tuple[SetNumbers, ...]
    tail: Tail


@dataclass(frozen=True)
class _Scale:
    """``area`` is integer units per unit of relative area; moments are counted in ``area * weight_denominator``.

    ``exact`` tells whether the references are integer weights; otherwise they are Q16 and multiplied high.
    """

    area: Fraction
    weight_denominator: int
    exact: bool


@dataclass(frozen=True)
class _Group:
    """Consecutive sets of one shape: the members of the i-th are ``first.members + i``."""

    sets: tuple[ClippedSet, ...]

    @property
    def first(self) -> ClippedSet:
        return self.sets[0]


def centroid(
    output: Output, levels: str, machine: Machine, scope: Scope
) -> tuple[list[Stmt], Expr, list[Table], CentroidNumbers]:
    """Statements, the output's raw, tables and numbers, from the array ``levels`` of clip heights (Q15, a slot a term).

    Raises TooManySets.
    """
    forms = clipped_sets(output)
    scale = _scale(forms)
    name = output.name
    positive = [f for f in forms if f.sign > 0]
    negative = [f for f in forms if f.sign < 0]
    tables: list[Table] = []
    numbers: list[SetNumbers] = []
    body: list[Stmt] = [Comment(f"centroid of {name}: area and moment of the union of the clipped terms")]
    sums: dict[str, Local] = {}
    moves_down = any(_lowers(f) for f in forms)
    wanted = ["area", "moment"] + (["overlap"] if negative else []) + (["moment_off"] if negative or moves_down else [])
    for part in wanted:
        sums[part] = Local(scope.name(f"{name}_{part}"), "uint32", 0, build.UINT32_MAX)
        body.append(Define(sums[part], Const(0), False))
    for group in (*_groups(positive), *_groups(negative)):
        steps, more, found = _group(group, levels, scale, sums, scope, name)
        body += steps
        tables += more
        numbers += found
    area: Expr = sums["area"]
    if negative:
        area = build.above(area, sums["overlap"])
    area = _capped(area, SUM_LIMIT // scale.weight_denominator if scale.exact else SUM_LIMIT)
    moment: Expr = sums["moment"]
    if "moment_off" in sums:
        moment = build.above(moment, sums["moment_off"])
        bound = Local(scope.name(f"{name}_m"), "uint32", 0, build.UINT32_MAX)
        body.append(Define(bound, moment, True))
        moment = bound
    bound = Local(scope.name(f"{name}_a"), "uint32", 0, area.hi)
    body.append(Define(bound, area, True))
    divisor = build.mul(bound, Const(scale.weight_denominator if scale.exact else 1))
    steps, raw, tail = mean_to_raw(output.variable, moment, divisor, machine, scope)
    return body + steps, raw, tables, CentroidNumbers(tuple(numbers), tail)


def _lowers(form: ClippedSet) -> bool:
    return form.moment_sign * form.sign < 0


def _capped(area: Expr, hi: int) -> Expr:
    """The same expression with the interval that the scale was chosen for."""
    return replace(area, hi=min(area.hi, hi)) if not isinstance(area, Const) else area


def _scale(forms: tuple[ClippedSet, ...]) -> _Scale:
    denominator = math.lcm(*(f.reference.denominator for f in forms))
    exact = denominator <= MAX_DENOMINATOR
    weight = denominator if exact else 1
    # A scale in which the first width is a power of two makes even partitions exact.
    unit = forms[0].pieces[0].width[0]
    for f in forms:
        ratio = f.pieces[0].width[0] / unit
        if ratio.denominator != 1 or ratio.numerator & (ratio.numerator - 1):
            unit = min(unit, f.pieces[0].width[0])
    total = max(sum((f.full_area for f in forms if f.sign == sign), Fraction(0)) for sign in (1, -1))
    exponent = 31
    while total / unit * 2**exponent * weight >= SUM_LIMIT - 2**13:
        exponent -= 1
    return _Scale(Fraction(2) ** exponent / unit, weight, exact)


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
    group: _Group, levels: str, scale: _Scale, sums: dict[str, Local], scope: Scope, name: str
) -> tuple[list[Stmt], list[Table], list[SetNumbers]]:
    form = group.first
    pieces = _integer_pieces(form, scale)
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
    inner, area, moment, numbers = _evaluated(form, pieces, scale, height, scope, name)
    tables: list[Table] = []
    target, moment_target = ("area", "moment") if form.sign > 0 else ("overlap", "moment_off")
    inner.append(_accumulate(sums[target], area))
    weights = [f.reference * scale.weight_denominator if scale.exact else f.reference * 2**16 for f in group.sets]
    integers = [math.floor(w + HALF) for w in weights]
    if any(integers):
        weight = _weight(integers, counter, single, scope, name, tables)
        value = build.mul(area, weight) if scale.exact else build.mul_high(area, weight)
        inner.append(_accumulate(sums[moment_target], value))
    if moment is not None:
        own = "moment" if form.sign * form.moment_sign > 0 else "moment_off"
        inner.append(_accumulate(sums[own], moment))
    body.append(Branch(build.compare(">", height, Const(0)), tuple(inner)))
    found = [
        SetNumbers(
            f,
            numbers[0],
            numbers[1],
            float(abs(Fraction(w, scale.weight_denominator if scale.exact else 2**16) - f.reference)),
            0.0 if scale.exact or w in (0, 2**16) else float(1 / scale.area),
        )
        for f, w in zip(group.sets, integers, strict=True)
    ]
    if single:
        return body, tables, found
    return [Loop(counter, len(group.sets), tuple(body))], tables, found


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


# --- one set's polynomials -------------------------------------------------------------------


@dataclass(frozen=True)
class _IntegerPiece:
    """From clip height ``start`` (Q15): ``area`` and ``moment`` polynomials of ``c - start``."""

    start: int
    area: Horner
    moment: Horner | None


def _integer_pieces(form: ClippedSet, scale: _Scale) -> list[_IntegerPiece]:
    pieces: list[_IntegerPiece] = []
    moments = scale.area * (scale.weight_denominator if scale.exact else 1)
    for i, p in enumerate(form.pieces):
        start = math.ceil(p.start * DEGREE_ONE)
        last = i == len(form.pieces) - 1
        end = math.floor(p.end * DEGREE_ONE) if last else math.ceil(p.end * DEGREE_ONE) - 1
        if end < start:
            continue
        c = Fraction(start, DEGREE_ONE)
        w0, w1 = p.width
        area = p.area + w0 * (c - p.start) + w1 * (c * c - p.start * p.start) / 2
        area_poly = (w0 + w1 * c, w1 / 2, Fraction(0))
        moment: Horner | None = None
        if form.moment_sign:
            v0, v1, v2 = p.first
            base = p.moment + v0 * (c - p.start) + v1 * (c**2 - p.start**2) / 2 + v2 * (c**3 - p.start**3) / 3
            poly = (v0 + v1 * c + v2 * c * c, (v1 + 2 * v2 * c) / 2, v2 / 3)
            moment = fit(base, poly, end - start, moments)
        pieces.append(_IntegerPiece(start, fit(area, area_poly, end - start, scale.area), moment))
    return pieces


def _evaluated(
    form: ClippedSet, pieces: list[_IntegerPiece], scale: _Scale, height: Local, scope: Scope, name: str
) -> tuple[list[Stmt], Local, Local | None, tuple[Floats, Floats]]:
    """Statements that evaluate one set at ``height``; both results are proved by running every height."""
    top = math.floor(form.height * DEGREE_ONE)
    draft, area, moment = _draft(pieces, top, height, Scope(set(scope.taken)), name, None)
    areas, moments = _all_heights(draft, area, moment, height)
    hi = (int(areas.max()), int(moments.max()))
    steps, area, moment = _draft(pieces, top, height, scope, name, hi)
    exact_area, exact_moment = closed_form(form)
    unit = float(scale.area)
    moment_unit = unit * (scale.weight_denominator if scale.exact else 1)
    slack = 2.0**-44  # float64 evaluation of the closed form: under 2**8 roundings of values below 1
    area_error = np.abs(areas / unit - exact_area) + slack
    moment_error = (
        np.abs(moments / moment_unit - exact_moment) + slack if moment is not None else np.zeros_like(exact_area)
    )
    return steps, area, moment, (area_error, moment_error)


def _draft(
    pieces: list[_IntegerPiece], top: int, height: Local, scope: Scope, name: str, hi: tuple[int, int] | None
) -> tuple[list[Stmt], Local, Local | None]:
    loose = (2**32 - 1, 2**32 - 1) if hi is None else hi
    area = Local(scope.name(f"{name}_part"), "uint32", 0, loose[0])
    moment = Local(scope.name(f"{name}_turn"), "uint32", 0, loose[1]) if pieces[0].moment is not None else None
    body: list[Stmt] = []
    clipped = height
    if top < DEGREE_ONE:
        clipped = Local(scope.name(f"{name}_c"), "uint16", 0, top)
        body.append(Define(clipped, build.least(height, Const(top)), True))
    single = len(pieces) == 1
    if not single:
        body.append(Define(area, Const(0), False))
        if moment is not None:
            body.append(Define(moment, Const(0), False))
    chain: tuple[Stmt, ...] = ()
    for i in range(len(pieces) - 1, -1, -1):
        p = pieces[i]
        steps: list[Stmt] = []
        d = clipped
        if p.start:
            d = Local(scope.name(f"{name}_d"), "uint16", 0, p.area.length)
            steps.append(Define(d, build.sub_guarded(clipped, Const(p.start), p.area.length), True))
        elif not single:
            d = replace(clipped, hi=p.area.length)
        for poly, into in ((p.area, area), (p.moment, moment)):
            if poly is None or into is None:
                continue
            more, value = poly.steps(d, name if into is area else f"{name}_moment", scope)
            steps += more
            value = replace(value, hi=min(value.hi, into.hi)) if not isinstance(value, Const) else value
            steps.append(Define(into, value, True) if single else Assign(into, value))
        if not chain:
            chain = tuple(steps)
        else:
            chain = (Branch(build.compare("<", clipped, Const(pieces[i + 1].start)), tuple(steps), chain),)
    return body + list(chain), area, moment


def _all_heights(
    body: list[Stmt], area: Local, moment: Local | None, height: Local
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    outputs = [Port("area", "uint32", 0, build.UINT32_MAX, None), Port("moment", "uint32", 0, build.UINT32_MAX, None)]
    steps: list[Stmt] = [Define(height, ReadPort("c", "uint16", 0, DEGREE_ONE), True), *body, SetOutput("area", area)]
    if moment is not None:
        steps.append(SetOutput("moment", moment))
    port = Port("c", "uint16", 0, DEGREE_ONE, None)
    function = Function("heights", "controller", (port,), tuple(outputs), (), (), (), (), (), tuple(steps))
    result = run(Program("lemma", (function,)), "heights", {"c": np.arange(DEGREE_ONE + 1)})
    return result.outputs["area"], result.outputs["moment"]


def closed_form(form: ClippedSet) -> tuple[Floats, Floats]:
    """F and H at every clip height, in float64."""
    c = np.minimum(np.arange(DEGREE_ONE + 1) / DEGREE_ONE, float(form.height))
    area, moment = np.zeros_like(c), np.zeros_like(c)
    for p in form.pieces:
        a = float(p.start)
        inside = c >= a
        d = c - a
        w0, w1 = float(p.width[0] + p.width[1] * p.start), float(p.width[1])
        v = p.first
        v0 = float(v[0] + v[1] * p.start + v[2] * p.start * p.start)
        v1, v2 = float(v[1] + 2 * v[2] * p.start), float(v[2])
        area = np.where(inside, float(p.area) + d * (w0 + d * w1 / 2), area)
        moment = np.where(inside, float(p.moment) + d * (v0 + d * (v1 / 2 + d * v2 / 3)), moment)
    return area, moment
