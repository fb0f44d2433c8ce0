"""Short factors: a local that only multiplies, and holds ``x << k``, holds the short x instead.

Its products are shifted after they are taken (``lower.shapes``), so that they take a short multiplication each.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from fuzzyspec.fixed.program import Binary, Branch, Const, Define, Each, Expr, Local, Loop, Stmt
from fuzzyspec.fixed.prune import expressions, nodes, statements
from fuzzyspec.fixed.rewrite import rewritten_body
from fuzzyspec.lower.shapes import SHORT

Counts = dict[str, int]
"""By how much the values of such locals are shifted, by the local's name."""


def with_short_factors(body: tuple[Stmt, ...]) -> tuple[Stmt, ...]:
    """The statements with such locals held short; every other value is what it was."""
    counts = _counts(body)

    def change(expr: Expr) -> Expr:
        if isinstance(expr, Local) and expr.name in counts:
            count = counts[expr.name]
            return Binary("<<", _short(expr, count), Const(count), expr.lo, expr.hi)
        return expr

    return rewritten_body(_held_short(body, counts), change, lambda local: local)


def _counts(body: tuple[Stmt, ...]) -> Counts:
    uses: Counter[str] = Counter()
    factors: Counter[str] = Counter()
    for node in (n for e in expressions(body) for n in nodes(e)):
        if isinstance(node, Local):
            uses[node.name] += 1
        elif isinstance(node, Binary) and node.op == "*":
            factors.update(side.name for side in (node.left, node.right) if isinstance(side, Local))
    found: Counts = {}
    for statement in statements(body):
        match statement:
            case Define(local, Binary("<<", x, Const(count)), True) if x.hi <= SHORT < local.hi:
                if uses[local.name] == factors[local.name]:
                    found[local.name] = count
            case _:
                pass
    return found


def _held_short(body: tuple[Stmt, ...], counts: Counts) -> tuple[Stmt, ...]:
    out: list[Stmt] = []
    for statement in body:
        match statement:
            case Define(local, Binary("<<", x), True) if local.name in counts:
                out.append(Define(_short(local, counts[local.name]), x, True))
            case Loop() | Each():
                out.append(replace(statement, body=_held_short(statement.body, counts)))
            case Branch(test, then, other):
                out.append(Branch(test, _held_short(then, counts), _held_short(other, counts)))
            case _:
                out.append(statement)
    return tuple(out)


def _short(local: Local, count: int) -> Local:
    return replace(local, lo=local.lo >> count, hi=local.hi >> count)
