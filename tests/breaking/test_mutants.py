"""What damaged specs come to: a diagnostic, or C. Nothing is accepted that fails later."""

from __future__ import annotations

import pytest

from fuzzyspec.check import check
from fuzzyspec.check.report import module_report
from fuzzyspec.diagnostics.codes import REGISTRY
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source
from fuzzyspec.diagnostics.render import as_json, render
from fuzzyspec.emit import emit
from fuzzyspec.lower import LoweringError, Options, lower
from fuzzyspec.model.system import Module
from fuzzyspec.syntax import parse
from tests.breaking.mutants import mutant


def checked(source: Source) -> tuple[Module | None, tuple[Diagnostic, ...]]:
    """The model and all that was told, every diagnostic being one that can be shown."""
    tree, torn = parse(source)
    model, found = check(tree, source, torn)
    told = (*torn, *found)
    render(told, source)
    as_json(told, source)
    for d in told:
        assert d.severity == REGISTRY[d.code].severity
        assert all(0 <= s.start <= s.end <= len(source.text) for s in (d.span, *(each.span for each in d.labels)))
    assert (model is None) == any(d.severity == "error" for d in told)
    return model, told


@pytest.mark.parametrize("first", range(0, 1000, 100))
def test_damaged_text_ends_in_diagnostics_or_a_model(first: int) -> None:
    """Whatever is dropped, doubled or swapped, a refusal has an error to show, and nothing is raised."""
    for seed in range(first, first + 100):
        checked(Source("mutant.fz", mutant(seed, numbers=0.3)))


@pytest.mark.parametrize("first", range(10_000, 10_080, 10))
def test_what_is_accepted_compiles(first: int) -> None:
    """With numbers changed at random, what the checker accepts becomes C, or is refused for its arithmetic (FZ45x)."""
    for seed in range(first, first + 10):
        source = Source("mutant.fz", mutant(seed, numbers=0.9))
        model, _ = checked(source)
        if model is None:
            continue
        try:
            lowered = lower(model)
        except LoweringError as refusal:
            assert refusal.diagnostics
            assert {d.code[:4] for d in refusal.diagnostics} == {"FZ45"}
            render(refusal.diagnostics, source)
            continue
        assert emit(model, lowered, source, Options()).files
        assert module_report(model, source, {}).text()
