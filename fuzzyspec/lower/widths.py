"""Widths: the C types of locals, and shapes of arithmetic that a narrow machine computes cheaply.

Both leave every integer what it is. A machine of 32 bits keeps its locals in whole registers: a narrower one would be
cut to its width after every operation; so does an array that is no longer than a pair of degrees. A machine of 8 bits
takes the narrowest type that holds a value.
"""

from __future__ import annotations

from dataclasses import replace

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    AssignElement,
    Branch,
    Compare,
    CType,
    DefineArray,
    Each,
    Element,
    Expr,
    Function,
    Local,
    Loop,
    Stmt,
)
from fuzzyspec.fixed.prune import statements
from fuzzyspec.fixed.rewrite import declared, rewritten_body
from fuzzyspec.lower.factors import with_short_factors
from fuzzyspec.lower.shapes import cheapest, plainest, without_constant_of_two
from fuzzyspec.lower.strategy import Widths

PAIR = 2
"""Longer arrays cost more in room on the stack, and in the steps to it, than their cuts do."""


def fit_widths(function: Function, widths: Widths) -> Function:
    """The function with its locals as wide as suits the machine."""
    body = function.body if widths == "words" else with_short_factors(function.body)
    types = {name: _type(lo, hi, widths) for name, (lo, hi) in declared(body).items()}

    def retype(local: Local) -> Local:
        return replace(local, ctype=types.get(local.name, local.ctype))

    def change(expr: Expr) -> Expr:
        if isinstance(expr, Local):
            return retype(expr)
        if isinstance(expr, Element) and not expr.table and expr.array in pairs:
            return replace(expr, ctype="uint32")
        return cheapest(expr) if widths == "narrow" else plainest(expr)

    arrays = [s for s in statements(body) if isinstance(s, DefineArray)]
    small = (a.name for a in arrays if a.size <= PAIR and not a.ctype.startswith("int"))
    pairs = frozenset(small) if widths == "words" else frozenset[str]()
    fitted = rewritten_body(body, change, retype)
    return replace(function, body=fitted if widths == "narrow" else _with_words(fitted, pairs))


def _with_words(body: tuple[Stmt, ...], pairs: frozenset[str]) -> tuple[Stmt, ...]:
    """The statements with these arrays as words, and with branches as they ask least of a word."""
    out: list[Stmt] = []
    for s in body:
        match s:
            case DefineArray(name) | AssignElement(name) if name in pairs:
                out.append(replace(s, ctype="uint32"))
            case Loop() | Each():
                out.append(replace(s, body=_with_words(s.body, pairs)))
            case Branch():
                test = without_constant_of_two(s.test) if isinstance(s.test, Compare) else s.test
                out.append(Branch(test, _with_words(s.then, pairs), _with_words(s.other, pairs)))
            case _:
                out.append(s)
    return tuple(out)


def _type(lo: int, hi: int, widths: Widths) -> CType:
    if widths == "narrow":
        return build.smallest_type(lo, hi)
    return "int32" if lo < 0 else "uint32"
