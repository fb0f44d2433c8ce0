"""The formula of a term's strength inside a block of cells."""

from __future__ import annotations

from itertools import product
from math import prod
from typing import assert_never

from hypothesis import given
from hypothesis import strategies as st

from fuzzyspec.lower.lattice import (
    Cells,
    Degree,
    Formula,
    Higher,
    Lower,
    Rest,
    cost,
    degrees_in,
    formula,
    of_sentence,
    terms_in,
)
from fuzzyspec.model.controller import And, Antecedent, Is, Not, Or

ONE = 8
TERMS = (3, 2)


@st.composite
def blocks(draw: st.DrawFn) -> tuple[Cells, list[list[float]]]:
    """Some cells of a block of 1 to 4 inputs with 1 to 3 active terms each, and the degrees of these."""
    sizes = draw(st.lists(st.integers(1, 3), min_size=1, max_size=4))
    corners = list(product(*map(range, sizes)))
    named = draw(st.sets(st.sampled_from(corners), min_size=1))
    return Cells(named), [draw(st.lists(st.floats(0, 1), min_size=n, max_size=n)) for n in sizes]


def value(found: Formula, degrees: list[list[float]], one: float = 1) -> float:
    """What a formula says."""
    match found:
        case Degree():
            return max(degrees[found.input][place] for place in found.which)
        case Higher(left, right):
            return max(value(left, degrees, one), value(right, degrees, one))
        case Lower(left, right):
            return min(value(left, degrees, one), value(right, degrees, one))
        case Rest(of):
            return one - value(of, degrees, one)
        case _:
            assert_never(found)


def meant(node: Antecedent, degrees: list[list[int]]) -> int:
    """What an antecedent says of the degrees of all terms."""
    match node:
        case Is(i, terms):
            return max(degrees[i][t] for t in terms)
        case Not(operand):
            return ONE - meant(operand, degrees)
        case And(operands):
            return min(meant(o, degrees) for o in operands)
        case Or(operands):
            return max(meant(o, degrees) for o in operands)
        case _:
            assert_never(node)


def literal(i: int) -> st.SearchStrategy[Antecedent]:
    """An input has one or more of its terms."""
    return st.lists(st.integers(0, TERMS[i] - 1), min_size=1, max_size=2, unique=True).map(lambda t: Is(i, tuple(t)))


ANTECEDENTS: st.SearchStrategy[Antecedent] = st.recursive(
    st.integers(0, len(TERMS) - 1).flatmap(literal),
    lambda inner: st.one_of(
        inner.map(Not),
        st.lists(inner, min_size=2, max_size=3).map(lambda parts: And(tuple(parts))),
        st.lists(inner, min_size=2, max_size=3).map(lambda parts: Or(tuple(parts))),
    ),
    max_leaves=8,
)


@given(node=ANTECEDENTS, data=st.data())
def test_the_formula_of_a_sentence_says_what_the_sentence_says(node: Antecedent, data: st.DataObject) -> None:
    """With terms that are not active, of degree 0, left out: a strength that is settled so, or one of the active
    terms that the sentence names."""
    active = [tuple(sorted(data.draw(st.sets(st.integers(0, n - 1))))) for n in TERMS]
    degrees = [[data.draw(st.integers(0, ONE)) if t in active[i] else 0 for t in range(n)] for i, n in enumerate(TERMS)]
    found = of_sentence(node, active)
    if isinstance(found, bool):
        assert meant(node, degrees) == ONE * found
        return
    places: list[list[float]] = [[degrees[i][t] for t in terms] for i, terms in enumerate(active)]
    assert value(found, places, ONE) == meant(node, degrees)
    assert {(i, active[i][place]) for i, place in degrees_in(found)} <= set(terms_in(node))


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
