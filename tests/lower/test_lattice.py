"""The formula of a term's strength inside a block of cells."""

from __future__ import annotations

from itertools import product
from math import prod

from hypothesis import given
from hypothesis import strategies as st

from fuzzyspec.lower.lattice import Cells, Degree, Formula, Higher, cost, formula


@st.composite
def blocks(draw: st.DrawFn) -> tuple[Cells, list[list[float]]]:
    """Some cells of a block of 1 to 4 inputs with 1 to 3 active terms each, and the degrees of these."""
    sizes = draw(st.lists(st.integers(1, 3), min_size=1, max_size=4))
    corners = list(product(*map(range, sizes)))
    named = draw(st.sets(st.sampled_from(corners), min_size=1))
    return Cells(named), [draw(st.lists(st.floats(0, 1), min_size=n, max_size=n)) for n in sizes]


def value(found: Formula, degrees: list[list[float]]) -> float:
    """What a formula says."""
    match found:
        case Degree():
            return max(degrees[found.input][place] for place in found.which)
        case Higher():
            return max(value(found.left, degrees), value(found.right, degrees))
    return min(value(found.left, degrees), value(found.right, degrees))


@given(block=blocks())
def test_a_formula_is_the_largest_of_the_cells_smallest_degrees(block: tuple[Cells, list[list[float]]]) -> None:
    """For any cells and any degrees the formula has the value of its definition."""
    cells, degrees = block
    defined = max(min(d[at] for at, d in zip(c, degrees, strict=True)) for c in cells)
    assert value(formula(cells), degrees) == defined


@given(block=blocks())
def test_a_formula_costs_no_more_than_its_definition(block: tuple[Cells, list[list[float]]]) -> None:
    """Never more minima and maxima than cell by cell, and a whole block takes one for a degree at most."""
    cells, degrees = block
    assert cost(formula(cells)) <= len(cells) * len(degrees) - 1 + (len(cells) > 1) * sum(map(len, degrees))
    if len(cells) == prod(map(len, degrees)):
        assert cost(formula(cells)) == sum(map(len, degrees)) - 1
