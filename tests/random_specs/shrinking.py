"""Makes a spec small that something is wrong with: declarations, inputs, terms and rules are left out, expressions
replaced by their parts, numbers by shorter ones, as long as the same is wrong with what remains."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from fractions import Fraction

from fuzzyspec.diagnostics.diagnostic import Source, Span
from fuzzyspec.syntax import parse, tree
from tests.random_specs.narrowing import Gone, narrowed
from tests.random_specs.spec_numbers import number

_PARTS = (
    *(tree.ControllerDecl, tree.SystemDecl, tree.UnitDecl, tree.Param, tree.VariableDecl, tree.Table),
    *(tree.BehaviorDecl, tree.RulesBlock, tree.InferBlock, tree.FiresAt, tree.BudgetBlock, tree.Limit, tree.Setting),
    *(tree.Rule, tree.Consequent, tree.TermDecl, tree.OtherwiseClause, tree.RawClause, tree.Let, tree.ForEach),
    *(tree.SystemInput, tree.ListInput, tree.SystemOutput, tree.Argument),
)  # fmt: skip
"""What can be left out, with a comma beside it."""


def smallest(text: str, fails: Callable[[str], bool], most: int = 400) -> str:
    """The smallest text found for which ``fails`` still holds, after at most so many questions."""
    best = re.sub(r"#[^\n]*", "", text)
    if not fails(best):
        return text
    asked, before = 1, ""
    while best != before:
        before, at = best, 0
        while asked < most:
            tries = [t for t in simpler(best) if _size(t) < _size(best)]
            if at >= len(tries):
                break
            asked += 1
            if fails(tries[at]):
                best = tries[at]
            else:
                at += 1
    return re.sub(r"\n(\s*\n)+", "\n", best)


def simpler(text: str) -> Iterator[str]:
    """Texts with one thing less each, what takes most away first. Not all of them are specs."""
    module, told = parse(Source("spec.fz", text))
    if told:
        return
    nodes = list(_nodes(module))
    for node in nodes:
        if isinstance(node, _PARTS):
            yield _cut(text, node.span)
    for c in module.items:
        if isinstance(c, tree.ControllerDecl):
            yield from (narrowed(text, module, c, gone) for gone in _losses(c))
    for node in nodes:
        if isinstance(node, tree.Expr) and not isinstance(node, tree.Number):
            for shorter in ("0", *(_of(text, inner.span) for inner in _nodes(node) if isinstance(inner, tree.Expr))):
                yield _put(text, node.span, shorter)
        elif isinstance(node, tree.Antecedent):
            yield from (_put(text, node.span, _of(text, part.span)) for part in node.operands)
        elif isinstance(node, tree.Number):
            unit = "" if node.unit is None else _of(text, node.unit.span)
            values = {Fraction(0), Fraction(1), *(Fraction(round(node.value * 10**d), 10**d) for d in (0, 1, 2))}
            for value in sorted(values, key=lambda v: (abs(v - node.value), v), reverse=True):
                yield _put(text, node.span, f"{number(value)} {unit}".rstrip())


def _losses(c: tree.ControllerDecl) -> Iterator[Gone]:
    """Variables and terms of a controller, one at a time."""
    for declared in c.items:
        if not isinstance(declared, tree.VariableDecl):
            continue
        names = [n.text for n in declared.names]
        yield from (Gone(n, None) for n in names)
        terms = [
            t.name.text for m in declared.members if isinstance(m, tree.Partition | tree.Singletons) for t in m.terms
        ]
        terms += [m.name.text for m in declared.members if isinstance(m, tree.TermDecl)]
        if len(names) == 1 and len(terms) > 2:
            yield from (Gone(names[0], t) for t in terms)


def _nodes(node: object) -> Iterator[object]:
    """A node and all below, from the top."""
    if isinstance(node, tuple):
        for part in node:
            yield from _nodes(part)
    elif is_dataclass(node) and not isinstance(node, Span | tree.Name | tree.UnitExpr):
        yield node
        for f in fields(node):
            yield from _nodes(getattr(node, f.name))


def _of(text: str, span: Span) -> str:
    """What stands there, safe within any expression."""
    part = text[span.start : span.end]
    return part if re.fullmatch(r"[\w.]+|\(.*\)", part, re.DOTALL) else f"({part})"


def _put(text: str, span: Span, new: str) -> str:
    return text[: span.start] + new + text[span.end :]


def _cut(text: str, span: Span) -> str:
    """Without what stands there, nor the comma behind or before it."""
    before, behind = text[: span.start], text[span.end :]
    if re.match(r"\s*,", behind):
        behind = behind.split(",", 1)[1]
    elif re.search(r",\s*\Z", before):
        before = before.rstrip()[:-1]
    return before + behind


def _size(text: str) -> tuple[int, int]:
    """Characters that tell something, and the sum of all digits."""
    told = "".join(text.split())
    return len(told), sum(int(c) for c in told if c in "0123456789")
