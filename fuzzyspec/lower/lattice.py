"""The strength of a term inside one block of cells, as few minima and maxima of degrees as are found.

Between two neighbouring peaks of every input (or wherever else it is known which terms are active) few cells can fire.
Which of them name a term is known when compiling, so its strength, the largest of the cells' smallest degrees, is one
formula.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import assert_never

from fuzzyspec.model.controller import And, Antecedent, Is, Not, Or

Cells = frozenset[tuple[int, ...]]
"""Cells of a block that name one term: by input, the place of its term among those that may be active in the block."""


@dataclass(frozen=True, slots=True)
class Degree:
    """The largest degree of some of an input's active terms, by their places (one or more, rising)."""

    input: int
    which: tuple[int, ...]


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


@dataclass(frozen=True, slots=True)
class Rest:
    """What is left to 1."""

    of: Formula


Formula = Degree | Lower | Higher | Rest


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
        sides: dict[int, frozenset[Part]] = {}
        for place in sorted({at for c in cells for j, at in c if j == i}):
            sides[place] = frozenset(c - {(i, place)} for c in cells if (i, place) in c)
        candidates.append(_either(_parts(i, sides, rest)))
        both = frozenset.intersection(*sides.values())
        if both and len(set(sides.values())) > 1:
            # What all sides have does not ask which side it is.
            shared = _within(Degree(i, tuple(sides)), _simplified(both, rest))
            own = _parts(i, {place: side - both for place, side in sides.items() if side - both}, rest)
            candidates.append(_either([shared, *own]))
    return min(candidates, key=cost)


def _parts(i: int, sides: dict[int, frozenset[Part]], rest: frozenset[int]) -> list[Formula]:
    """A formula for each side; places with the same one share it."""
    places: dict[frozenset[Part], tuple[int, ...]] = {}
    for place, side in sides.items():
        places[side] = (*places.get(side, ()), place)
    return [_within(Degree(i, at), _simplified(side, rest)) for side, at in places.items()]


def _within(degree: Degree, rest: Formula | None) -> Formula:
    return degree if rest is None else Lower(degree, rest)


def _either(parts: list[Formula]) -> Formula:
    found = parts[0]
    for part in parts[1:]:
        found = Higher(found, part)
    return found


def cost(found: Formula) -> int:
    """Minima and maxima in it; those that the largest of some degrees takes too."""
    match found:
        case Degree():
            return len(found.which) - 1
        case Lower() | Higher():
            return 1 + cost(found.left) + cost(found.right)
        case Rest():
            return 1 + cost(found.of)


def of_sentence(node: Antecedent, active: Sequence[tuple[int, ...]]) -> Formula | bool:
    """An antecedent where by input only these terms are active; a bool where its strength is 0 or 1 whatever they are.

    As of cells, ``or`` is the largest and ``and`` the smallest.
    """
    match node:
        case Is(i, terms):
            which = tuple(place for place, term in enumerate(active[i]) if term in terms)
            return Degree(i, which) if which else False
        case Not(operand):
            found = of_sentence(operand, active)
            return not found if isinstance(found, bool) else found.of if isinstance(found, Rest) else Rest(found)
        case And(operands):
            return joined(Lower, [of_sentence(o, active) for o in operands])
        case Or(operands):
            return joined(Higher, [of_sentence(o, active) for o in operands])
        case _:
            assert_never(node)


def joined(by: type[Lower | Higher], parts: Sequence[Formula | bool]) -> Formula | bool:
    """The smallest or the largest of formulas, each taken once; for at least one of them."""
    settles = by is Higher
    if settles in parts:
        return settles
    first, *others = dict.fromkeys(p for p in parts if not isinstance(p, bool)) or [not settles]
    found: Formula | bool = first
    for other in others:
        assert not isinstance(found, bool)
        assert not isinstance(other, bool)
        found = by(found, other)
    return found


def degrees_in(found: Formula) -> Iterator[tuple[int, int]]:
    """The inputs and places of the degrees that a formula reads."""
    match found:
        case Degree(i, which):
            yield from ((i, place) for place in which)
        case Lower(left, right) | Higher(left, right):
            yield from degrees_in(left)
            yield from degrees_in(right)
        case Rest(of):
            yield from degrees_in(of)
        case _:
            assert_never(found)


def terms_in(node: Antecedent) -> Iterator[tuple[int, int]]:
    """The inputs and terms that an antecedent names."""
    match node:
        case Is(i, terms):
            yield from ((i, term) for term in terms)
        case Not(operand):
            yield from terms_in(operand)
        case And(operands) | Or(operands):
            for operand in operands:
                yield from terms_in(operand)
        case _:
            assert_never(node)
