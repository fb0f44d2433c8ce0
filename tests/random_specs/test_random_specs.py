"""Random specs over the whole language, each through everything that is promised of any."""

from __future__ import annotations

import pytest

from fuzzyspec import SpecError, load
from tests.random_specs.generator import spec
from tests.random_specs.shrinking import smallest
from tests.random_specs.trial import Effort, trial

SEEDS = [pytest.param(seed, marks=() if seed % 5 == 0 else pytest.mark.gate) for seed in range(100)]


@pytest.mark.parametrize("seed", SEEDS)
def test_random_spec(seed: int) -> None:
    """C is the program bit for bit by any strategy and compiler, the program within its bounds, bands and intervals.

    Each fifth also under sanitizers, each fourth on an emulated machine; ``make campaign`` takes ten times as many.
    """
    trial(spec(seed), seed, Effort(300, sanitized=seed % 5 == 0, machines=seed % 4 == 3))


def test_few_random_specs_are_refused() -> None:
    """The generator writes valid specs: of fifty that no other test looks at, the checker takes all."""
    for seed in range(1000, 1050):
        try:
            load(spec(seed))
        except SpecError as error:
            pytest.fail(f"seed {seed}: {error}")


def test_a_failure_is_made_small() -> None:
    """Where products of degrees were to blame, what is left of a spec is one controller with little but products."""

    def multiplies(text: str) -> bool:
        try:
            return any(c.infer.and_ == "product" for c in load(text).module.controllers)
        except SpecError:
            return False

    text = spec(6)
    found = smallest(text, multiplies)
    assert multiplies(found)
    assert len(found) < len(text) / 5
    assert all(len(c.inputs) == len(c.outputs) == 1 for c in load(found).module.controllers)
