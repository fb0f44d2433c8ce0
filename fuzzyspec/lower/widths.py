"""Widths: the C types of locals, and shapes of arithmetic that a narrow machine computes cheaply.

Both leave every integer what it is. A machine of 32 bits keeps its locals in whole registers: a narrower one would be
cut to its width after every operation. A machine of 8 bits takes the narrowest type that holds a value.
"""

from __future__ import annotations

from dataclasses import replace

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import CType, Expr, Function, Local
from fuzzyspec.fixed.rewrite import declared, rewritten_body
from fuzzyspec.lower.factors import with_short_factors
from fuzzyspec.lower.shapes import cheapest, plainest
from fuzzyspec.lower.strategy import Widths


def fit_widths(function: Function, widths: Widths) -> Function:
    """The function with its locals as wide as suits the machine."""
    body = function.body if widths == "words" else with_short_factors(function.body)
    types = {name: _type(lo, hi, widths) for name, (lo, hi) in declared(body).items()}

    def retype(local: Local) -> Local:
        return replace(local, ctype=types.get(local.name, local.ctype))

    def change(expr: Expr) -> Expr:
        if isinstance(expr, Local):
            return retype(expr)
        return cheapest(expr) if widths == "narrow" else plainest(expr)

    return replace(function, body=rewritten_body(body, change, retype))


def _type(lo: int, hi: int, widths: Widths) -> CType:
    if widths == "narrow":
        return build.smallest_type(lo, hi)
    return "int32" if lo < 0 else "uint32"
