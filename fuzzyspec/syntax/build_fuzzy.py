"""Builders of declarations, variables, terms, rules and budgets."""

from __future__ import annotations

from typing import Any

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.syntax import tree
from fuzzyspec.syntax.builders import Builder, entering, name_of, raw_among, trailing_unit
from fuzzyspec.syntax.tokens import MISSING

BUILDERS: dict[str, Builder] = {}
_builds = entering(BUILDERS)


@_builds
def _start(children: list[Any], span: Span) -> tree.Module:
    name = children[0] if children and isinstance(children[0], tree.Name) else None
    return tree.Module(name, tuple(children[1:] if name else children), span)


@_builds
def _header(children: list[Any], span: Span) -> tree.Name:
    return name_of(children[0])


@_builds
def _unit_decl(children: list[Any], span: Span) -> tree.UnitDecl:
    return tree.UnitDecl(name_of(children[0]), children[1], span)


@_builds
def _param(children: list[Any], span: Span) -> tree.Param:
    return tree.Param(name_of(children[0]), children[1], span)


@_builds
def _controller(children: list[Any], span: Span) -> tree.ControllerDecl:
    return tree.ControllerDecl(name_of(children[0]), tuple(children[1:]), span)


@_builds
def _input_decl(children: list[Any], span: Span) -> tree.VariableDecl:
    return tree.VariableDecl("input", children[0], children[1], raw_among(children), children[-1], span)


@_builds
def _output_decl(children: list[Any], span: Span) -> tree.VariableDecl:
    return tree.VariableDecl("output", children[0], children[1], raw_among(children), children[-1], span)


@_builds
def _names(children: list[Any], span: Span) -> tuple[tree.Name, ...]:
    return tuple(name_of(c) for c in children)


@_builds
def _range(children: list[Any], span: Span) -> tree.Range:
    return tree.Range(children[0], children[1], trailing_unit(children), span)


@_builds
def _raw_plain(children: list[Any], span: Span) -> tree.RawClause:
    return tree.RawClause(name_of(children[0]), None, None, span)


@_builds
def _raw_step(children: list[Any], span: Span) -> tree.RawClause:
    return tree.RawClause(name_of(children[0]), children[1], None, span)


@_builds
def _raw_counts(children: list[Any], span: Span) -> tree.RawClause:
    return tree.RawClause(name_of(children[0]), None, (children[1], children[-1]), span)


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
    return tree.PlacedTerm(name_of(children[0]), None)


@_builds
def _placed_term(children: list[Any], span: Span) -> tree.PlacedTerm:
    return tree.PlacedTerm(name_of(children[0]), children[1])


@_builds
def _term(children: list[Any], span: Span) -> tree.TermDecl:
    return tree.TermDecl(name_of(children[0]), name_of(children[1]), tuple(children[2:]), span)


@_builds
def _otherwise_value(children: list[Any], span: Span) -> tree.OtherwiseClause:
    return tree.OtherwiseClause(children[0], False, span)


@_builds
def _otherwise_hold(children: list[Any], span: Span) -> tree.OtherwiseClause:
    return tree.OtherwiseClause(children[0], True, span)


@_builds
def _table(children: list[Any], span: Span) -> tree.Table:
    outputs, inputs, *body = children
    header_row = body[0] if not isinstance(body[0], tree.TableRow) else ()
    rows = tuple(r for r in body if isinstance(r, tree.TableRow))
    return tree.Table(outputs, inputs, header_row, rows, span)


@_builds
def _columns(children: list[Any], span: Span) -> tuple[tree.Name, ...]:
    return tuple(name_of(c) for c in children)


@_builds
def _row(children: list[Any], span: Span) -> tree.TableRow:
    return tree.TableRow((name_of(children[0]),), tuple(children[1:]), span)


@_builds
def _row_many(children: list[Any], span: Span) -> tree.TableRow:
    return tree.TableRow(children[0], tuple(children[1:]), span)


@_builds
def _entry(children: list[Any], span: Span) -> tuple[tree.Name, ...]:
    return tuple(name_of(c) for c in children)


@_builds
def _behavior(children: list[Any], span: Span) -> tree.BehaviorDecl:
    return tree.BehaviorDecl(name_of(children[0]), children[1], tuple(children[2:]), span)


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
    return tree.Consequent(name_of(children[0]), name_of(children[1]), span)


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
    return tree.Is(name_of(children[0]), (name_of(children[1]),), False, span)


@_builds
def _is_not_term(children: list[Any], span: Span) -> tree.Is:
    return tree.Is(name_of(children[0]), (name_of(children[1]),), True, span)


@_builds
def _in_terms(children: list[Any], span: Span) -> tree.Is:
    return tree.Is(name_of(children[0]), children[1], False, span)


@_builds
def _not_in_terms(children: list[Any], span: Span) -> tree.Is:
    return tree.Is(name_of(children[0]), children[1], True, span)


@_builds
def _infer(children: list[Any], span: Span) -> tree.InferBlock:
    return tree.InferBlock(tuple(children), span)


@_builds
def _setting(children: list[Any], span: Span) -> tree.Setting:
    return tree.Setting(name_of(children[0]), name_of(children[1]), span)


@_builds
def _fires(children: list[Any], span: Span) -> tree.FiresAt:
    return tree.FiresAt(children[0], span)


@_builds
def _budget(children: list[Any], span: Span) -> tree.BudgetBlock:
    return tree.BudgetBlock(tuple(children), span)


@_builds
def _limit(children: list[Any], span: Span) -> tree.Limit:
    return tree.Limit(name_of(children[0]), name_of(children[1]), children[2], None, span)


@_builds
def _limit_on(children: list[Any], span: Span) -> tree.Limit:
    return tree.Limit(name_of(children[0]), name_of(children[1]), children[2], children[3], span)


@_builds
def _machine(children: list[Any], span: Span) -> tree.Name:
    text = "-".join(c.text for c in children)
    return tree.Name(MISSING if any(c.made for c in children) else text, span)


@_builds
def _machine_plus(children: list[Any], span: Span) -> tree.Name:
    return tree.Name("-".join(c.text for c in children) + "+", span)
