"""Builders of systems and expressions."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.syntax import tree
from fuzzyspec.syntax.builders import Builder, entering, name_of, raw_among, unit_of

BUILDERS: dict[str, Builder] = {}
_builds = entering(BUILDERS)


@dataclass(frozen=True, slots=True)
class _Test:
    expr: tree.Expr


@dataclass(frozen=True, slots=True)
class _Fallback:
    expr: tree.Expr


@_builds
def _system(children: list[Any], span: Span) -> tree.SystemDecl:
    items: list[tree.SystemItem] = []
    for child in children[1:]:
        if isinstance(child, list):
            items.extend(child)
        else:
            items.append(child)
    return tree.SystemDecl(name_of(children[0]), tuple(items), span)


@_builds
def _system_input(children: list[Any], span: Span) -> list[tree.SystemInput]:
    return [tree.SystemInput(name, children[1], raw_among(children), span) for name in children[0]]


@_builds
def _list_input(children: list[Any], span: Span) -> tree.ListInput:
    return tree.ListInput(name_of(children[0]), children[1], tuple(children[2:]), span)


@_builds
def _field(children: list[Any], span: Span) -> tree.SystemInput:
    return tree.SystemInput(name_of(children[0]), children[1], raw_among(children), span)


@_builds
def _let(children: list[Any], span: Span) -> tree.Let:
    return tree.Let(children[0], children[1], span)


@_builds
def _target(children: list[Any], span: Span) -> tree.Ref:
    return tree.Ref(tuple(name_of(c) for c in children), span)


@_builds
def _for_each(children: list[Any], span: Span) -> tree.ForEach:
    return tree.ForEach(name_of(children[0]), name_of(children[1]), tuple(children[2:]), span)


@_builds
def _system_output(children: list[Any], span: Span) -> tree.SystemOutput:
    ranged = next((c for c in children if isinstance(c, tree.Range)), None)
    return tree.SystemOutput(name_of(children[0]), ranged, raw_among(children), children[-1], span)


@_builds
def _otherwise(children: list[Any], span: Span) -> tree.Otherwise:
    return tree.Otherwise(children[0], children[1], span)


@_builds
def _conditional(children: list[Any], span: Span) -> tree.Conditional:
    then, test, other = children
    return tree.Conditional(test, then, other, span)


@_builds
def _logic_or(children: list[Any], span: Span) -> tree.Logic:
    return tree.Logic("or", tuple(children), span)


@_builds
def _logic_and(children: list[Any], span: Span) -> tree.Logic:
    return tree.Logic("and", tuple(children), span)


@_builds
def _logic_negated(children: list[Any], span: Span) -> tree.Logic:
    return tree.Logic("not", tuple(children), span)


@_builds
def _compare(children: list[Any], span: Span) -> tree.Compare:
    return tree.Compare(tuple(children[::2]), tuple(c.text for c in children[1::2]), span)


@_builds
def _in_range(children: list[Any], span: Span) -> tree.InRange:
    within: tree.Range = children[1]
    return tree.InRange(children[0], within.lo, within.hi, within.unit, span)


@_builds
def _not_in_range(children: list[Any], span: Span) -> tree.Logic:
    return tree.Logic("not", (_in_range(children, span),), span)


@_builds
def _add(children: list[Any], span: Span) -> tree.Binary:
    return tree.Binary("+", children[0], children[1], span)


@_builds
def _sub(children: list[Any], span: Span) -> tree.Binary:
    return tree.Binary("-", children[0], children[1], span)


@_builds
def _mul(children: list[Any], span: Span) -> tree.Binary:
    return tree.Binary("*", children[0], children[1], span)


@_builds
def _div(children: list[Any], span: Span) -> tree.Binary:
    return tree.Binary("/", children[0], children[1], span)


@_builds
def _negate(children: list[Any], span: Span) -> tree.Unary:
    return tree.Unary("-", children[0], span)


@_builds
def _number(children: list[Any], span: Span) -> tree.Number:
    return tree.Number(Fraction(children[0].text), None, span)


@_builds
def _quantity(children: list[Any], span: Span) -> tree.Number:
    return tree.Number(Fraction(children[0].text), unit_of(children[1]), span)


@_builds
def _ref(children: list[Any], span: Span) -> tree.Ref:
    return tree.Ref(tuple(name_of(c) for c in children), span)


@_builds
def _call(children: list[Any], span: Span) -> tree.Call:
    return tree.Call(name_of(children[0]), tuple(children[1:]), None, span)


@_builds
def _call_field(children: list[Any], span: Span) -> tree.Call:
    return tree.Call(name_of(children[0]), tuple(children[1:-1]), name_of(children[-1]), span)


@_builds
def _group(children: list[Any], span: Span) -> tree.Expr:
    return children[0]  # type: ignore[no-any-return]


@_builds
def _positional(children: list[Any], span: Span) -> tree.Argument:
    return tree.Argument(None, children[0], span)


@_builds
def _named(children: list[Any], span: Span) -> tree.Argument:
    return tree.Argument(name_of(children[0]), children[1], span)


@_builds
def _fold(children: list[Any], span: Span) -> tree.Fold:
    kind, body, item, over, *rest = children
    test = next((c.expr for c in rest if isinstance(c, _Test)), None)
    fallback = next((c.expr for c in rest if isinstance(c, _Fallback)), None)
    return tree.Fold(name_of(kind), body, name_of(item), name_of(over), test, fallback, span)


@_builds
def _fold_test(children: list[Any], span: Span) -> _Test:
    return _Test(children[0])


@_builds
def _fold_otherwise(children: list[Any], span: Span) -> _Fallback:
    return _Fallback(children[0])
