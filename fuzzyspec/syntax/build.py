"""From the grammar's rules to the tree: one function for each rule or alias, named as there.

A builder takes the children that the grammar keeps (tokens and nodes) and the span of the whole.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.syntax import tree
from fuzzyspec.syntax.tokens import Token

Node = Any
"""A token or whatever a builder made; what stands where is the grammar's business."""
Builder = Callable[[list[Any], Span], Node]

BUILDERS: dict[str, Builder] = {}


def _builds(builder: Builder) -> Builder:
    """Enters a builder under its name without the underscore."""
    BUILDERS[builder.__name__.removeprefix("_")] = builder
    return builder


@dataclass(frozen=True, slots=True)
class _Test:
    expr: tree.Expr


@dataclass(frozen=True, slots=True)
class _Fallback:
    expr: tree.Expr


def _name(token: Token) -> tree.Name:
    return tree.Name(token.text, Span(token.start, token.start if token.made else token.start + len(token.text)))


def _unit(token: Token) -> tree.UnitExpr:
    factors: list[tuple[str, int]] = []
    for slash, symbol, power in re.findall(r"([*/]?)(\w+|%|\?)(?:\^(-?\d+))?", token.text):
        exponent = int(power or 1)
        factors.append((symbol, -exponent if slash == "/" else exponent))
    return tree.UnitExpr(tuple(factors), token.span)


def _unit_of(children: list[Any]) -> tree.UnitExpr | None:
    last = children[-1]
    return _unit(last) if isinstance(last, Token) else None


def _raw_of(children: list[Any]) -> tree.RawClause | None:
    return next((c for c in children if isinstance(c, tree.RawClause)), None)


# --- the file --------------------------------------------------------------------------------


@_builds
def _start(children: list[Any], span: Span) -> tree.Module:
    name = children[0] if children and isinstance(children[0], tree.Name) else None
    return tree.Module(name, tuple(children[1:] if name else children), span)


@_builds
def _header(children: list[Any], span: Span) -> tree.Name:
    return _name(children[0])


@_builds
def _unit_decl(children: list[Any], span: Span) -> tree.UnitDecl:
    return tree.UnitDecl(_name(children[0]), children[1], span)


@_builds
def _param(children: list[Any], span: Span) -> tree.Param:
    return tree.Param(_name(children[0]), children[1], span)


# --- controllers -----------------------------------------------------------------------------


@_builds
def _controller(children: list[Any], span: Span) -> tree.ControllerDecl:
    return tree.ControllerDecl(_name(children[0]), tuple(children[1:]), span)


@_builds
def _input_decl(children: list[Any], span: Span) -> tree.VariableDecl:
    return tree.VariableDecl("input", children[0], children[1], _raw_of(children), children[-1], span)


@_builds
def _output_decl(children: list[Any], span: Span) -> tree.VariableDecl:
    return tree.VariableDecl("output", children[0], children[1], _raw_of(children), children[-1], span)


@_builds
def _names(children: list[Any], span: Span) -> tuple[tree.Name, ...]:
    return tuple(_name(c) for c in children)


@_builds
def _range(children: list[Any], span: Span) -> tree.Range:
    return tree.Range(children[0], children[1], _unit_of(children), span)


@_builds
def _raw_plain(children: list[Any], span: Span) -> tree.RawClause:
    return tree.RawClause(_name(children[0]), None, None, span)


@_builds
def _raw_step(children: list[Any], span: Span) -> tree.RawClause:
    return tree.RawClause(_name(children[0]), children[1], None, span)


@_builds
def _raw_counts(children: list[Any], span: Span) -> tree.RawClause:
    return tree.RawClause(_name(children[0]), None, (children[1], children[-1]), span)


@_builds
def _terms(children: list[Any], span: Span) -> tuple[tree.Member, ...]:
    return tuple(children)


@_builds
def _partition(children: list[Any], span: Span) -> tree.Partition:
    return tree.Partition(tuple(children), False, span)


