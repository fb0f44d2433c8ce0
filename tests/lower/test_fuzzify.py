"""Raws to degrees."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fuzzyspec.exact.membership import degree
from fuzzyspec.fixed.program import Const
from fuzzyspec.lower.fuzzify import fuzzify
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.controller import Input
from fuzzyspec.model.term import PiecewiseLinear, Singleton
from fuzzyspec.model.units import ONE
from fuzzyspec.model.variable import Raw, Variable
from tests.lower.lower_models import NOWHERE, ends_are_legal, input_of, membership, peaks, shapes, terms, variables
from tests.lower.lower_running import given as reading
from tests.lower.lower_running import outcome

NEAR = 1e-6
"""Where float64 does not tell on which side of a bound a case is, it is evaluated in rationals."""
F = Fraction


def degrees(item: Input, dense: bool) -> tuple[np.ndarray, np.ndarray, tuple[Fraction, ...]]:
    """All legal raws, the integer degree of every term there (terms, raws), and its stated error."""
    raw = item.variable.raw
    start, local = reading("raw", raw.ctype, raw.lo, raw.hi)
    body, found = fuzzify(item, local, Scope(), dense)
    raws = np.arange(raw.lo, raw.hi + 1)
    results = {f"s{j}": found.slot(Const(j)) for j in range(found.slots)}
    seen = outcome([start, *body], results | {"first": found.first}, {"raw": raws})
    table = np.zeros((len(item.terms), len(raws)), dtype=np.int64)
    for j in range(found.slots):
        table[seen["first"] + j, np.arange(len(raws))] = seen[f"s{j}"]
    return raws, table, found.errors


def holds(item: Input, dense: bool = True) -> None:
    """Every degree of every term at every legal raw is within the stated error, and exact where it is 0 or 1."""
    raws, table, errors = degrees(item, dense)
    raw = item.variable.raw
    values = np.array([float(raw.value(int(r))) for r in raws])
    for row, term, error in zip(table, item.terms, errors, strict=True):
        exact = degree(term.shape, values.copy())
        assert row.min() >= 0 and row.max() <= DEGREE_ONE
        beyond = np.abs(row / DEGREE_ONE - exact) > float(error) - NEAR
        wrong_end = ((exact < NEAR) & (row != 0)) | ((exact > 1 - NEAR) & (row != DEGREE_ONE))
        # At a jump the float64 value may lie on the other side: rationals decide, at every suspect.
        for at in np.flatnonzero(beyond | wrong_end)[:400]:
            true = membership(term.shape, raw.value(int(raws[at])))
            assert abs(F(int(row[at]), DEGREE_ONE) - true) <= error, (int(raws[at]), true)
            if true in (0, 1):
                assert row[at] == true * DEGREE_ONE, (int(raws[at]), true)


@settings(max_examples=60)
@given(data=st.data(), dense=st.booleans())
def test_partitions(data: st.DataObject, dense: bool) -> None:
    """Strong partitions over any raw: peaks that are raws or not, close or far, on the ends or inside."""
    variable = data.draw(variables())
    assert ends_are_legal(variable)
    holds(input_of(variable, data.draw(peaks(variable))), dense)


@settings(max_examples=40)
@given(data=st.data())
def test_two_neighbours_of_a_partition_sum_to_1(data: st.DataObject) -> None:
    """In a strong partition the degrees of every raw sum to exactly 1, and at most two are positive."""
    variable = data.draw(variables(most=2000))
    _, table, _ = degrees(input_of(variable, data.draw(peaks(variable))), dense=data.draw(st.booleans()))
    assert (table.sum(axis=0) == DEGREE_ONE).all()
    assert ((table > 0).sum(axis=0) <= 2).all()


@settings(max_examples=80)
@given(data=st.data())
def test_irregular_shapes(data: st.DataObject) -> None:
    """Any points: jumps at raws and between them, spikes, plateaus, shapes that stick out, points all at one place."""
    variable = data.draw(variables(most=data.draw(st.sampled_from([3, 20, 300, 65535]))))
    own = data.draw(st.lists(shapes(variable), min_size=1, max_size=3))
    holds(Input(variable, terms(own), None))


@settings(max_examples=60)
@given(data=st.data())
def test_jumps_and_spikes_at_raws(data: st.DataObject) -> None:
    """Where several points share a raw, the largest value holds there, alone if need be; the sides begin beside it."""
    variable = data.draw(variables(most=40))
    raw = variable.raw
    few = st.integers(raw.lo - 1, min(raw.hi, raw.lo + 4) + 1)
    counts = sorted(data.draw(st.lists(few, min_size=2, max_size=8)), reverse=raw.step < 0)
    heights = st.sampled_from([F(0), F(1), F(1, 3), F(9, 10)])
    points = tuple((raw.value(c), data.draw(heights)) for c in counts)
    holds(Input(variable, terms([PiecewiseLinear(points)]), None))


@pytest.mark.parametrize("backwards", [False, True])
def test_a_singleton_is_met_by_its_raw_alone(backwards: bool) -> None:
    """A singleton at a raw has degree 1 there and 0 elsewhere; between raws it is never met."""
    step = F(-1, 4) if backwards else F(1, 4)
    variable = Variable("x", F(0), F(2), ONE, Raw("uint8", step, F(2) if backwards else F(0), 0, 8), NOWHERE)
    holds(Input(variable, terms([Singleton(F(1, 2)), Singleton(F(3, 8)), Singleton(F(0)), Singleton(F(5))]), None))
    _, table, _ = degrees(Input(variable, terms([Singleton(F(1, 2)), Singleton(F(3, 8))]), None), True)
    assert table.sum(axis=1).tolist() == [DEGREE_ONE, 0]


@settings(max_examples=25)
@given(data=st.data())
def test_a_repeated_height_1_is_kept(data: st.DataObject) -> None:
    """Trapezoids are exactly 1 on their whole plateau, and exactly 0 from their feet on, at every raw."""
    variable = data.draw(variables())
    span = variable.hi - variable.lo
    a, b, c, d = sorted(data.draw(st.lists(st.fractions(0, 1, max_denominator=50), min_size=4, max_size=4)))
    assume(a < d)
    corners = [(variable.lo + span * p, F(y)) for p, y in ((a, 0), (b, 1), (c, 1), (d, 0))]
    raws, table, _ = degrees(Input(variable, terms([PiecewiseLinear(tuple(corners))]), None), True)
    position = [variable.raw.position(x) for x, _ in corners]
    if variable.raw.step < 0:
        position.reverse()
    lowest, plateau, ends, highest = position
    for r, y in zip(raws.tolist(), table[0].tolist(), strict=True):
        if plateau <= r <= ends:
            assert y == DEGREE_ONE
        elif r <= lowest or r >= highest:
            assert y == 0
