"""Strategies are different programs with the same integers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fuzzyspec import load
from fuzzyspec.fixed import run
from fuzzyspec.fixed.program import Function, Program
from fuzzyspec.fixed.run import initial_state
from fuzzyspec.lower.choice import strategies
from fuzzyspec.lower.controller import lower_controller
from fuzzyspec.lower.strategy import Precision
from fuzzyspec.lower.widths import fit_widths
from fuzzyspec.model.controller import Controller
from tests.random_specs.generator import spec

ROOT = Path(__file__).resolve().parents[2]


def programs(controller: Controller, precision: Precision = "full") -> list[Function]:
    """By every strategy that applies, loops first; all fitted to a narrow machine, the first also as it is lowered."""
    first, *others = (lower_controller(controller, strategy, precision)[0] for strategy in strategies(controller))
    return [first, *(fit_widths(function, "narrow") for function in (first, *others))]


def same_integers(controller: Controller, cases: int, precision: Precision = "full") -> None:
    """Run every choice over raws of the whole C type, ends and ties included, and compare all that comes out."""
    random = np.random.default_rng(11)
    inputs = {}
    for item in controller.inputs:
        raw = item.variable.raw
        middle = np.array([raw.lo, raw.hi, (raw.lo + raw.hi) // 2])
        inputs[item.name] = np.where(
            random.random(cases) < 0.3, random.choice(middle, cases), random.integers(raw.lo, raw.hi + 1, cases)
        )
    results = []
    for function in programs(controller, precision):
        program = Program("choice", (function,))
        state = {k: np.full(cases, v) for k, v in initial_state(program, function).items()}
        results.append(run(program, controller.name, inputs, state, record=True, checked=True))
    for other in results[1:]:
        for name, raws in results[0].outputs.items():
            assert np.array_equal(other.outputs[name], raws), name
        assert np.array_equal(other.status, results[0].status)
        for key, decided in results[0].decisions.items():
            assert np.array_equal(other.decisions[key], decided), key


@pytest.mark.parametrize(
    "path", sorted((*ROOT.glob("examples/*.fz"), *ROOT.glob("benchmarks/*.fz"))), ids=lambda p: p.stem
)
def test_every_choice_computes_the_same_integers(path: Path) -> None:
    """Loops, minors and masks give equal outputs, status and decisions on the examples and the workloads."""
    for controller in load(path).module.controllers:
        same_integers(controller, 4000)
        same_integers(controller, 2000, "short")


@pytest.mark.gate
@pytest.mark.parametrize("seed", range(700, 712))
def test_every_choice_computes_the_same_integers_on_random_specs(seed: int, tmp_path: Path) -> None:
    """The same over random controllers of every kind."""
    path = tmp_path / "random.fz"
    path.write_text(spec(seed))
    for controller in load(path).module.controllers:
        same_integers(controller, 600)


def test_the_choices_differ() -> None:
    """W3 is really computed in five ways or more: by loops, minors and levels, with either division."""
    (controller,) = load(ROOT / "benchmarks" / "w3.fz").module.controllers
    found = programs(controller)
    assert len({f.body for f in found}) >= 6
