"""What damaged specs come to: a diagnostic, or C. Nothing is accepted that fails later."""

from __future__ import annotations

import pytest

from fuzzyspec.check.report import module_report
from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.diagnostics.render import render
from fuzzyspec.emit import emit
from fuzzyspec.lower import LoweringError, Options, lower
from tests.breaking.mutants import mutant
from tests.breaking.oracle import checked


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
