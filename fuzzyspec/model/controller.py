"""A checked controller: every name resolved, every cell decided, every number exact."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.model.account import Account
from fuzzyspec.model.budget import Budget
from fuzzyspec.model.term import Term
from fuzzyspec.model.variable import Variable


@dataclass(frozen=True, slots=True)
class Input:
    """An input and its terms.

    ``peaks`` is set where the terms were given as a ``partition`` (a strong partition by triangles, the ends
    shouldered): strictly increasing, one for each term, in the variable's unit. Otherwise None.
    """

    variable: Variable
    terms: tuple[Term, ...]
    peaks: tuple[Fraction, ...] | None

    @property
    def name(self) -> str:
        return self.variable.name


@dataclass(frozen=True, slots=True)
class Fallback:
    """What an output is when nothing fires: a constant, or (``hold``) its last raw, at first ``value``."""

    value: Fraction
    hold: bool


@dataclass(frozen=True, slots=True)
class Output:
    """An output and its terms.

    Centroids integrate over ``[integrate_lo, integrate_hi]``: the range, widened on each side by the outer half
    of the end term where the partition is ``full`` (the end terms' shapes are then whole triangles; no other
    term reaches beyond the range there). ``peaks`` as for inputs.
    """

    variable: Variable
    terms: tuple[Term, ...]
    peaks: tuple[Fraction, ...] | None
    full: bool
    integrate_lo: Fraction
    integrate_hi: Fraction
    fallback: Fallback | None

    @property
    def name(self) -> str:
        return self.variable.name


@dataclass(frozen=True, slots=True)
class Inference:
    """Norms and methods. Weighted average goes with singletons, centroid with shapes."""

    and_: Literal["min", "product"] = "min"
    or_: Literal["max", "probsum"] = "max"
    implies: Literal["min", "product"] = "min"
    aggregate: Literal["max", "sum"] = "max"
    defuzzify: Literal["centroid", "weighted_average"] = "centroid"


@dataclass(frozen=True, slots=True)
class Behavior:
    """``code`` is what ``acting`` reports: 1 for the highest priority downwards."""

    name: str
    code: int
    priority: int | None
    """None for the entry ``table`` that stands for the tables beside behaviors."""
    span: Span


@dataclass(frozen=True, slots=True)
class CellRules:
    """The antecedent space after priorities: one rule a cell.

    ``shape`` is the number of terms of each input, in the controller's input order; cells are flat, row-major (the
    last input runs fastest). ``consequents[o][cell]`` is the index of the term that output ``o`` takes there, -1
    where it is left unset. ``owner[cell]`` is the code of the behavior that won the cell, 0 where there are
    no behaviors or nobody claims it.
    """

    shape: tuple[int, ...]
    consequents: tuple[tuple[int, ...], ...]
    owner: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Is:
    """Input ``input`` has one of ``terms`` (indices): their degrees joined by ``or``."""

    input: int
    terms: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Not:
    operand: Antecedent


@dataclass(frozen=True, slots=True)
class And:
    operands: tuple[Antecedent, ...]


@dataclass(frozen=True, slots=True)
class Or:
    operands: tuple[Antecedent, ...]


Antecedent = Is | Not | And | Or


@dataclass(frozen=True, slots=True)
class SentenceRule:
    """``if antecedent then output is term, .. with weight``; consequents are (output, term) indices."""

    antecedent: Antecedent
    consequents: tuple[tuple[int, int], ...]
    weight: Fraction
    span: Span


@dataclass(frozen=True, slots=True)
class Controller:
    """``behaviors`` (by code, the tables' entry last) is empty where there are none; then there is no ``acting``.

    ``always_fires[o]`` is True where the checker proved that the strongest strength over the rules that set output
    ``o`` is at least ``fires_at`` for every input; the integer program then has no decision there.
    """

    name: str
    inputs: tuple[Input, ...]
    outputs: tuple[Output, ...]
    infer: Inference
    fires_at: Fraction
    cells: CellRules | None
    sentences: tuple[SentenceRule, ...]
    behaviors: tuple[Behavior, ...]
    always_fires: tuple[bool, ...]
    span: Span
    account: Account | None = None
    """How the rules shared the cells; None where there are no cells."""
    budgets: tuple[Budget, ...] = ()
    """What a call may cost."""

    @property
    def holds(self) -> bool:
        """Whether a call needs a state."""
        return any(o.fallback is not None and o.fallback.hold for o in self.outputs)
