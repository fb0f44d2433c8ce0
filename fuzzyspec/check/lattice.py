"""The smallest strongest-strength where only min, max and complements join the degrees: found exactly.

Then the strength is a lattice polynomial S in literals, each a piecewise-linear function of one input (a degree, its
complement, either times a rule's weight). Let S reach its minimum m at x, and for one input keep the set A of its
literals that are at most m there. S stays at most m wherever the literals of A do, since S only looks at which
literals exceed m; and the upper envelope of A is least at a corner, a limit at a jump, or a crossing of two literals.
So the minimum over the continuous range is the minimum over the finite grid of such places. Values are compared by
their rank among all values that occur, so nothing is rounded.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from fractions import Fraction
from math import prod
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from fuzzyspec.check.degrees import Side, degree, points
from fuzzyspec.check.strength import ONE, ZERO, Setters, Spot
from fuzzyspec.model.controller import And, Antecedent, Inference, Input, Is, Not, Or

Ints = NDArray[np.int64]

MOST_WORK = 20_000_000
"""Grid places times rules; about half a second."""


@dataclass(frozen=True, slots=True)
class Literal:
    """``weight * degree`` of a term of an input, or ``weight * (1 - degree)``."""

    input: int
    term: int
    negated: bool
    weight: Fraction

    def value(self, inputs: tuple[Input, ...], x: Fraction, side: Side) -> Fraction:
        d = degree(inputs[self.input].terms[self.term].shape, x, side)
        return self.weight * (ONE - d if self.negated else d)


@dataclass(frozen=True, slots=True)
class Meet:
    operands: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Join:
    operands: tuple[Formula, ...]


Formula = Literal | Meet | Join


def lattice_floor(setters: Setters) -> tuple[Fraction, Spot] | None:
    """The infimum of the strongest strength over the whole input range and a spot where it is reached.

    None where the strength is no lattice polynomial, or where the grid would be too large.
    """
    formulas = []
    for rule in setters.sentences:
        formula = _formula(rule.antecedent, False, rule.weight, setters.infer)
        if formula is None:
            return None
        formulas.append(formula)
    by_cell = setters.cells is not None and bool(setters.cells.any())
    if by_cell and setters.infer.and_ != "min" and len(setters.inputs) > 1:
        return None

    literals = {leaf for formula in formulas for leaf in _leaves(formula)}
    if by_cell:
        literals |= {Literal(i, t, False, ONE) for i, v in enumerate(setters.inputs) for t in range(len(v.terms))}
    places = [
        critical_places(v, [x for x in literals if x.input == i], setters.inputs) for i, v in enumerate(setters.inputs)
    ]
    rules = len(formulas) + (sum(len(v.terms) for v in setters.inputs) if by_cell else 0)
    if prod(len(p) for p in places) * rules > MOST_WORK:
        return None

    values = {
        literal: [literal.value(setters.inputs, x, side) for x, side in places[literal.input]] for literal in literals
    }
    ladder = sorted({ZERO, ONE}.union(*values.values()))
    rank = {value: index for index, value in enumerate(ladder)}
    axes = len(setters.inputs)
    ranks = {
        literal: np.array([rank[v] for v in vs], dtype=np.int64).reshape(_along(literal.input, axes, len(vs)))
        for literal, vs in values.items()
    }
    best: Ints = np.zeros((1,) * axes, dtype=np.int64)
    for formula in formulas:
        best = np.maximum(best, _evaluate(formula, ranks))
    if by_cell and setters.cells is not None:
        best = np.maximum(best, _evaluate_cells(setters.cells, ranks, rank[ONE]))
    lowest = np.unravel_index(int(np.argmin(best)), best.shape)
    chosen = [places[i][int(k)] for i, k in enumerate(lowest)]
    return ladder[int(best[lowest])], Spot(tuple(x for x, _ in chosen), tuple(s for _, s in chosen))


def critical_places(variable: Input, literals: list[Literal], inputs: tuple[Input, ...]) -> list[tuple[Fraction, Side]]:
    """Corners, limits at jumps, crossings of any two literals, and the range's ends; one place where there are no
    literals.
    """
    lo, hi = variable.variable.lo, variable.variable.hi
    if not literals:
        return [((lo + hi) / 2, 0)]
    corners = {lo, hi}
    jumps: set[Fraction] = set()
    for literal in literals:
        xs = [x for x, _ in points(variable.terms[literal.term].shape)]
        corners.update(x for x in xs if lo <= x <= hi)
        jumps.update(a for a, b in itertools.pairwise(xs) if a == b and lo <= a <= hi)
    ordered = sorted(corners)
    found: set[tuple[Fraction, Side]] = {(x, 0) for x in ordered}
    found |= {(x, 1) for x in jumps if x < hi} | {(x, -1) for x in jumps if x > lo}
    for a, b in itertools.pairwise(ordered):
        ends = {(x.value(inputs, a, 1), x.value(inputs, b, -1)) for x in literals}
        for (p0, p1), (q0, q1) in itertools.combinations(ends, 2):
            if (p0 - q0) * (p1 - q1) < 0:
                found.add((a + (b - a) * (p0 - q0) / ((p0 - q0) - (p1 - q1)), 0))
    return sorted(found)


def _formula(antecedent: Antecedent, negated: bool, weight: Fraction, infer: Inference) -> Formula | None:
    """Complements and the weight pushed down to the literals, by De Morgan; None where a norm is none of the
    lattice's.
    """
    match antecedent:
        case Is(index, terms):
            if len(terms) > 1 and infer.or_ != "max":
                return None
            leaves = tuple(Literal(index, t, negated, weight) for t in terms)
            return leaves[0] if len(leaves) == 1 else Meet(leaves) if negated else Join(leaves)
        case Not(operand):
            return _formula(operand, not negated, weight, infer)
        case And(operands) | Or(operands):
            norm = infer.and_ == "min" if isinstance(antecedent, And) else infer.or_ == "max"
            parts = [_formula(operand, negated, weight, infer) for operand in operands]
            known = tuple(p for p in parts if p is not None)
            if len(known) != len(parts) or (len(parts) > 1 and not norm):
                return None
            return Meet(known) if isinstance(antecedent, And) != negated else Join(known)
        case _:
            assert_never(antecedent)


def _leaves(formula: Formula) -> set[Literal]:
    match formula:
        case Literal():
            return {formula}
        case Meet(operands) | Join(operands):
            return set().union(*(_leaves(o) for o in operands))
        case _:
            assert_never(formula)


def _evaluate(formula: Formula, ranks: dict[Literal, Ints]) -> Ints:
    match formula:
        case Literal():
            return ranks[formula]
        case Meet(operands):
            found = _evaluate(operands[0], ranks)
            for operand in operands[1:]:
                found = np.minimum(found, _evaluate(operand, ranks))
            return found
        case Join(operands):
            found = _evaluate(operands[0], ranks)
            for operand in operands[1:]:
                found = np.maximum(found, _evaluate(operand, ranks))
            return found
        case _:
            assert_never(formula)


def _evaluate_cells(mask: NDArray[np.bool_], ranks: dict[Literal, Ints], top: int) -> Ints:
    """Max over the cells of the min over the inputs, one input at a time."""
    found: Ints = np.where(mask, top, 0).astype(np.int64)
    for axis in range(mask.ndim):
        joined: Ints | None = None
        for term in range(mask.shape[axis]):
            part = np.minimum(np.take(found, [term], axis=axis), ranks[Literal(axis, term, False, ONE)])
            joined = part if joined is None else np.maximum(joined, part)
        assert joined is not None
        found = joined
    return found


def _along(axis: int, axes: int, length: int) -> tuple[int, ...]:
    return tuple(length if a == axis else 1 for a in range(axes))
