"""A lemma tried at every value, where but one variable of few enough values is free."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from fuzzyspec.prove.lemma import Expr, Num, Op, Var, Wide, variables
from fuzzyspec.prove.ranges import Unbounded, range_of

MOST = 1 << 25
"""Values that are tried at most."""
BLOCK = 1 << 20
Column = npt.NDArray[Any]


class Exhaustion:
    """Collects equations and conditions; the one value that none of them defines is tried."""

    def __init__(self, ranges: Mapping[str, Wide], effort: int) -> None:
        self._ranges = ranges
        self._most = effort
        self._defined: dict[str, Expr] = {}
        self._conditions: list[Expr] = []

    def assume(self, claim: Expr) -> None:
        """Add what holds."""
        match claim:
            case Op("==", (Var(name), expr)) if name not in self._defined:
                self._defined[name] = expr
            case _:
                self._conditions.append(claim)

    def impossible(self) -> bool:
        """Whether no value satisfies the last condition, which the others only make harder to."""
        wanted = self._conditions[-1]
        order: list[str] = []
        free = self._free(wanted, order)
        if free is None:
            return False
        lo, hi = self._ranges[free]
        if hi - lo + 1 > self._most:
            return False
        known = [c for c in self._conditions[:-1] if variables(c) <= {free, *order}]
        for start in range(lo, hi + 1, BLOCK):
            values: dict[str, Column] = {free: np.arange(start, min(start + BLOCK, hi + 1), dtype=np.int64)}
            try:
                for name in order:
                    values[name] = self._column(self._defined[name], values)
                holds = self._column(wanted, values) != 0
                for condition in known:
                    holds = holds & (self._column(condition, values) != 0)
            except Unbounded:
                return False
            if np.any(holds):
                return False
        return True

    def _free(self, expr: Expr, order: list[str]) -> str | None:
        """The only value that nothing defines; the others in the order in which they follow from it."""
        free: set[str] = set()

        def visit(name: str) -> None:
            if name in order or name in free:
                return
            if name not in self._defined:
                free.add(name)
                return
            for inner in sorted(variables(self._defined[name])):
                visit(inner)
            order.append(name)

        for name in sorted(variables(expr)):
            visit(name)
        return free.pop() if len(free) == 1 else None

    def _column(self, expr: Expr, values: Mapping[str, Column]) -> Column:
        lo, hi = range_of(expr, self._ranges)
        if lo < -(2**62) or hi >= 2**62:
            raise Unbounded(str(expr))
        match expr:
            case Num(value):
                return np.asarray(value, dtype=np.int64)
            case Var(name):
                return values[name]
            case Op(op, args):
                of = [self._column(a, values) for a in args]
                return _applied(op, of)


def _applied(op: str, of: list[Column]) -> Column:
    match op:
        case "+":
            return np.add(*of)
        case "-":
            return np.subtract(*of)
        case "*":
            return np.multiply(*of)
        case "<<":
            return np.left_shift(*of)
        case ">>":
            return np.right_shift(*of)
        case "&":
            return np.bitwise_and(*of)
        case "<":
            return np.less(*of)
        case "<=":
            return np.less_equal(*of)
        case ">":
            return np.greater(*of)
        case ">=":
            return np.greater_equal(*of)
        case "==":
            return np.equal(*of)
        case "!":
            return np.equal(of[0], 0)
        case "&&":
            return np.logical_and(*of)
        case "||":
            return np.logical_or(*of)
        case "?":
            return np.where(of[0], of[1], of[2])
        case "/" if np.all(of[0] >= 0) and np.all(of[1] > 0):
            return np.floor_divide(*of)
        case "neg":
            return np.negative(of[0])
        case _ if op.startswith("wrap"):
            return np.asarray(of[0] % 2 ** int(op[4:]))
        case _:
            raise Unbounded(op)
