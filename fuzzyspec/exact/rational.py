"""The meaning of a controller at one point, in rationals: the definitions word by word, every cell and every rule.

Shares nothing with the float64 evaluation, which is held to it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import assert_never

from fuzzyspec.model.controller import And, Antecedent, Controller, Inference, Is, Not, Or, Output
from fuzzyspec.model.term import PiecewiseLinear, Shape, Singleton

ZERO, ONE = Fraction(0), Fraction(1)


@dataclass(slots=True)
class Point:
    """As ``Exact``, for one case; ``outputs`` are the controller's own.

    ``areas``: per output what its centroid was divided by (the sum of the levels for a weighted average), 0 where it
    took its ``otherwise``: how well conditioned the quotient is. ``acting`` is the code that was taken.
    """

    outputs: dict[str, Fraction]
    decisions: dict[str, int]
    margins: dict[str, Fraction]
    state: dict[str, Fraction]
    areas: dict[str, Fraction]
    acting: int = 0


def evaluate_controller_exactly(
    controller: Controller,
    inputs: Mapping[str, Fraction],
    decisions: Mapping[str, int] | None = None,
    state: Mapping[str, Fraction] | None = None,
) -> dict[str, Fraction]:
    """The outputs at one point, in declared units. Raises ValueError where the definitions give no value."""
    return controller_point(controller, inputs, decisions, state).outputs


def controller_point(
    controller: Controller,
    inputs: Mapping[str, Fraction],
    decisions: Mapping[str, int] | None = None,
    state: Mapping[str, Fraction] | None = None,
) -> Point:
    """One call at one point, with its decisions and their margins as in ``evaluate_controller``."""
    given = decisions or {}
    point = Point({}, {}, {}, {}, {})
    degrees = [
        [membership(t.shape, max(i.variable.lo, min(i.variable.hi, inputs[i.name]))) for t in i.terms]
        for i in controller.inputs
    ]
    rules = list(_rules(controller, degrees))
    for number, output in enumerate(controller.outputs):
        fired = [(terms[number], strength) for terms, strength, _ in rules if number in terms]
        best = max((s for _, s in fired), default=ZERO)
        fires = True
        if not controller.always_fires[number]:
            key = f"fires.{output.name}"
            point.decisions[key] = int(best >= controller.fires_at)
            point.margins[key] = abs(best - controller.fires_at)
            fires = bool(_told(given, key, point.decisions[key]))
        moment, area = _moment_and_area(output, controller.infer, fired) if fires else (ZERO, ZERO)
        point.areas[output.name] = area
        if area:
            value = moment / area
        else:
            if output.fallback is None:
                raise ValueError(f"nothing gives {output.name} a value here")
            value = output.fallback.value
            if output.fallback.hold and state is not None:
                value = state.get(output.name, value)
        point.outputs[output.name] = value
        if output.fallback is not None and output.fallback.hold:
            point.state[output.name] = value
    if controller.behaviors:
        _decide_acting(controller, rules, given, point)
    return point


def _told(given: Mapping[str, int], key: str, own: int) -> int:
    """The outcome to take: what is given, unless that is -1."""
    told = given.get(key, -1)
    return own if told < 0 else told


_Rule = tuple[Mapping[int, int], Fraction, int]
"""Output number to term, strength, owner."""


def _rules(controller: Controller, degrees: Sequence[Sequence[Fraction]]) -> Iterator[_Rule]:
    infer, cells = controller.infer, controller.cells
    if cells is not None:
        for number, cell in enumerate(itertools.product(*(range(size) for size in cells.shape))):
            strength = _and(infer, [d[t] for d, t in zip(degrees, cell, strict=True)])
            consequents = {o: row[number] for o, row in enumerate(cells.consequents) if row[number] >= 0}
            yield consequents, strength, cells.owner[number]
    for rule in controller.sentences:
        strength = rule.weight * _truth(rule.antecedent, infer, degrees)
        # one by one: nothing forbids two consequents on one output
        for output, term in rule.consequents:
            yield {output: term}, strength, 0


def membership(shape: Shape, x: Fraction) -> Fraction:
    """Degree of ``x``: linear between the points, constant beyond them, the largest value at a jump."""
    match shape:
        case Singleton(at):
            return ONE if x == at else ZERO
        case PiecewiseLinear(points):
            there = [y for px, y in points if px == x]
            if there:
                return max(there)
            if x < points[0][0]:
                return points[0][1]
            for (x0, y0), (x1, y1) in itertools.pairwise(points):
                if x0 < x < x1:
                    return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
            return points[-1][1]
        case _:
            assert_never(shape)


def _and(infer: Inference, operands: Sequence[Fraction]) -> Fraction:
    if infer.and_ == "min":
        return min(operands)
    result = ONE
    for x in operands:
        result *= x
    return result


def _or(infer: Inference, operands: Sequence[Fraction]) -> Fraction:
    if infer.or_ == "max":
        return max(operands)
    none = ONE
    for x in operands:
        none *= 1 - x
    return 1 - none


def _truth(antecedent: Antecedent, infer: Inference, degrees: Sequence[Sequence[Fraction]]) -> Fraction:
    match antecedent:
        case Is(number, terms):
            return _or(infer, [degrees[number][t] for t in terms])
        case Not(operand):
            return 1 - _truth(operand, infer, degrees)
        case And(operands):
            return _and(infer, [_truth(o, infer, degrees) for o in operands])
        case Or(operands):
            return _or(infer, [_truth(o, infer, degrees) for o in operands])
        case _:
            assert_never(antecedent)


def _moment_and_area(
    output: Output, infer: Inference, fired: Sequence[tuple[int, Fraction]]
) -> tuple[Fraction, Fraction]:
    """Of what (term, strength) of every rule imply together; the moment is about 0."""
    if infer.aggregate == "max":
        fired = [(t, max(s for u, s in fired if u == t)) for t in sorted({t for t, _ in fired})]
    if infer.defuzzify == "weighted_average":
        area = sum((s for _, s in fired), ZERO)
        moment = sum((s * _place(output, t) for t, s in fired), ZERO)
    else:
        implied = [_Implied(output.terms[t].shape, s, infer.implies == "min") for t, s in fired if s > 0]
        groups = [implied] if infer.aggregate == "max" else [[one] for one in implied]
        area = moment = ZERO
        for group in groups:
            a, m = _integrals(group, output.integrate_lo, output.integrate_hi)
            area, moment = area + a, moment + m
    return moment, area


def _place(output: Output, term: int) -> Fraction:
    shape = output.terms[term].shape
    if not isinstance(shape, Singleton):
        raise ValueError(f"the weighted average takes singletons; {output.terms[term].name} is none")
    return shape.at


@dataclass(frozen=True, slots=True)
class _Implied:
    """An output set clipped or scaled."""

    shape: Shape
    strength: Fraction
    clip: bool

    def __call__(self, y: Fraction) -> Fraction:
        whole = membership(self.shape, y)
        return min(whole, self.strength) if self.clip else whole * self.strength


def _integrals(group: Sequence[_Implied], lo: Fraction, hi: Fraction) -> tuple[Fraction, Fraction]:
    """Area and moment about 0 of the group's pointwise maximum over [lo, hi].

    Cut at the points of all shapes; within a cut piece every clipped set is concave or a line, with one bend at most.
    Cutting at these bends leaves lines, and cutting where they cross leaves one line on top. A line over an open
    piece is known from two inner points, so jumps at its ends do not matter.
    """
    cuts = {lo, hi}
    for one in group:
        if not isinstance(one.shape, PiecewiseLinear):
            raise ValueError("a singleton has no area")
        cuts |= {x for x, _ in one.shape.points if lo < x < hi}
    area = moment = ZERO
    if not group:
        return area, moment
    for a, b in _pieces(cuts):
        bends = {a, b}
        for one in group:
            start, slope = _line(lambda y, s=one.shape: membership(s, y), a, b)
            if one.clip and slope:
                bends.add(a + (one.strength - start) / slope)
        for c, d in _pieces({y for y in bends if a <= y <= b}):
            lines = [_line(one, c, d) for one in group]
            crossings = {c, d}
            for (p, m), (q, n) in itertools.combinations(lines, 2):
                if m != n:
                    crossings.add(c + (q - p) / (m - n))
            for e, f in _pieces({y for y in crossings if c <= y <= d}):
                left = max(p + m * (e - c) for p, m in lines)
                right = max(p + m * (f - c) for p, m in lines)
                area += (f - e) * (left + right) / 2
                moment += (f - e) * (e * (2 * left + right) + f * (left + 2 * right)) / 6
    return area, moment


def _pieces(cuts: set[Fraction]) -> Iterator[tuple[Fraction, Fraction]]:
    return itertools.pairwise(sorted(cuts))


def _line(function: object, a: Fraction, b: Fraction) -> tuple[Fraction, Fraction]:
    """Value at ``a`` (from inside) and slope of what is a line over (a, b)."""
    assert callable(function)
    third = (b - a) / 3
    p, q = function(a + third), function(a + 2 * third)
    slope = (q - p) / third
    return p - slope * third, slope


def _decide_acting(controller: Controller, rules: Sequence[_Rule], given: Mapping[str, int], point: Point) -> None:
    best = {b.code: ZERO for b in controller.behaviors}
    for _, strength, owner in rules:
        if owner:
            best[owner] = max(best[owner], strength)
    strongest = max(best.values())
    code = min(c for c, s in best.items() if s == strongest) if strongest >= controller.fires_at else 0
    needed = max(strongest, controller.fires_at)
    distance = {0: max(strongest - controller.fires_at, ZERO)} | {c: needed - s for c, s in best.items()}
    taken = _told(given, "acting", code)
    point.decisions["acting"] = code
    point.acting = taken
    point.margins["acting"] = distance[taken] if taken != code else min(d for c, d in distance.items() if c != code)
