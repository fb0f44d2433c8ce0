"""The formula of a term's strength inside a block of cells."""

from __future__ import annotations

from itertools import product

from hypothesis import given
from hypothesis import strategies as st

from fuzzyspec.lower.lattice import Cells, Degree, Formula, Higher, cost, formula


@st.composite
def blocks(draw: st.DrawFn) -> tuple[Cells, list[float]]:
    """Some cells of a block of 1 to 4 inputs, and a degree of every input's upper term."""
    inputs = draw(st.integers(1, 4))
    corners = list(product((0, 1), repeat=inputs))
    named = draw(st.sets(st.sampled_from(corners), min_size=1))
    return Cells(named), draw(st.lists(st.floats(0, 1), min_size=inputs, max_size=inputs))


def value(found: Formula, upper: list[float]) -> float:
    """What a formula says."""
    match found:
        case Degree():
            d = upper[found.input]
            return {"upper": d, "lower": 1 - d, "larger": max(d, 1 - d)}[found.which]
        case Higher():
            return max(value(found.left, upper), value(found.right, upper))
    return min(value(found.left, upper), value(found.right, upper))


@given(block=blocks())
def test_a_formula_is_the_largest_of_the_cells_smallest_degrees(block: tuple[Cells, list[float]]) -> None:
    """For any cells and any degrees the formula has the value of its definition."""
    cells, upper = block
    defined = max(min(d if side else 1 - d for side, d in zip(c, upper, strict=True)) for c in cells)
    assert value(formula(cells), upper) == defined


@given(block=blocks())
def test_a_formula_costs_no_more_than_its_definition(block: tuple[Cells, list[float]]) -> None:
    """Never more minima and maxima than cell by cell, and a whole block takes two for an input at most."""
    cells, upper = block
    assert cost(formula(cells)) <= len(cells) * len(upper) - 1 + (len(cells) > 1) * len(upper)
    if len(cells) == 2 ** len(upper):
        assert cost(formula(cells)) == 2 * len(upper) - 1
