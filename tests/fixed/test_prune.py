"""What is dropped before C is printed is dropped without a trace."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fuzzyspec.fixed.program import Assign, Define, Local, Program, ReadPort, Record, SetOutput
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


def test_a_value_is_not_put_back_where_it_is() -> None:
    """A sum that nothing is added to is left out: compilers warn of ``total = total``."""
    given = ReadPort("x", "uint8", 0, 255)
    total, other = Local("total", "uint8", 0, 255), Local("other", "uint8", 0, 255)
    body = (
        Define(total, given, False),
        Define(other, given, False),
        Assign(total, total),
        Assign(other, total),
        SetOutput("y", total),
        SetOutput("z", other),
    )
    assert prune(body) == tuple(s for s in body if s != Assign(total, total))
