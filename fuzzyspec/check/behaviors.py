"""Behavior blocks: their names, priorities and rules, as claims on cells."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.check.claims import Claim, whole
from fuzzyspec.check.rule_names import RuleNames
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Span
from fuzzyspec.syntax import tree

Numbers = Callable[[tree.Expr], Fraction | None]


@dataclass(frozen=True, slots=True)
class Block:
    """A behavior as written, its code not yet given. ``priority`` is None where it could not be resolved."""

    name: str
    priority: int | None
    span: Span


def resolve_behaviors(
    decls: tuple[tree.BehaviorDecl, ...], names: RuleNames, numbers: Numbers
) -> tuple[tuple[Block, ...], tuple[Claim, ...]]:
    """Blocks in written order, and the claims of all of their rules that could be resolved."""
    blocks: list[Block] = []
    claims: list[Claim] = []
    first: dict[str, tree.Name] = {}
    for index, decl in enumerate(decls):
        # Two names that differ in case alone would give one C macro.
        earlier = first.setdefault(decl.name.text.upper(), decl.name)
        if earlier is not decl.name:
            names.error(
                Diagnostic(
                    "FZ327",
                    f"behavior `{decl.name.text}` is named like an earlier one",
                    decl.name.span,
                    label="named again",
                    labels=(Label(earlier.span, "first here"),),
                    help="put the rules into one block, or choose another name (case does not tell names apart in C)",
                )
            )
        if not decl.rules:
            names.error(
                Diagnostic(
                    "FZ328",
                    f"behavior `{decl.name.text}` has no rules",
                    decl.name.span,
                    label="claims no cells",
                    help="add a rule, `if x is A then y is B`, or remove the block",
                )
            )
        blocks.append(Block(decl.name.text, _priority(decl, names, numbers), decl.name.span))
        for rule in decl.rules:
            claim = _claim(rule, index, names)
            if claim is not None:
                claims.append(claim)
    return tuple(blocks), tuple(claims)


def consequents(rule: tree.Rule, names: RuleNames) -> tuple[tuple[int, int], ...] | None:
    """(output, term) of every consequent of a rule, or None where one could not be resolved."""
    sets: dict[int, tuple[int, tree.Consequent]] = {}
    complete = True
    for consequent in rule.consequents:
        output = names.output(consequent.output)
        term = None if output is None else names.output_term(output, consequent.term)
        if output is None or term is None:
            complete = False
        elif output in sets:
            complete = False
            names.error(
                Diagnostic(
                    "FZ314",
                    f"this rule sets output `{consequent.output.text}` twice",
                    consequent.span,
                    label="set again",
                    labels=(Label(sets[output][1].span, "first set here"),),
                    help="a rule gives each output one term",
                )
            )
        else:
            sets[output] = (term, consequent)
    return tuple((output, term) for output, (term, _) in sets.items()) if complete else None


def _priority(decl: tree.BehaviorDecl, names: RuleNames, numbers: Numbers) -> int | None:
    value = numbers(decl.priority)
    if value is None:
        names.broken = True
        return None
    if value.denominator != 1:
        names.error(
            Diagnostic(
                "FZ326",
                f"priority of behavior `{decl.name.text}` is not a whole number",
                decl.priority.span,
                label=f"is {value}",
                help="priorities are whole numbers; the highest wins a cell",
            )
        )
        return None
    return int(value)


def _claim(rule: tree.Rule, owner: int, names: RuleNames) -> Claim | None:
    if rule.weight is not None:
        names.tell(
            Diagnostic(
                "FZ309",
                "a rule inside a behavior has no weight",
                rule.weight.span,
                label="not allowed here",
                labels=(Label(rule.span, "this rule claims cells"),),
                help="a behavior wins a cell whole; use a `rules` block for weighted sentences",
            )
        )
    box: list[tuple[int, ...]] = whole(names.inputs)
    said: dict[int, tree.Is] = {}
    complete = True
    for part, negated in _conjunction(rule.condition, names):
        terms = _terms(part, negated, names)
        if terms is None:
            complete = False
            continue
        index, chosen = terms
        narrowed = tuple(t for t in box[index] if t in chosen)
        if not narrowed:
            complete = False
            variable = names.inputs[index]
            asked = [variable.terms[t].name for t in chosen]
            names.error(
                Diagnostic(
                    "FZ315",
                    f"no cell satisfies what this rule asks of `{variable.name}`",
                    part.span,
                    label="leaves no term" if not asked or index not in said else "contradicts",
                    labels=(Label(said[index].span, "asked here"),) if index in said else (),
                    help=f"a cell has one term for each input; for either of two say `{variable.name} in {{A, B}}`",
                )
            )
        else:
            box[index] = narrowed
        said.setdefault(index, part)
    sets = consequents(rule, names)
    if not complete or sets is None or _refused(rule.condition):
        return None
    return Claim(owner, None, tuple(box), sets, rule.span)


def _conjunction(condition: tree.Condition, names: RuleNames) -> list[tuple[tree.Is, bool]]:
    """The parts of a condition that are joined by ``and``, each with whether a ``not`` stands before it."""
    match condition:
        case tree.Is():
            return [(condition, condition.negated)]
        case tree.Antecedent("and", operands):
            return [part for operand in operands for part in _conjunction(operand, names)]
        case tree.Antecedent("not", (tree.Is() as part,)):
            return [(part, not part.negated)]
        case tree.Antecedent("not"):
            names.error(
                Diagnostic(
                    "FZ308",
                    "`not` of a group cannot stand inside a behavior",
                    condition.span,
                    label="not a set of cells for each input",
                    help="say `x is not A` for each input, or use a `rules` block",
                )
            )
        case tree.Antecedent():
            same = {p.variable.text for p in condition.operands if isinstance(p, tree.Is)}
            every = all(isinstance(p, tree.Is) and not p.negated for p in condition.operands)
            terms = [t.text for p in condition.operands if isinstance(p, tree.Is) for t in p.terms]
            names.error(
                Diagnostic(
                    "FZ308",
                    "`or` cannot stand inside a behavior",
                    condition.span,
                    label="a rule of a behavior claims one block of cells",
                    help=f"say `{next(iter(same))} in {{{', '.join(terms)}}}`"
                    if every and len(same) == 1
                    else "write one rule for each alternative, or use a `rules` block",
                )
            )
    return []


def _refused(condition: tree.Condition) -> bool:
    """Whether a condition holds what a behavior does not take; its rule then claims nothing."""
    match condition:
        case tree.Is():
            return False
        case tree.Antecedent("and", operands):
            return any(_refused(operand) for operand in operands)
        case tree.Antecedent("not", (tree.Is(),)):
            return False
        case _:
            return True


def _terms(part: tree.Is, negated: bool, names: RuleNames) -> tuple[int, tuple[int, ...]] | None:
    """Input and terms that a part of a condition selects; ``not`` selects the other terms of the input."""
    index = names.input(part.variable)
    if index is None:
        return None
    found = names.input_terms(index, part.terms)
    if found is None:
        return None
    if negated:
        return index, tuple(t for t in range(len(names.inputs[index].terms)) if t not in found)
    return index, found
