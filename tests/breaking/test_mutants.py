"""What damaged specs come to: a diagnostic, or C. Nothing is accepted that fails later."""

from __future__ import annotations

import random

import pytest

from fuzzyspec.check.report import module_report
from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.syntax import source_from_bytes
from tests.breaking.mutants import SOUND, mutant
from tests.breaking.oracle import checked
from tests.random_specs.trial import LIGHT, trial


@pytest.mark.parametrize("first", range(0, 1000, 100))
def test_damaged_text_ends_in_diagnostics_or_a_model(first: int) -> None:
    """Whatever is dropped, doubled or swapped, a refusal has an error to show, and nothing is raised."""
    for seed in range(first, first + 100):
        checked(Source("mutant.fz", mutant(seed, numbers=0.3)))


@pytest.mark.parametrize("first", range(0, 300, 100))
def test_damaged_bytes_end_in_diagnostics_or_a_model(first: int) -> None:
    """Bytes changed, put in or left out anywhere, whatever becomes of the encoding."""
    for seed in range(first, first + 100):
        dice = random.Random(seed)
        data = bytearray(dice.choice(SOUND).encode())
        for _ in range(dice.choice((1, 2, 8))):
            at = dice.randrange(len(data))
            data[at : at + dice.randrange(3)] = dice.randbytes(dice.randrange(3))
        source, _ = source_from_bytes("mutant.fz", bytes(data))
        checked(source)


FIRST = [10_000, *(pytest.param(first, marks=pytest.mark.gate) for first in range(10_010, 10_080, 10))]


@pytest.mark.parametrize("first", FIRST)
def test_what_is_accepted_works(first: int) -> None:
    """With numbers changed at random, what the checker accepts becomes C that keeps its bounds, or is refused for its
    arithmetic; its report can be written."""
    for seed in range(first, first + 10):
        source = Source("mutant.fz", mutant(seed, numbers=0.9))
        model, _ = checked(source)
        if model is not None:
            trial(f"{source.text}\n", seed, LIGHT)
            assert module_report(model, source, {}).text()
