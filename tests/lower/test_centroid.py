"""The integer centroid against the closed forms that other tests hold to integration: every clip height."""

from __future__ import annotations

from fractions import Fraction
from typing import get_args

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fuzzyspec.fixed.program import AssignElement, Const, DefineArray, Division, Stmt
from fuzzyspec.lower.centroid import CentroidNumbers, centroid
from fuzzyspec.lower.clipped import TooManySets, clipped_sets
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.scope import Scope
from fuzzyspec.lower.sets import closed_form
from fuzzyspec.model.controller import Output
from tests.lower.lower_models import full_output, has_area, output_of, partition, peaks, shapes, variables
from tests.lower.lower_running import given as reading
from tests.lower.lower_running import outcome

F = Fraction
SLACK = 1e-9
"""Of float64, in counts of at most 65,535: a hundred roundings of values of order 1."""


@st.composite
def outputs(draw: st.DrawFn) -> Output:
    """Irregular shapes, partitions with any peaks, full ones, even ones; over any raw."""
    variable = draw(variables())
    kind = draw(st.sampled_from(["shapes", "partition", "full", "even"]))
    span = variable.hi - variable.lo
    if kind == "shapes":
        own = draw(st.lists(shapes(variable, most=5), min_size=1, max_size=4))
        assume(all(has_area(s, variable.lo, variable.hi) for s in own))
        return output_of(variable, own)
    if kind == "even":
        count = draw(st.integers(2, 7))
        at = [variable.lo + span * k / (count - 1) for k in range(count)]
    else:
        at = sorted({variable.lo, variable.hi, *draw(peaks(variable, most=6))})
    if kind != "partition" and draw(st.booleans()):
        return full_output(variable, at)
    return output_of(variable, partition(at))


def levels_of(output: Output, seed: int) -> np.ndarray:
    """Clip heights (cases, terms): a term alone at every third height, neighbours together, all at random."""
    n = len(output.terms)
    dice = np.random.default_rng(seed)
    alone = dice.integers(0, n)
    every = np.arange(1 + seed % 3, DEGREE_ONE + 1, 3)
    single = np.zeros((len(every), n), dtype=np.int64)
    single[:, alone] = every
    some = dice.integers(0, DEGREE_ONE + 1, (3000, n))
    some = np.where(dice.random((3000, n)) < 0.5, 0, some)
    some = np.where(dice.random((3000, n)) < 0.1, DEGREE_ONE, some)
    some = np.where(dice.random((3000, n)) < 0.05, 1, some)
    found = np.concatenate([single, some, np.full((1, n), DEGREE_ONE), np.ones((1, n), dtype=np.int64)])
    return found[found.max(axis=1) > 0]


def raws(output: Output, levels: np.ndarray, division: Division) -> tuple[np.ndarray, CentroidNumbers]:
    """What the integers make of the levels; every intermediate is held against its interval."""
    scope = Scope()
    body: list[Stmt] = [DefineArray("levels", "uint16", levels.shape[1])]
    for k in range(levels.shape[1]):
        define, height = reading(f"level_{k}", "uint16", 0, DEGREE_ONE)
        body += [define, AssignElement("levels", "uint16", Const(k), height)]
    steps, raw, tables, numbers = centroid(output, "levels", division, scope)
    inputs = {f"level_{k}": levels[:, k] for k in range(levels.shape[1])}
    return outcome([*body, *steps], {"raw": raw}, inputs, tables)["raw"], numbers


@pytest.mark.parametrize("division", get_args(Division))
@settings(max_examples=25)
@given(output=outputs(), seed=st.integers(0, 10**6))
def test_the_centroid_is_within_its_numbers(division: Division, output: Output, seed: int) -> None:
    """For any clip heights the raw is within what the set's own errors, the weights and the tail allow."""
    levels = levels_of(output, seed)
    try:
        found, numbers = raws(output, levels, division)
    except TooManySets:
        assume(False)
    area, moment = np.zeros(len(levels)), np.zeros(len(levels))
    for form in clipped_sets(output):
        height = levels[:, list(form.members)].min(axis=1)
        areas, moments = closed_form(form)
        area += form.sign * areas[height]
        moment += form.sign * (float(form.reference) * areas[height] + form.moment_sign * moments[height])
    y = moment / area
    off, area_off = numbers.area_slip * np.abs(y) + numbers.moment_slip, np.full(len(levels), numbers.area_slip)
    for s in numbers.sets:
        height = levels[:, list(s.form.members)].min(axis=1)
        lever = np.abs(float(s.form.reference) - y)
        own = lever * s.area_error[height] + s.moment_error[height]
        own += s.weight_error * closed_form(s.form)[0][height] + s.product_error
        off += np.where(height > 0, own, 0.0)
        area_off += np.where(height > 0, s.area_error[height], 0.0)
    raw = output.variable.raw
    assert raw.lo <= found.min() and found.max() <= raw.hi
    # Where rounding could eat the whole area, the numbers promise nothing.
    sound = area > 2 * area_off
    assert sound.mean() > 0.9
    position = [float(raw.position(output.variable.lo)), float(raw.position(output.variable.hi))]
    counts = abs(position[1] - position[0])
    exact = position[0] + (position[1] - position[0]) * np.clip(y, 0, 1)
    allowed = counts * off / np.where(sound, area - area_off, 1.0) + float(numbers.tail.error) + SLACK
    assert (np.abs(found - exact) <= allowed)[sound].all()
