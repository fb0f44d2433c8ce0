"""Rules of a controller: tables, behaviors and sentences, from what was written to what holds."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import prod

from fuzzyspec.check.behaviors import Numbers, resolve_behaviors
from fuzzyspec.check.cells import Cells, rank, resolve_cells
from fuzzyspec.check.coverage import prove_firing
from fuzzyspec.check.holes import report_holes
from fuzzyspec.check.rule_names import Report, RuleNames
from fuzzyspec.check.sentences import resolve_sentences
from fuzzyspec.check.tables import resolve_tables
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label
from fuzzyspec.model.account import Account
from fuzzyspec.model.controller import Behavior, CellRules, Inference, Input, Output, SentenceRule
from fuzzyspec.syntax import tree

MOST_CELLS = 65_536
"""A rule table is walked by 16-bit indices."""


@dataclass(frozen=True, slots=True)
class RuleBase:
    """What a controller's rules come to; the fields are those of ``model.Controller``."""

    cells: CellRules | None
    sentences: tuple[SentenceRule, ...]
    behaviors: tuple[Behavior, ...]
    always_fires: tuple[bool, ...]
    account: Account | None


def resolve_rules(
    decl: tree.ControllerDecl,
    inputs: tuple[Input, ...],
    outputs: tuple[Output, ...],
    infer: Inference,
    fires_at: Fraction,
    numbers: Numbers,
    report: Report,
) -> RuleBase:
    """Resolve tables, behaviors and rules blocks, report what is wrong with them, and prove which outputs always fire.

    ``inputs`` and ``outputs`` are those that passed their own check; what the rules say about others is passed over.
    ``numbers`` evaluates a constant expression without unit and reports for itself where it cannot. After an error
    the result holds what could be resolved, and must not be compiled.
    """
    names = RuleNames(decl, inputs, outputs, report)
    tables = tuple(item for item in decl.items if isinstance(item, tree.Table))
    behavior_decls = tuple(item for item in decl.items if isinstance(item, tree.BehaviorDecl))
    rule_blocks = tuple(item for item in decl.items if isinstance(item, tree.RulesBlock))

    if behavior_decls and rule_blocks:
        names.error(
            Diagnostic(
                "FZ310",
                "sentence rules cannot stand beside behaviors",
                rule_blocks[0].span,
                label="these rules claim no cells",
                labels=(Label(behavior_decls[0].name.span, "behaviors win cells whole"),),
                help="put the rules into a behavior, or into a controller of their own",
            )
        )
    if not (tables or behavior_decls or rule_blocks):
        names.error(
            Diagnostic(
                "FZ328",
                f"controller `{decl.name.text}` has no rules",
                decl.name.span,
                label="nothing sets its outputs",
                help="add a `table`, `behavior` blocks or a `rules` block",
            )
        )

    sentences = resolve_sentences(rule_blocks, names, numbers)
    blocks, behavior_claims = resolve_behaviors(behavior_decls, names, numbers)
    table_claims, missing = resolve_tables(tables, names)
    ranking = rank(blocks, tables)
    claims = behavior_claims + table_claims
    cells = None
    if (tables or behavior_decls) and _fits(decl, inputs, names) and all(b.priority is not None for b in blocks):
        cells = resolve_cells(claims, ranking, names)
    if not names.broken:
        _report_never_set(decl, cells, sentences, names)
        if cells is not None:
            by_sentence = frozenset(o for s in sentences for o, _ in s.consequents)
            report_holes(cells, claims, missing, by_sentence, bool(blocks), names, decl.name.span)

    kept = None if cells is None else cells.rules
    always = tuple(False for _ in outputs)
    if not names.broken:
        always = prove_firing(inputs, outputs, infer, fires_at, kept, sentences, decl.name.span, names.error)
    return RuleBase(kept, sentences, ranking.behaviors, always, None if cells is None else cells.account)


def _fits(decl: tree.ControllerDecl, inputs: tuple[Input, ...], names: RuleNames) -> bool:
    count = prod(len(v.terms) for v in inputs)
    if count > MOST_CELLS:
        sizes = " x ".join(str(len(v.terms)) for v in inputs)
        names.error(
            Diagnostic(
                "FZ329",
                f"the rule table of controller `{decl.name.text}` has {count:,} cells",
                decl.name.span,
                label=f"{sizes} terms",
                help=f"at most {MOST_CELLS:,} cells fit; split the controller in layers, or use a `rules` block",
            )
        )
    return 0 < count <= MOST_CELLS


def _report_never_set(
    decl: tree.ControllerDecl, cells: Cells | None, sentences: tuple[SentenceRule, ...], names: RuleNames
) -> None:
    by_sentence = {o for s in sentences for o, _ in s.consequents}
    for index, output in enumerate(names.outputs):
        by_cell = cells is not None and bool((cells.consequents[index] != -1).any())
        if not by_cell and index not in by_sentence:
            names.error(
                Diagnostic(
                    "FZ323",
                    f"no rule sets output `{output.name}`",
                    output.variable.span,
                    label="never set",
                    labels=(Label(decl.name.span, "in this controller"),),
                    help=f"add `{output.name} is ..` to its rules, or remove the output",
                )
            )
