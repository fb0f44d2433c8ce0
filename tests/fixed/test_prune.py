"""What is dropped before C is printed is dropped without a trace."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fuzzyspec.fixed.program import Program, Record
from fuzzyspec.fixed.prune import prune, statements
from fuzzyspec.fixed.run import run
from tests.fixed.random_programs import program
from tests.fixed.test_run import lanes


@pytest.mark.parametrize("seed", range(60))
def test_a_pruned_program_computes_the_same(seed: int) -> None:
    """Outputs, status and state of random programs are what they were; only records are gone for good."""
    of = program(seed)
    bare = Program(of.name, tuple(replace(f, body=prune(f.body)) for f in of.functions))
    assert not any(isinstance(s, Record) for f in bare.functions for s in statements(f.body))
    inputs, state = lanes(seed, 200)
    before, after = run(of, "outer", inputs, state), run(bare, "outer", inputs, state)
    assert np.array_equal(before.status, after.status)
    for mine, theirs in ((before.outputs, after.outputs), (before.state, after.state)):
        assert list(mine) == list(theirs)
        for name in mine:
            assert np.array_equal(mine[name], theirs[name]), name
