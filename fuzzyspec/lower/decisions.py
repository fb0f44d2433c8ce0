"""Comparisons in integers.

Between a value without error and a constant the decision is the exact one: the rational threshold becomes an
integer one.
Between computed values the two are brought to one step; the band says how close operands must be to decide differently.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Literal

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Const, Expr, Test
from fuzzyspec.lower.scaled import Arithmetic, Scaled

Op = Literal["<", "<=", ">", ">=", "==", "!="]
FLIP: dict[Op, Op] = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}


def decide(arithmetic: Arithmetic, op: Op, left: Scaled, right: Scaled, name: str) -> tuple[Test, Fraction]:
    """The test and the width of its band, in coherent units (0 where both meanings always agree)."""
    if left.expr.lo == left.expr.hi and right.expr.lo != right.expr.hi:
        return decide(arithmetic, FLIP[op], right, left, name)
    band = left.error + right.error
    if right.expr.lo == right.expr.hi:
        threshold = (right.lo - left.offset) / left.step
        if left.step < 0:
            op = FLIP[op]
        i = arithmetic.bind(left.expr, name)
        return _threshold(op, threshold, i.lo, i.hi, i), band
    same = arithmetic.common([left, right], name)
    a, b = (arithmetic.bind(v.expr, name) for v in same)
    return build.compare(op, a, b), same[0].error + same[1].error


def _threshold(op: Op, at: Fraction, lo: int, hi: int, i: Expr) -> Test:
    """``i op at`` for a rational ``at``, with an integer that the comparison's type holds."""
    at = max(Fraction(lo - 1), min(Fraction(hi + 1), at))
    down, up = math.floor(at), math.ceil(at)
    match op:
        case "<":
            return _fitting("<", i, up, lo, hi)
        case "<=":
            return _fitting("<=", i, down, lo, hi)
        case ">":
            return _fitting(">", i, down, lo, hi)
        case ">=":
            return _fitting(">=", i, up, lo, hi)
        case "==" | "!=":
            if down != up:
                return build.compare("<" if op == "==" else "<=", Const(0), Const(0))
            return _fitting(op, i, down, lo, hi)


def _fitting(op: Op, i: Expr, at: int, lo: int, hi: int) -> Test:
    held = {"<": at > hi, "<=": at >= hi, ">": at < lo, ">=": at <= lo, "==": lo == hi == at, "!=": at < lo or at > hi}
    never = {"<": at <= lo, "<=": at < lo, ">": at >= hi, ">=": at > hi, "==": at < lo or at > hi, "!=": lo == hi == at}
    if held[op] or never[op]:
        return build.compare("<=" if held[op] else "<", Const(0), Const(0))
    return build.compare(op, i, Const(at))
