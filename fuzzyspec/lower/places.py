"""Between raws and computed values: how a raw is read, and how a value is rounded into one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Const, Expr, Test
from fuzzyspec.lower.scaled import Arithmetic, Scaled
from fuzzyspec.model.variable import Variable

FEW = 4


def read(variable: Variable, raw: Expr, error: Fraction = Fraction(0), cause: str = "") -> Scaled:
    """A legal raw as a value in coherent units; ``error`` (in the variable's unit) comes from ``cause``."""
    unit = variable.unit
    return Scaled(
        raw,
        unit.scale * variable.raw.step,
        unit.to_coherent(variable.raw.origin),
        abs(unit.scale) * error,
        cause,
    )


@dataclass(frozen=True)
class Placed:
    """A value in its place: a legal raw, its error in the variable's unit and why, and whether the range was left."""

    raw: Expr
    error: Fraction
    cause: str
    outside: list[Test]


def place(arithmetic: Arithmetic, value: Scaled, variable: Variable, name: str) -> Placed:
    """Saturate a value to the variable's range and round it to the nearest legal raw (lemma "place")."""
    unit, raw = variable.unit, variable.raw
    beta = value.step / unit.scale / raw.step
    alpha = raw.position(unit.from_coherent(value.offset))
    counts = raw.hi - raw.lo
    ends = sorted((raw.position(variable.lo), raw.position(variable.hi)))
    sliver = max(raw.lo - ends[0], ends[1] - raw.hi)
    carried = value.error / abs(unit.scale * raw.step)
    i = arithmetic.bind(value.expr, name)
    if i.lo == i.hi:
        nearest = max(0, min(counts, math.floor(alpha + beta * i.lo - raw.lo + Fraction(1, 2))))
        inside = max(ends[0], min(ends[1], alpha + beta * i.lo))
        error = max(abs(nearest + raw.lo - inside) + carried, sliver)
        outside = _outside(i, value, variable)
        return Placed(Const(raw.lo + nearest), error * abs(raw.step), value.cause, outside)
    if beta > 0:
        u: Expr = build.sub(i, Const(i.lo))
        p0 = alpha + beta * i.lo - raw.lo
    else:
        u = build.sub(Const(i.hi), i)
        p0 = alpha + beta * i.hi - raw.lo
        beta = -beta
    start = max(0, min(u.hi, math.floor(-p0 / beta)))
    end = max(start, min(u.hi, math.ceil((counts - p0) / beta)))
    if start > 0 or end < u.hi:
        u = arithmetic.bind(u, f"{name}_up")
        u = arithmetic.bind(build.above(u, Const(start)), f"{name}_up")
        u = build.least(u, Const(end - start))
    p0 += beta * start
    if end - start < FEW:
        counted, error = _few(arithmetic.bind(u, f"{name}_up"), beta, p0, counts)
        error = max(error + carried, sliver)
        cause = value.cause if carried else ""
        return Placed(build.add(counted, Const(raw.lo)), error * abs(raw.step), cause, _outside(i, value, variable))
    counted, error = arithmetic.scale(arithmetic.bind(u, f"{name}_up") if u.lo != u.hi else u, beta, p0, name)
    counted = build.greatest(arithmetic.bind(counted, f"{name}_near"), Const(0))
    counted = build.least(arithmetic.bind(counted, f"{name}_near"), Const(counts))
    cause = value.cause if carried > error else ""
    error = max(error + carried, sliver)
    return Placed(build.add(counted, Const(raw.lo)), error * abs(raw.step), cause, _outside(i, value, variable))


def _few(u: Expr, beta: Fraction, p0: Fraction, counts: int) -> tuple[Expr, Fraction]:
    """A value whose steps are so much coarser than the place's that only a few of them fall into it: one by one."""
    error = Fraction(0)
    chosen: Expr = Const(0)
    for k in range(u.hi, -1, -1):
        exact = max(Fraction(0), min(Fraction(counts), p0 + beta * k))
        nearest = min(counts, math.floor(exact + Fraction(1, 2)))
        error = max(error, abs(nearest - exact))
        chosen = Const(nearest) if k == u.hi else build.select(build.compare("==", u, Const(k)), Const(nearest), chosen)
    return chosen, error


def _outside(i: Expr, value: Scaled, variable: Variable) -> list[Test]:
    """Tests that hold where the value lies outside the range."""
    tests: list[Test] = []
    lo, hi = (variable.unit.to_coherent(v) for v in (variable.lo, variable.hi))
    bounds = sorted(((lo - value.offset) / value.step, (hi - value.offset) / value.step))
    below, beyond = math.ceil(bounds[0]), math.floor(bounds[1])
    if i.hi < below or beyond < i.lo:
        return [build.compare("<=", Const(0), Const(0))]
    if i.lo < below <= i.hi:
        tests.append(build.compare("<", i, Const(below)))
    if i.lo <= beyond < i.hi:
        tests.append(build.compare(">", i, Const(beyond)))
    return tests
