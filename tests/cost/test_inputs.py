"""The inputs that everybody measures with."""

from __future__ import annotations

import math

import numpy as np

from fuzzyspec import load
from fuzzyspec.estimate.inputs import draw_cases, unit_numbers
from tests.cost.cost_specs import KEEPING, PLAIN


def test_the_stream_is_the_congruence_that_is_written_down() -> None:
    """The first two numbers, worked out by hand from the seed."""
    first = (1664525 * 12345 + 1013904223) % 2**32
    second = (1664525 * first + 1013904223) % 2**32
    assert unit_numbers(2).tolist() == [(first >> 8) / 2**24, (second >> 8) / 2**24]


def test_scalars_draw_in_order_over_their_ranges() -> None:
    """Each case takes one number an input; the raw is the nearest to the place in the range."""
    program = load(PLAIN).lowered.program
    inputs, state = draw_cases(program, program.function("fan"), 50)
    u = unit_numbers(100).reshape(50, 2)
    assert state is None
    assert inputs["x"].tolist() == [math.floor(10 * a * 2**12 + 0.5) for a, _ in u]
    assert inputs["y"].tolist() == [math.floor((-5 + 10 * b) * 2**12 + 0.5) for _, b in u]


def test_lists_draw_their_count_and_then_every_record() -> None:
    """A list takes 1 + capacity x fields numbers, the state the last ones, all within their limits."""
    program = load(KEEPING).lowered.program
    inputs, state = draw_cases(program, program.function("both"), 200)
    u = unit_numbers(200 * 9).reshape(200, 9)
    assert inputs["parts.count"].tolist() == np.floor(u[:, 1] * 4).astype(int).tolist()
    assert set(inputs["parts.count"].tolist()) == {0, 1, 2, 3}
    assert inputs["parts.size"].shape == (200, 3)
    assert inputs["parts.kind"][:, 2].tolist() == [math.floor(9 * v * 2**12 + 0.5) for v in u[:, 7]]
    assert state is not None
    held = next(iter(state.values()))
    assert held.min() >= 0
    assert len(set(held.tolist())) > 100
