"""The directed search climbs, finds more than chance does, and shows certified bounds to be tight."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from fuzzyspec import load
from fuzzyspec.verify import Effort, Subject, largest_errors, subjects
from fuzzyspec.verify.cases import batches
from fuzzyspec.verify.directed import Directed

ROOT = Path(__file__).resolve().parents[2]
ALONE = ("benchmarks/w1", "benchmarks/w2", "benchmarks/w3", "benchmarks/w3s", "examples/nav", "examples/temperature")
ALONE += ("examples/tipper",)
MOST = 4
"""A mark of the project: how many times the largest error that is found a controller's certified bound may be."""

MOST_OF_SYSTEMS = 10
"""The same of a whole system's."""


def controllers(name: str) -> list[Subject]:
    """The controllers of a spec, as they are verified."""
    spec = load(ROOT / f"{name}.fz")
    known = subjects(spec.module, spec.lowered.program, spec.lowered.certificates)
    return [s for s in known if s.function.kind == "controller"]


@pytest.mark.parametrize("name", ALONE)
def test_bounds_are_at_most_four_times_what_is_found(name: str) -> None:
    """Of every controller of the workloads and examples: certified <= 4 times found, and never below it."""
    for subject in controllers(name):
        found = largest_errors(subject, 1, 2_000, Effort(rounds=20, children=1 << 11))
        for output in found.outputs:
            if output.output == "acting":
                continue
            assert output.ratio is not None, output.output
            assert 1 <= output.ratio <= MOST, f"{subject.name}.{output.output}: {output.ratio}"


@pytest.mark.gate
@pytest.mark.parametrize(("name", "share"), [("nav", "drive: error of "), ("temperature", "drive: error of error")])
def test_bounds_of_systems_are_at_most_ten_times_what_is_found(name: str, share: str) -> None:
    """Of the examples' systems: certified <= 10 times found, never below it, and owed to what the layers carry on."""
    spec = load(ROOT / "examples" / f"{name}.fz")
    subject = subjects(spec.module, spec.lowered.program, spec.lowered.certificates)[-1]
    found = largest_errors(subject, 1, 2_000, Effort(rounds=20, children=1 << 11))
    for output in found.outputs:
        if output.output != "acting":
            assert output.ratio is not None, output.output
            assert 1 <= output.ratio <= MOST_OF_SYSTEMS, f"{output.output}: {output.ratio}"
            assert output.dominant is not None
            assert output.dominant.kernel.startswith(share)


def test_a_summit_is_reached() -> None:
    """Told of a hill over the raws of all inputs, the search asks for its top within a few rounds, at either sign."""
    (subject,) = controllers("benchmarks/w3")
    summit = {k: (p.lo + 7 * p.hi) // 8 + 5 for k, p in subject.ports.items()}
    directed = Directed(subject, 5, Effort(rounds=30, children=1 << 12))
    best = np.inf
    for batch in [*batches(subject, 5, 100)][:1] + [None] * directed.effort.rounds:
        asked = directed.ask() if batch is None else batch
        height = -sum(np.abs(asked.inputs[k] - at) / 1000.0 for k, at in summit.items())
        best = min(best, float(-height.max()))
        directed.tell(asked, {"v": np.asarray(height)})
    assert best == 0


def test_it_finds_more_than_as_many_random_cases() -> None:
    """The search's worth: a larger error of each of W3's outputs than twice its cases found at random."""
    (subject,) = controllers("benchmarks/w3")
    effort = Effort(rounds=20, children=1 << 10)
    searched = largest_errors(subject, 2, 1_000, effort)
    random = largest_errors(subject, 2, 2 * effort.cases, Effort(rounds=0))
    for mine, theirs in zip(searched.outputs, random.outputs, strict=True):
        assert mine.largest_error is not None
        assert theirs.largest_error is not None
        assert mine.largest_error > theirs.largest_error


def test_the_same_seed_finds_the_same() -> None:
    """Nothing but the seed decides: two searches report the same worst cases."""
    (subject,) = controllers("benchmarks/w2")
    effort = Effort(rounds=3, children=1 << 10)
    assert largest_errors(subject, 3, 500, effort) == largest_errors(subject, 3, 500, effort)


def test_lists_and_states_are_searched() -> None:
    """A system's records and a controller's state are moved like its inputs, counts stay within the lists."""
    spec = load(ROOT / "examples" / "nav.fz")
    subject = subjects(spec.module, spec.lowered.program, spec.lowered.certificates)[-1]
    directed = Directed(subject, 4, Effort(rounds=2, children=1 << 10))
    for batch in [*batches(subject, 4, 50)][:3]:
        directed.tell(batch, {"v": np.arange(batch.n, dtype=np.float64)})
    asked = directed.ask()
    counts = asked.inputs["obstacles.count"]
    assert counts.max() <= asked.inputs["obstacles.distance"].shape[1]
    assert len(np.unique(asked.inputs["obstacles.distance"])) > 100


def test_a_bound_names_what_it_owes_most_to() -> None:
    """W3's errors come from theta's degrees, the only ones that are rounded; the place is told by inputs and terms."""
    (subject,) = controllers("benchmarks/w3")
    for output in subject.certificate.outputs:
        assert output.dominant is not None
        assert output.dominant.kernel == "degrees of theta"
        assert output.dominant.percent > Fraction(100, 2)
        assert output.dominant.where.startswith("lddc near ")
        assert "theta near " in output.dominant.where
