"""Sentence rules: conditions over inputs with and, or, not, and a weight."""

from __future__ import annotations

from fractions import Fraction
from typing import assert_never

from fuzzyspec.check.behaviors import Numbers, consequents
from fuzzyspec.check.rule_names import RuleNames
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label
from fuzzyspec.model.controller import And, Antecedent, Is, Not, Or, SentenceRule
from fuzzyspec.syntax import tree


def resolve_sentences(
    blocks: tuple[tree.RulesBlock, ...], names: RuleNames, numbers: Numbers
) -> tuple[SentenceRule, ...]:
    """Every rule that could be resolved, in written order; warns of duplicates and of rules that disagree."""
    found: list[SentenceRule] = []
    for block in blocks:
        for rule in block.rules:
            antecedent = _antecedent(rule.condition, names)
            sets = consequents(rule, names)
            weight = _weight(rule, names, numbers)
            if antecedent is not None and sets is not None and weight is not None:
                found.append(SentenceRule(antecedent, sets, weight, rule.span))
    _report_same_conditions(found, names)
    return tuple(found)


def _antecedent(condition: tree.Condition, names: RuleNames) -> Antecedent | None:
    match condition:
        case tree.Is():
            index = names.input(condition.variable)
            if index is None:
                return None
            terms = names.input_terms(index, condition.terms)
            if not terms:
                return None
            part = Is(index, terms)
            return Not(part) if condition.negated else part
        case tree.Antecedent():
            operands = [_antecedent(operand, names) for operand in condition.operands]
            resolved = tuple(o for o in operands if o is not None)
            if len(resolved) != len(operands):
                return None
            match condition.op:
                case "and":
                    return And(resolved)
                case "or":
                    return Or(resolved)
                case "not":
                    return Not(resolved[0])
                case _:
                    assert_never(condition.op)
        case _:
            assert_never(condition)


def _weight(rule: tree.Rule, names: RuleNames, numbers: Numbers) -> Fraction | None:
    if rule.weight is None:
        return Fraction(1)
    weight = numbers(rule.weight)
    if weight is None:
        names.broken = True
        return None
    if not 0 < weight <= 1:
        names.error(
            Diagnostic(
                "FZ321",
                "a rule's weight lies above 0 and is at most 1",
                rule.weight.span,
                label=f"is {weight}",
                help="remove the rule to give it no say; leave the weight out for a full one",
            )
        )
        return None
    return weight


def _key(antecedent: Antecedent) -> str:
    """The same for conditions that differ in order, nesting or repetition alone."""
    match antecedent:
        case Is(index, terms):
            return f"{index}:{terms}"
        case Not(operand):
            return f"not({_key(operand)})"
        case And() | Or():
            kind = type(antecedent)
            flat: set[str] = set()
            pending = list(antecedent.operands)
            while pending:
                operand = pending.pop()
                if isinstance(operand, kind):
                    pending.extend(operand.operands)
                else:
                    flat.add(_key(operand))
            return next(iter(flat)) if len(flat) == 1 else f"{kind.__name__}({', '.join(sorted(flat))})"
        case _:
            assert_never(antecedent)


def _report_same_conditions(rules: list[SentenceRule], names: RuleNames) -> None:
    """Warn where two rules with one condition say the same, or give one output two terms."""
    first: dict[tuple[str, int], tuple[SentenceRule, int]] = {}
    for rule in rules:
        key = _key(rule.antecedent)
        repeats: list[SentenceRule] = []
        for output, term in rule.consequents:
            earlier, said = first.setdefault((key, output), (rule, term))
            if earlier is rule:
                continue
            if said == term:
                repeats.append(earlier)
                continue
            variable = names.outputs[output]
            names.tell(
                Diagnostic(
                    "FZ322",
                    f"two rules with one condition give output `{variable.name}` different terms",
                    rule.span,
                    label=f"says {variable.name} is {variable.terms[term].name}",
                    labels=(Label(earlier.span, f"says {variable.name} is {variable.terms[said].name}"),),
                    help="both speak at once, so the output lies between the two; keep the one that is meant",
                    severity="warning",
                )
            )
        if repeats and len(repeats) == len(rule.consequents):
            names.tell(
                Diagnostic(
                    "FZ307",
                    "this rule is written twice",
                    rule.span,
                    label="again here",
                    labels=(Label(repeats[0].span, "first here"),),
                    help="remove it",
                    severity="warning",
                )
            )
