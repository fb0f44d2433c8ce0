"""Which rules fire at an input of a controller, and how strongly."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.check.claims import describe_cell
from fuzzyspec.check.degrees import degree
from fuzzyspec.check.strength import conjunction, rule_strength
from fuzzyspec.diagnostics.diagnostic import Source, Span
from fuzzyspec.model.controller import Behavior, Controller


@dataclass(frozen=True)
class InputExplained:
    """``value`` is what counts, after saturation; ``given`` what was asked for. ``degrees`` by term."""

    name: str
    given: Fraction
    value: Fraction
    degrees: Mapping[str, Fraction]


@dataclass(frozen=True)
class Firing:
    """A cell or a sentence rule that fires.

    ``rule`` says it in words, ``sets`` the outputs' terms by output, ``owner`` the behavior that won the cell,
    ``spans`` the rules in the text that it comes from.
    """

    rule: str
    strength: Fraction
    sets: Mapping[str, str]
    owner: Behavior | None
    weight: Fraction
    spans: tuple[Span, ...]


@dataclass(frozen=True)
class Explanation:
    """Everything that happens before an output is computed; ``firings`` the strongest first."""

    inputs: tuple[InputExplained, ...]
    firings: tuple[Firing, ...]


def explain(controller: Controller, at: Mapping[str, Fraction], source: Source | None = None) -> Explanation:
    """Degrees, cells and rules at one input, exactly; ``at`` in declared units, saturated to the ranges."""
    inputs = []
    degrees = []
    for item in controller.inputs:
        v = item.variable
        value = min(max(at[v.name], v.lo), v.hi)
        ds = [degree(term.shape, value) for term in item.terms]
        degrees.append(ds)
        inputs.append(
            InputExplained(v.name, at[v.name], value, {t.name: d for t, d in zip(item.terms, ds, strict=True)})
        )
    firings = [*_cells(controller, degrees), *_sentences(controller, degrees, source)]
    firings.sort(key=lambda f: -f.strength)
    return Explanation(tuple(inputs), tuple(firings))


def _cells(controller: Controller, degrees: list[list[Fraction]]) -> list[Firing]:
    found: list[Firing] = []
    cells, account = controller.cells, controller.account
    if cells is None:
        return found
    behaviors = {b.code: b for b in controller.behaviors}
    for cell in itertools.product(*([t for t, d in enumerate(ds) if d > 0] for ds in degrees)):
        flat = 0
        for size, term in zip(cells.shape, cell, strict=True):
            flat = flat * size + term
        sets = {
            output.name: output.terms[terms[flat]].name
            for output, terms in zip(controller.outputs, cells.consequents, strict=True)
            if terms[flat] >= 0
        }
        rules = () if account is None else tuple(sorted({s[flat] for s in account.sources if s[flat] >= 0}))
        spans = () if account is None else tuple(account.rules[r].span for r in rules)
        strength = conjunction([ds[t] for ds, t in zip(degrees, cell, strict=True)], controller.infer)
        words = describe_cell(cell, controller.inputs)
        found.append(Firing(words, strength, sets, behaviors.get(cells.owner[flat]), Fraction(1), spans))
    return found


def _sentences(controller: Controller, degrees: list[list[Fraction]], source: Source | None) -> list[Firing]:
    found = []
    for number, rule in enumerate(controller.sentences, start=1):
        strength = rule_strength(rule, degrees, controller.infer)
        if strength > 0:
            sets = {controller.outputs[o].name: controller.outputs[o].terms[t].name for o, t in rule.consequents}
            words = f"rule {number}"
            if source is not None:
                words = " ".join(source.text[rule.span.start : rule.span.end].split())
            found.append(Firing(words, strength, sets, None, rule.weight, (rule.span,)))
    return found
