"""The functions by which the grammar's rules become nodes of the tree, by the name of rule or alias.

A builder takes the children that the grammar keeps (tokens and nodes) and the span of the whole.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.syntax import tree
from fuzzyspec.syntax.tokens import Token

Node = Any
"""A token or whatever a builder made; what stands where is the grammar's business."""
Builder = Callable[[list[Any], Span], Node]


def entering(registry: dict[str, Builder]) -> Callable[[Builder], Builder]:
    """A decorator that enters builders into a registry under their names without the underscore."""

    def builds(builder: Builder) -> Builder:
        registry[builder.__name__.removeprefix("_")] = builder
        return builder

    return builds


def name_of(token: Token) -> tree.Name:
    """The name that a token spells."""
    return tree.Name(token.text, Span(token.start, token.start if token.made else token.start + len(token.text)))


def unit_of(token: Token) -> tree.UnitExpr:
    """A unit's factors, in the order in which they stand."""
    factors: list[tuple[str, int]] = []
    for slash, symbol, power in re.findall(r"([*/]?)(\w+|%|\?)(?:\^(-?\d+))?", token.text):
        exponent = int(power or 1)
        factors.append((symbol, -exponent if slash == "/" else exponent))
    return tree.UnitExpr(tuple(factors), token.span)


def trailing_unit(children: list[Any]) -> tree.UnitExpr | None:
    """The unit that ends a list of children, if one does."""
    last = children[-1]
    return unit_of(last) if isinstance(last, Token) else None


def raw_among(children: list[Any]) -> tree.RawClause | None:
    """The raw clause among children, if there is one."""
    return next((c for c in children if isinstance(c, tree.RawClause)), None)