@_builds
def _partition_full(children: list[Any], span: Span) -> tree.Partition:
    return tree.Partition(tuple(children), True, span)


@_builds
def _singletons(children: list[Any], span: Span) -> tree.Singletons:
    return tree.Singletons(tuple(children), span)


@_builds
def _even_term(children: list[Any], span: Span) -> tree.PlacedTerm:
    return tree.PlacedTerm(_name(children[0]), None)


@_builds
def _placed_term(children: list[Any], span: Span) -> tree.PlacedTerm:
    return tree.PlacedTerm(_name(children[0]), children[1])


@_builds
def _term(children: list[Any], span: Span) -> tree.TermDecl:
    return tree.TermDecl(_name(children[0]), _name(children[1]), tuple(children[2:]), span)


@_builds
def _otherwise_value(children: list[Any], span: Span) -> tree.OtherwiseClause:
    return tree.OtherwiseClause(children[0], False, span)


@_builds
def _otherwise_hold(children: list[Any], span: Span) -> tree.OtherwiseClause:
    return tree.OtherwiseClause(children[0], True, span)


# --- rules -----------------------------------------------------------------------------------


@_builds
def _table(children: list[Any], span: Span) -> tree.Table:
    outputs, inputs, *body = children
    header_row = body[0] if not isinstance(body[0], tree.TableRow) else ()
    rows = tuple(r for r in body if isinstance(r, tree.TableRow))
    return tree.Table(outputs, inputs, header_row, rows, span)


@_builds
def _columns(children: list[Any], span: Span) -> tuple[tree.Name, ...]:
    return tuple(_name(c) for c in children)


@_builds
def _row(children: list[Any], span: Span) -> tree.TableRow:
    return tree.TableRow((_name(children[0]),), tuple(children[1:]), span)


@_builds
def _row_many(children: list[Any], span: Span) -> tree.TableRow:
    return tree.TableRow(children[0], tuple(children[1:]), span)


@_builds
def _entry(children: list[Any], span: Span) -> tuple[tree.Name, ...]:
    return tuple(_name(c) for c in children)


@_builds
def _behavior(children: list[Any], span: Span) -> tree.BehaviorDecl:
    return tree.BehaviorDecl(_name(children[0]), children[1], tuple(children[2:]), span)


@_builds
def _rules(children: list[Any], span: Span) -> tree.RulesBlock:
    return tree.RulesBlock(tuple(children), span)


@_builds
def _rule(children: list[Any], span: Span) -> tree.Rule:
    return tree.Rule(children[0], tuple(children[1:]), None, span)


@_builds
def _rule_weighted(children: list[Any], span: Span) -> tree.Rule:
    return tree.Rule(children[0], tuple(children[1:-1]), children[-1], span)


@_builds
def _consequent(children: list[Any], span: Span) -> tree.Consequent:
    return tree.Consequent(_name(children[0]), _name(children[1]), span)


@_builds
def _cond_or(children: list[Any], span: Span) -> tree.Antecedent:
    return tree.Antecedent("or", tuple(children), span)


@_builds
def _cond_and(children: list[Any], span: Span) -> tree.Antecedent:
    return tree.Antecedent("and", tuple(children), span)


@_builds
def _cond_negated(children: list[Any], span: Span) -> tree.Antecedent:
    return tree.Antecedent("not", tuple(children), span)


@_builds
def _cond_group(children: list[Any], span: Span) -> tree.Condition:
    return children[0]  # type: ignore[no-any-return]


@_builds
def _is_term(children: list[Any], span: Span) -> tree.Is:
    return tree.Is(_name(children[0]), (_name(children[1]),), False, span)


@_builds
def _is_not_term(children: list[Any], span: Span) -> tree.Is:
    return tree.Is(_name(children[0]), (_name(children[1]),), True, span)


