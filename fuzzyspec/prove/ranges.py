"""The least and the greatest value of an expression, from those of its variables."""

from __future__ import annotations

from collections.abc import Mapping

from fuzzyspec.prove.lemma import Expr, Num, Op, Var, Wide

COMPARISONS = ("<", "<=", ">", ">=", "==", "!=", "&&", "||", "!")


class Unbounded(Exception):
    """An operator whose values are not known from those of its operands."""


def range_of(expr: Expr, ranges: Mapping[str, Wide]) -> Wide:
    """Bounds of an expression's value. Raises Unbounded for an operator that is not known."""
    match expr:
        case Num(value):
            return value, value
        case Var(name):
            return ranges[name]
        case Op(op, args):
            return result(op, [range_of(a, ranges) for a in args])


def result(op: str, of: list[Wide]) -> Wide:
    """Bounds of an operator's result."""
    if op in COMPARISONS:
        return 0, 1
    if op == "?":
        return min(of[1][0], of[2][0]), max(of[1][1], of[2][1])
    (a, b), (c, d) = of[0], of[-1]
    match op:
        case "+":
            return a + c, b + d
        case "-":
            return a - d, b - c
        case "neg":
            return -b, -a
        case "*":
            corners = [x * y for x in (a, b) for y in (c, d)]
            return min(corners), max(corners)
        case "/" if c > 0:
            corners = [_towards_zero(x, y) for x in (a, b) for y in (c, d)]
            return min(corners), max(corners)
        case "/" | "%" if a >= 0 and c >= 0:
            return 0, b
        case "<<" if c >= 0 and d <= 64:
            corners = [x << y for x in (a, b) for y in (c, d)]
            return min(corners), max(corners)
        case ">>" if c >= 0 and d <= 64:
            corners = [x >> y for x in (a, b) for y in (c, d)]
            return min(corners), max(corners)
        case "&" if a >= 0 and c >= 0:
            return 0, min(b, d)
        case "|" | "^" if a >= 0 and c >= 0:
            return 0, 2 ** max(b, d).bit_length() - 1
        case _ if op.startswith("wrap"):
            top = 2 ** int(op[4:]) - 1
            return (a, b) if a >= 0 and b <= top else (0, top)
        case _ if op.startswith("sign"):
            half = 2 ** (int(op[4:]) - 1)
            return (a, b) if -half <= a and b < half else (-half, half - 1)
        case _:
            raise Unbounded(op)


def _towards_zero(x: int, y: int) -> int:
    return x // y if x >= 0 else -(-x // y)
