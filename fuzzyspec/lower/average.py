"""Weighted average of singletons: ``sum(level * place) / sum(level)``."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Assign, Comment, Const, Define, Division, Expr, Local, Stmt
from fuzzyspec.lower.fire import Firing
from fuzzyspec.lower.mean import Tail, mean_to_raw
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.controller import Output
from fuzzyspec.model.term import Singleton

HALF = Fraction(1, 2)
DIVISOR_LIMIT = 2**31
MAX_DENOMINATOR = 64


@dataclass(frozen=True)
class AverageNumbers:
    """``places`` are relative to the range; ``weight_error`` bounds their rounding, ``product_error`` the sums'
    (in levels)."""

    places: tuple[Fraction, ...]
    weight_error: float
    product_error: float
    tail: Tail


def average(
    output: Output, index: int, firing: Firing, division: Division, scope: Scope
) -> tuple[list[Stmt], Expr, AverageNumbers]:
    """Statements and the output's raw from its level array."""
    name = output.name
    lo, span = output.variable.lo, output.variable.hi - output.variable.lo
    places: list[Fraction] = []
    for term in output.terms:
        assert isinstance(term.shape, Singleton)
        places.append((term.shape.at - lo) / span)
    total = firing.top if firing.bits != 15 or firing.top > firing.one else len(places) * firing.one
    denominator = math.lcm(*(p.denominator for p in places))
    exact = denominator <= MAX_DENOMINATOR and denominator * total < DIVISOR_LIMIT
    lift = 0
    while not exact and total << (lift + 1) < DIVISOR_LIMIT // 2:
        lift += 1
    area = Local(scope.name(f"{name}_sum"), "uint32", 0, total << lift)
    # A mean of places in [0, 1], so the moment never exceeds the sum it is counted in.
    moment = Local(scope.name(f"{name}_moment"), "uint32", 0, (total << lift) * (denominator if exact else 1))
    body: list[Stmt] = [
        Comment(f"weighted average of {name}"),
        Define(area, Const(0), False),
        Define(moment, Const(0), False),
    ]
    worst = Fraction(0)
    for k, place in enumerate(places):
        level = build.shift_left(firing.level(index, Const(k)), lift)
        part = Local(scope.name(f"{name}_part"), "uint32", 0, min(level.hi, area.hi))
        body.append(Define(part, level, True))
        body.append(Assign(area, build.add_bounded(area, part, area.hi)))
        unit = denominator if exact else 2**16
        weight = math.floor(place * unit + HALF)
        worst = max(worst, abs(Fraction(weight, unit) - place))
        if weight:
            value = build.mul(part, Const(weight)) if exact else build.mul_high(part, Const(weight))
            body.append(Assign(moment, build.add_bounded(moment, value, moment.hi)))
    divisor = build.mul(area, Const(denominator if exact else 1))
    steps, raw, tail = mean_to_raw(output.variable, moment, divisor, division, scope)
    products = 0.0 if exact else len(places) / float(firing.one << lift)
    return body + steps, raw, AverageNumbers(tuple(places), float(worst), products, tail)
