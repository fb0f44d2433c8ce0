"""The pieces that a controller's bound is composed of, each attacked by itself."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyspec import load
from fuzzyspec.exact.centroid import union
from fuzzyspec.exact.membership import degree
from fuzzyspec.lower.bounds import Effort, means, orders
from fuzzyspec.lower.bounds.memberships import membership
from fuzzyspec.lower.bounds.outputs import CentroidBound
from fuzzyspec.lower.bounds.search import LITTLE, Search
from fuzzyspec.lower.bounds.strengths import Band, Boxes, Strengths
from fuzzyspec.lower.controller import lower_controller
from fuzzyspec.lower.strategy import Strategy
from fuzzyspec.model.controller import Controller
from fuzzyspec.model.term import PiecewiseLinear

ROOT = Path(__file__).resolve().parents[2]
ORDERED = [("benchmarks/w1", "tipper"), ("benchmarks/w2", "danger"), ("benchmarks/w3", "velocity")]
ORDERED += [("examples/nav", "danger"), ("examples/nav", "velocity")]
F = Fraction

PLACES = st.sampled_from([F(k, 6) for k in range(-3, 10)])
HEIGHTS = st.sampled_from([F(0), F(1, 3), F(1, 2), F(1)])


@given(st.lists(st.tuples(PLACES, HEIGHTS), min_size=2, max_size=7), st.data())
def test_no_degree_lies_outside_its_interval(points: list[tuple[Fraction, Fraction]], data: st.DataObject) -> None:
    """Over intervals whose ends may be jumps: the degrees of all their points, the ends among them, are inside."""
    points.sort(key=lambda p: p[0])
    shape = PiecewiseLinear(tuple(points))
    ends = st.sampled_from([F(k, 12) for k in range(13)])
    a, b = sorted((data.draw(ends), data.draw(ends)))
    m = membership(shape, F(0), F(1))
    low, high = m.over(np.array([float(a)]), np.array([float(b)]))
    found = degree(shape, np.array([float(a + (b - a) * F(k, 24)) for k in range(25)]))
    assert low[0] <= found.min()
    assert found.max() <= high[0]


SHARES = st.floats(0, 1, allow_nan=False)


@given(st.lists(st.tuples(SHARES, SHARES, SHARES, SHARES, SHARES), min_size=2, max_size=4))
def test_a_probabilistic_sum_errs_by_no_more(parts: list[tuple[float, ...]]) -> None:
    """Operands anywhere in their intervals, off by no more than they may be: so is a + b - a b."""
    (controller,) = load(
        "module m\ncontroller c {\n input x in [0, 1] { partition L H }\n output y in [0, 1] { partition P Q }\n"
        " infer { or = probsum }\n rules { if x is L or x is H then y is P  if x is H then y is Q }\n}\n"
    ).module.controllers
    _, numbers = lower_controller(controller, Strategy("loops"))
    strengths = Strengths(numbers, (0.0,))
    bands, true, computed = [], 0.0, 0.0
    for a, b, at, off, moved in parts:
        low, high = min(a, b), max(a, b)
        bands.append(Band(np.array([low]), np.array([high]), np.array([off / 4])))
        value = low + (high - low) * at
        other = min(max(value + (2 * moved - 1) * off / 4, 0.0), 1.0)
        true, computed = true + value - true * value, computed + other - computed * other
    found = strengths.either(bands)
    assert found.lo[0] - 1e-12 <= true <= found.hi[0] + 1e-12
    assert abs(computed - true) <= found.off[0] + 1e-12


@pytest.mark.parametrize("step", [1, 7, 97])
def test_no_raw_is_lost_between_boxes(step: int) -> None:
    """Boxes drawn in around raws hold every raw that they held, and where there is none they go."""
    (controller,) = load(
        f"module m\ncontroller c {{\n input x in [0, 1] raw uint16 0..{300 // step} {{ partition A B C D }}\n"
        " output y in [0, 1] { partition P Q }\n table y by x { A: P  B: Q  C: P  D: Q }\n}\n"
    ).module.controllers
    _, numbers = lower_controller(controller, Strategy("loops"))
    search = Search(Strengths(numbers, (0.0,)), list(means(numbers)), Effort(10))
    raw = controller.inputs[0].variable.raw
    raws = np.array([float(raw.value(r)) for r in range(raw.lo, raw.hi + 1)])
    dice = np.random.default_rng(step)
    pool = np.concatenate([raws, dice.random(50)])
    ends = np.sort(dice.choice(pool, (400, 2)), axis=1)
    for a, b in ends:
        found = search._around_raws(Boxes(np.array([[a]]), np.array([[b]])))
        inside = raws[(a <= raws) & (raws <= b)]
        assert len(found) or not len(inside)
        if len(found):
            assert a <= found.lo[0, 0]
            assert found.hi[0, 0] <= b
            assert not len(inside) or (found.lo[0, 0] <= inside[0] and inside[-1] <= found.hi[0, 0])
            near = np.abs(raws[:, None] - found.lo[0, 0]) <= 2 * LITTLE * raw.step
            assert near.any() or found.lo[0, 0] == a


@pytest.mark.parametrize(("name", "function"), ORDERED)
@pytest.mark.parametrize("off", [2.0**-4, 2.0**-8, 2.0**-15], ids=["far", "some", "rounded"])
def test_no_rounding_of_degrees_moves_a_mean_further(name: str, function: str, off: float) -> None:
    """Lemma "slope" for degrees: moved by as much as they may be, up or down, or tied, they move no mean beyond it."""
    controller = load(ROOT / f"{name}.fz").controllers[function]
    _, numbers = lower_controller(controller, Strategy("loops"))
    assert orders.applies(controller)
    dice = np.random.default_rng(8)
    n = 4000
    lower = [dice.integers(0, len(i.terms) - 1, n) for i in controller.inputs]
    shared = dice.choice([0.0, 0.01, 0.1, 0.3, 0.5], n)
    upper = [np.where(dice.random(n) < 0.5, dice.random(n), shared) for _ in controller.inputs]
    upper = [np.where(dice.random(n) < 0.5, u, 1 - u) for u in upper]
    moved = [np.clip(u + off * dice.choice([-1.0, 1.0, 0.3], n), 0, 1) for u in upper]
    strengths = Strengths(numbers, (0.0,) * len(controller.inputs))
    moves = [[off] * (len(i.terms) - 1) for i in controller.inputs]
    for o, (output, mean) in enumerate(zip(controller.outputs, means(numbers), strict=True)):
        assert isinstance(mean, CentroidBound)
        bound, _ = orders.Fastest(output, mean, orders.pieces_of(strengths, o, moves, beyond=True)).search(8000)
        one, other = (_mean(controller, o, lower, degrees) for degrees in (upper, moved))
        span = float(output.variable.hi - output.variable.lo)
        assert np.abs(one - other).max() / span <= bound


def _mean(controller: Controller, output: int, lower: list[np.ndarray], upper: list[np.ndarray]) -> np.ndarray:
    """The exact centroid for degrees that are given, from the definitions."""
    cells = controller.cells
    assert cells is not None
    table = np.array(cells.consequents[output]).reshape(cells.shape)
    n = len(upper[0])
    levels = np.zeros((len(controller.outputs[output].terms), n))
    for corner in np.ndindex(*(2,) * len(upper)):
        strength = np.minimum.reduce([u if c else 1 - u for c, u in zip(corner, upper, strict=True)])
        term = table[tuple(low + c for c, low in zip(corner, lower, strict=True))]
        levels[term, np.arange(n)] = np.maximum(levels[term, np.arange(n)], strength)
    area, moment = union(controller.outputs[output], levels, "min")
    return moment / area
