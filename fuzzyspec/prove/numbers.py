"""A lemma in integers, for z3: what is true of products and quotients of any size."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fuzzyspec.prove.lemma import Expr, Num, Op, Var, Wide
from fuzzyspec.prove.ranges import COMPARISONS, Unbounded, range_of


class Numbers:
    """Puts expressions into integers. A quotient is a number of its own, with what makes it one."""

    def __init__(self, ranges: Mapping[str, Wide], effort: int) -> None:
        import z3

        self._z3, self._ranges = z3, ranges
        self._solver = z3.Solver()
        self._solver.set("rlimit", effort)
        self._known: dict[str, Any] = {}
        self._quotients: dict[Expr, Any] = {}

    def assume(self, claim: Expr) -> None:
        """Add what holds. Raises Unbounded for an operator on bits."""
        self._solver.add(self._truth(claim))

    def impossible(self) -> bool:
        """Whether nothing satisfies all of it; False also where that was not found out in time."""
        return bool(self._solver.check() == self._z3.unsat)

    def _truth(self, expr: Expr) -> Any:
        match expr:
            case Op("&&", (a, b)):
                return self._z3.And(self._truth(a), self._truth(b))
            case Op("||", (a, b)):
                return self._z3.Or(self._truth(a), self._truth(b))
            case Op("!", (a,)):
                return self._z3.Not(self._truth(a))
            case Op("<", (a, b)):
                return self._number(a) < self._number(b)
            case Op("<=", (a, b)):
                return self._number(a) <= self._number(b)
            case Op(">", (a, b)):
                return self._number(a) > self._number(b)
            case Op(">=", (a, b)):
                return self._number(a) >= self._number(b)
            case Op("==", (a, b)):
                return self._number(a) == self._number(b)
            case _:
                return self._number(expr) != 0

    def _number(self, expr: Expr) -> Any:
        match expr:
            case Num(value):
                return self._z3.IntVal(value)
            case Var(name):
                if name not in self._known:
                    lo, hi = self._ranges[name]
                    self._known[name] = self._z3.Int(name)
                    self._solver.add(self._known[name] >= lo, self._known[name] <= hi)
                return self._known[name]
            case Op("?", (a, b, c)):
                return self._z3.If(self._truth(a), self._number(b), self._number(c))
            case Op("!=", (a, b)):
                return self._z3.If(self._number(a) != self._number(b), 1, 0)
            case Op(op, _) if op in COMPARISONS:
                return self._z3.If(self._truth(expr), 1, 0)
            case Op("+", (a, b)):
                return self._number(a) + self._number(b)
            case Op("-", (a, b)):
                return self._number(a) - self._number(b)
            case Op("neg", (a,)):
                return -self._number(a)
            case Op("*", (a, b)):
                return self._number(a) * self._number(b)
            case Op("<<", (a, Num(by))):
                return self._number(a) * 2**by
            case Op(">>", (a, Num(by))):
                return self._quotient(a, Num(2**by))
            case Op("/", (a, b)) if range_of(a, self._ranges)[0] >= 0 and range_of(b, self._ranges)[0] >= 0:
                return self._quotient(a, b)
            case Op("%", (a, b)) if range_of(a, self._ranges)[0] >= 0 and range_of(b, self._ranges)[0] >= 0:
                return self._number(a) - self._quotient(a, b) * self._number(b)
            case Op("&", (a, Num(mask))) if mask & (mask + 1) == 0 and range_of(a, self._ranges)[0] >= 0:
                return self._number(a) - self._quotient(a, Num(mask + 1)) * (mask + 1)
            case Op(op, (a,)) if op.startswith("wrap"):
                number, top = self._number(a), 2 ** int(op[4:])
                lo, hi = range_of(a, self._ranges)
                if lo >= 0 and hi < top:
                    return number
                return self._z3.If(self._z3.And(number >= 0, number < top), number, number % top)
            case Op(op, (a,)) if op.startswith("sign"):
                lo, hi = range_of(a, self._ranges)
                if -(2 ** (int(op[4:]) - 1)) <= lo and hi < 2 ** (int(op[4:]) - 1):
                    return self._number(a)
                raise Unbounded(op)
            case Op(op, _):
                raise Unbounded(op)

    def _quotient(self, a: Expr, b: Expr) -> Any:
        """``floor(a / b)``: ``b q <= a < b q + b``, unless ``b`` is 0."""
        whole = Op("/", (a, b))
        if whole not in self._quotients:
            quotient = self._z3.Int(f"quotient#{len(self._quotients)}")
            top, bottom = self._number(a), self._number(b)
            self._solver.add(
                self._z3.Implies(bottom != 0, self._z3.And(bottom * quotient <= top, top < bottom * quotient + bottom))
            )
            self._quotients[whole] = quotient
        return self._quotients[whole]