@_builds
def _in_terms(children: list[Any], span: Span) -> tree.Is:
    return tree.Is(_name(children[0]), children[1], False, span)


@_builds
def _not_in_terms(children: list[Any], span: Span) -> tree.Is:
    return tree.Is(_name(children[0]), children[1], True, span)


@_builds
def _infer(children: list[Any], span: Span) -> tree.InferBlock:
    return tree.InferBlock(tuple(children), span)


@_builds
def _setting(children: list[Any], span: Span) -> tree.Setting:
    return tree.Setting(_name(children[0]), _name(children[1]), span)


@_builds
def _fires(children: list[Any], span: Span) -> tree.FiresAt:
    return tree.FiresAt(children[0], span)


# --- systems ---------------------------------------------------------------------------------


@_builds
def _system(children: list[Any], span: Span) -> tree.SystemDecl:
    items: list[tree.SystemItem] = []
    for child in children[1:]:
        if isinstance(child, list):
            items.extend(child)
        else:
            items.append(child)
    return tree.SystemDecl(_name(children[0]), tuple(items), span)


@_builds
def _system_input(children: list[Any], span: Span) -> list[tree.SystemInput]:
    return [tree.SystemInput(name, children[1], _raw_of(children), span) for name in children[0]]


@_builds
def _list_input(children: list[Any], span: Span) -> tree.ListInput:
    return tree.ListInput(_name(children[0]), children[1], tuple(children[2:]), span)


@_builds
def _field(children: list[Any], span: Span) -> tree.SystemInput:
    return tree.SystemInput(_name(children[0]), children[1], _raw_of(children), span)


@_builds
def _let(children: list[Any], span: Span) -> tree.Let:
    return tree.Let(children[0], children[1], span)


@_builds
def _target(children: list[Any], span: Span) -> tree.Ref:
    return tree.Ref(tuple(_name(c) for c in children), span)


@_builds
def _for_each(children: list[Any], span: Span) -> tree.ForEach:
    return tree.ForEach(_name(children[0]), _name(children[1]), tuple(children[2:]), span)


@_builds
def _system_output(children: list[Any], span: Span) -> tree.SystemOutput:
    ranged = next((c for c in children if isinstance(c, tree.Range)), None)
    return tree.SystemOutput(_name(children[0]), ranged, _raw_of(children), children[-1], span)


# --- expressions -----------------------------------------------------------------------------


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
    return tree.Number(Fraction(children[0].text), _unit(children[1]), span)


@_builds
def _ref(children: list[Any], span: Span) -> tree.Ref:
    return tree.Ref(tuple(_name(c) for c in children), span)


@_builds
def _call(children: list[Any], span: Span) -> tree.Call:
    return tree.Call(_name(children[0]), tuple(children[1:]), None, span)


@_builds
def _call_field(children: list[Any], span: Span) -> tree.Call:
    return tree.Call(_name(children[0]), tuple(children[1:-1]), _name(children[-1]), span)


@_builds
def _group(children: list[Any], span: Span) -> tree.Expr:
    return children[0]  # type: ignore[no-any-return]


@_builds
def _positional(children: list[Any], span: Span) -> tree.Argument:
    return tree.Argument(None, children[0], span)


@_builds
def _named(children: list[Any], span: Span) -> tree.Argument:
    return tree.Argument(_name(children[0]), children[1], span)


@_builds
def _fold(children: list[Any], span: Span) -> tree.Fold:
    kind, body, item, over, *rest = children
    test = next((c.expr for c in rest if isinstance(c, _Test)), None)
    fallback = next((c.expr for c in rest if isinstance(c, _Fallback)), None)
    return tree.Fold(_name(kind), body, _name(item), _name(over), test, fallback, span)


@_builds
def _fold_test(children: list[Any], span: Span) -> _Test:
    return _Test(children[0])


@_builds
def _fold_otherwise(children: list[Any], span: Span) -> _Fallback:
    return _Fallback(children[0])
