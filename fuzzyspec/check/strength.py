"""The rules that set one output, and the strongest strength among them at a point: exact, in rationals."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from fuzzyspec.check.degrees import Side, degree
from fuzzyspec.model.controller import And, Antecedent, CellRules, Inference, Input, Is, Not, Or, SentenceRule

ZERO, ONE = Fraction(0), Fraction(1)


@dataclass(frozen=True)
class Spot:
    """A point of the input space; a side other than 0 means the limit there from that side."""

    at: tuple[Fraction, ...]
    sides: tuple[Side, ...]


@dataclass(frozen=True)
class Setters:
    """All that sets one output: ``cells`` is a mask over the antecedent space, or None; ``sentences`` the rules."""

    inputs: tuple[Input, ...]
    infer: Inference
    cells: NDArray[np.bool_] | None
    sentences: tuple[SentenceRule, ...]

    @property
    def used(self) -> tuple[bool, ...]:
        """For each input, whether the strengths depend on it at all."""
        if self.cells is not None and self.cells.any():
            return tuple(True for _ in self.inputs)
        asked = {i for rule in self.sentences for i in _asked(rule.antecedent)}
        return tuple(i in asked for i in range(len(self.inputs)))


def setters_of(
    output: int,
    inputs: tuple[Input, ...],
    infer: Inference,
    cells: CellRules | None,
    sentences: tuple[SentenceRule, ...],
) -> Setters:
    """The part of a rule base that sets an output."""
    mask = None if cells is None else (np.array(cells.consequents[output]) != -1).reshape(cells.shape)
    return Setters(inputs, infer, mask, tuple(s for s in sentences if any(o == output for o, _ in s.consequents)))


def strongest(setters: Setters, spot: Spot) -> Fraction:
    """The strongest strength of all rules that set the output."""
    degrees = [
        [degree(term.shape, x, side) for term in variable.terms]
        for variable, x, side in zip(setters.inputs, spot.at, spot.sides, strict=True)
    ]
    best = max((rule_strength(rule, degrees, setters.infer) for rule in setters.sentences), default=ZERO)
    if setters.cells is not None:
        active = [[t for t, d in enumerate(ds) if d > 0] for ds in degrees]
        for cell in itertools.product(*active):
            if setters.cells[cell]:
                best = max(best, conjunction([ds[t] for ds, t in zip(degrees, cell, strict=True)], setters.infer))
    return best


def rule_strength(rule: SentenceRule, degrees: Sequence[Sequence[Fraction]], infer: Inference) -> Fraction:
    """Strength of a sentence rule, its weight included."""
    truth = _truth(rule.antecedent, degrees, infer)
    return rule.weight * truth if truth else truth


def conjunction(values: Sequence[Fraction], infer: Inference) -> Fraction:
    """``and`` over degrees."""
    match infer.and_:
        case "min":
            return min(values)
        case "product":
            return reduce(lambda a, b: a * b, values, ONE)
        case _:
            assert_never(infer.and_)


def disjunction(values: Sequence[Fraction], infer: Inference) -> Fraction:
    """``or`` over degrees."""
    match infer.or_:
        case "max":
            return max(values)
        case "probsum":
            return ONE - reduce(lambda a, b: a * (ONE - b), values, ONE)
        case _:
            assert_never(infer.or_)


def _truth(antecedent: Antecedent, degrees: Sequence[Sequence[Fraction]], infer: Inference) -> Fraction:
    """Of an ``and`` no more is asked than up to its first 0, which is what most rules come to."""
    match antecedent:
        case Is(index, terms):
            return disjunction([degrees[index][t] for t in terms], infer)
        case Not(operand):
            return ONE - _truth(operand, degrees, infer)
        case And(operands):
            values: list[Fraction] = []
            for operand in operands:
                values.append(_truth(operand, degrees, infer))
                if not values[-1]:
                    return ZERO
            return conjunction(values, infer)
        case Or(operands):
            return disjunction([_truth(o, degrees, infer) for o in operands], infer)
        case _:
            assert_never(antecedent)


def _asked(antecedent: Antecedent) -> set[int]:
    match antecedent:
        case Is(index, _):
            return {index}
        case Not(operand):
            return _asked(operand)
        case And(operands) | Or(operands):
            return set().union(*(_asked(o) for o in operands))
        case _:
            assert_never(antecedent)
