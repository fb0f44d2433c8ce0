"""Which rules fire, how strongly, and for whom."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache, reduce
from typing import Literal, assert_never

import numpy as np

from fuzzyspec.exact.membership import degrees, regions
from fuzzyspec.exact.result import Floats, Ints
from fuzzyspec.model.controller import And, Antecedent, CellRules, Controller, Inference, Is, Not, Or


@dataclass(frozen=True, slots=True)
class Fired:
    """At most one rule in each of N cases.

    ``strength`` is (N,), weighted. ``consequents`` are (output, terms): one term for all cases, or (N,) with -1 where
    that case's rule leaves the output unset. ``owner`` is the (N,) behavior codes, None for sentences.
    """

    strength: Floats
    consequents: tuple[tuple[int, Ints | int], ...]
    owner: Ints | None


def fired(controller: Controller, values: list[Floats]) -> Iterator[Fired]:
    """Every rule whose strength can be positive at ``values`` (one (N,) array an input, inside its range)."""
    inputs = [degrees(inp, value) for inp, value in zip(controller.inputs, values, strict=True)]
    if controller.cells is not None:
        yield from _cells(controller, controller.cells, values, inputs)
    for rule in controller.sentences:
        strength = _truth(rule.antecedent, controller.infer, inputs)
        if rule.weight != 1:
            strength = strength * float(rule.weight)
        yield Fired(strength, rule.consequents, None)


@lru_cache(maxsize=256)
def _tables(cells: CellRules) -> tuple[Ints, Ints]:
    """(outputs, cells) terms and (cells,) owners."""
    terms = np.array(cells.consequents, dtype=np.int64).reshape(len(cells.consequents), -1)
    return terms, np.array(cells.owner, dtype=np.int64)


def _cells(controller: Controller, cells: CellRules, values: list[Floats], inputs: list[Floats]) -> Iterator[Fired]:
    """One ``Fired`` for each way to pick an active term of every input; cells beside these have strength 0."""
    consequents, owners = _tables(cells)
    lanes = np.arange(len(values[0]))
    # per input and slot: the degree, and the term's share of the flat cell number
    slots: list[list[tuple[Floats, Ints]]] = []
    stride = int(np.prod(cells.shape))
    for inp, value, degree, size in zip(controller.inputs, values, inputs, cells.shape, strict=True):
        stride //= size
        slots.append([(degree[terms, lanes], terms * stride) for terms in regions(inp).at(value)])
    for corner in itertools.product(*slots):
        strength = reduce(_AND[controller.infer.and_], (d for d, _ in corner))
        cell = reduce(np.add, (share for _, share in corner))
        yield Fired(strength, tuple(enumerate(consequents[:, cell])), owners[cell])


def _product(a: Floats, b: Floats) -> Floats:
    return a * b


def _least(a: Floats, b: Floats) -> Floats:
    return np.minimum(a, b)


def _greatest(a: Floats, b: Floats) -> Floats:
    return np.maximum(a, b)


def _probsum(a: Floats, b: Floats) -> Floats:
    return a + b - a * b


_AND = {"min": _least, "product": _product}
_OR = {"max": _greatest, "probsum": _probsum}


def _truth(antecedent: Antecedent, infer: Inference, inputs: list[Floats]) -> Floats:
    match antecedent:
        case Is(number, terms):
            return reduce(_OR[infer.or_], (inputs[number][t] for t in terms))
        case Not(operand):
            return 1.0 - _truth(operand, infer, inputs)
        case And(operands):
            return reduce(_AND[infer.and_], (_truth(o, infer, inputs) for o in operands))
        case Or(operands):
            return reduce(_OR[infer.or_], (_truth(o, infer, inputs) for o in operands))
        case _:
            assert_never(antecedent)


class Levels:
    """The level that each term of one output is raised to, joined over the rules by ``how``."""

    def __init__(self, terms: int, cases: int, how: Literal["max", "sum"]) -> None:
        # the last row takes what -1 (unset) points to
        self._rows = np.zeros((terms + 1, cases))
        self._join = _greatest if how == "max" else np.add
        self._lanes = np.arange(cases)

    def raise_to(self, terms: Ints | int, strength: Floats) -> None:
        if isinstance(terms, int):
            self._rows[terms] = self._join(self._rows[terms], strength)
        else:
            self._rows[terms, self._lanes] = self._join(self._rows[terms, self._lanes], strength)

    @property
    def rows(self) -> Floats:
        """(terms, N)."""
        return self._rows[:-1]
