"""The strength of a term inside one block of cells, as few minima and maxima of degrees as are found.

Between two neighbouring peaks of every input only the 2**n cells of the active terms can fire. Which of them name a
term is known when compiling, so its strength, the largest of the cells' smallest degrees, is one formula.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

Cells = frozenset[tuple[int, ...]]
"""Cells of a block that name one term: by input, 1 where the upper of its active terms stands, else 0."""


@dataclass(frozen=True, slots=True)
class Degree:
    """One of an input's two degrees: of the upper term, of the lower one, or the larger of them."""

    input: int
    which: str


@dataclass(frozen=True, slots=True)
class Lower:
    """The smaller of two."""

    left: Formula
    right: Formula


@dataclass(frozen=True, slots=True)
class Higher:
    """The larger of two."""

    left: Formula
    right: Formula


Formula = Degree | Lower | Higher


def formula(cells: Cells) -> Formula:
    """``max over cells of min over inputs``, simplified; for a set of at least one cell."""
    inputs = frozenset(range(len(next(iter(cells)))))
    found = _simplified(frozenset(frozenset(enumerate(c)) for c in cells), inputs)
    assert found is not None
    return found


Part = frozenset[tuple[int, int]]


@cache
def _simplified(cells: frozenset[Part], inputs: frozenset[int]) -> Formula | None:
    """The cheapest way to split along one input after the other; None stands for 1 (no input left)."""
    if not inputs:
        return None
    candidates: list[Formula] = []
    for i in sorted(inputs):
        rest = inputs - {i}
        low = frozenset(c - {(i, 0)} for c in cells if (i, 0) in c)
        high = frozenset(c - {(i, 1)} for c in cells if (i, 1) in c)
        both = low & high
        if low == high:
            candidates.append(_within(Degree(i, "larger"), _simplified(low, rest)))
            continue
        sides = [(Degree(i, "lower"), low), (Degree(i, "upper"), high)]
        parts = [_within(d, _simplified(side, rest)) for d, side in sides if side]
        candidates.append(_either(parts))
        if both:
            # What both sides have does not ask which side it is.
            shared = _within(Degree(i, "larger"), _simplified(both, rest))
            own = [_within(d, _simplified(side - both, rest)) for d, side in sides if side - both]
            candidates.append(_either([shared, *own]))
    return min(candidates, key=cost)


def _within(degree: Degree, rest: Formula | None) -> Formula:
    return degree if rest is None else Lower(degree, rest)


def _either(parts: list[Formula]) -> Formula:
    found = parts[0]
    for part in parts[1:]:
        found = Higher(found, part)
    return found


def cost(found: Formula) -> int:
    """Minima and maxima in it; the larger of two degrees is one too."""
    match found:
        case Degree():
            return int(found.which == "larger")
        case Lower() | Higher():
            return 1 + cost(found.left) + cost(found.right)
