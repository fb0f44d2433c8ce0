"""Cell by cell: for every block of cells between neighbouring peaks, code of its own.

In a block the terms that can fire are known, and so is each one's strength as a formula of the degrees
(``lower.lattice``). What is left of the centroid is what those terms need: no levels in memory, no tables, no sorting.
It pays for few blocks, and computes the same sums as the loops.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import product
from typing import assert_never

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Branch, Comment, Const, Define, Division, Expr, Local, Stmt
from fuzzyspec.lower.fire import Firing
from fuzzyspec.lower.fuzzify import Degrees
from fuzzyspec.lower.lattice import Cells, Degree, Formula, Higher, Lower, Rest, formula
from fuzzyspec.lower.levels import Means
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.minors import applies as minors_apply
from fuzzyspec.lower.scope import Scope
from fuzzyspec.lower.strategy import Precision
from fuzzyspec.lower.unions import Union
from fuzzyspec.model.controller import CellRules, Controller

MOST_BLOCKS = 16


def applies(controller: Controller) -> bool:
    """Whether a controller can be computed this way."""
    if controller.cells is None or controller.behaviors or len(controller.inputs) > 3:
        return False
    if math.prod(n - 1 for n in controller.cells.shape) > MOST_BLOCKS or controller.infer.defuzzify != "centroid":
        return False
    holes = any(-1 in c for c in controller.cells.consequents)
    return minors_apply(controller) and all(controller.always_fires) and not holes


@dataclass
class Block:
    """The statements of one block, and the degrees and formulas that it has locals for."""

    degrees: list[Degrees]
    scope: Scope
    body: list[Stmt] = field(default_factory=list)
    known: dict[Formula, Local] = field(default_factory=dict)

    def bind(self, name: str, value: Expr) -> Local:
        found = build.local(self.scope.name(name), build.capped(value, DEGREE_ONE))
        self.body.append(Define(found, value, True))
        return found

    def strength(self, wanted: Formula, name: str) -> Local:
        """The local that holds a formula's value."""
        if wanted not in self.known:
            self.known[wanted] = self._computed(wanted, name)
        return self.known[wanted]

    def degree(self, i: int, place: int) -> Local:
        """Of an input's term at a place among those that are active."""
        found = self.degrees[i]
        if found.upper is None:
            return found.members[place]
        if place == 1:
            return found.upper
        only = Degree(i, (0,))
        if only not in self.known:
            self.known[only] = self.bind("rest", build.sub(Const(DEGREE_ONE), found.upper))
        return self.known[only]

    def _computed(self, wanted: Formula, name: str) -> Local:
        match wanted:
            case Degree():
                *others, last = (self.degree(wanted.input, place) for place in wanted.which)
                for other in reversed(others):
                    last = self.bind("larger", build.greatest(last, other))
                return last
            case Lower():
                return self.bind(name, build.least(self.strength(wanted.left, name), self.strength(wanted.right, name)))
            case Higher():
                left, right = self.strength(wanted.left, name), self.strength(wanted.right, name)
                return self.bind(name, build.greatest(left, right))
            case Rest():
                return self.bind("not_so", build.sub(Const(DEGREE_ONE), self.strength(wanted.of, name)))
            case _:
                assert_never(wanted)


def fire_cells(
    controller: Controller,
    cells: CellRules,
    degrees: list[Degrees],
    firing: Firing,
    division: Division,
    precision: Precision,
    scope: Scope,
) -> Means:
    """Append the statements up to every output's sums to ``firing``; the rest of each output is returned."""
    unions = [Union.of(output, precision, firing.body, scope) for output in controller.outputs]

    def blocks(lows: tuple[int, ...]) -> list[Stmt]:
        """The code for the block of these lower terms, or the choice among those below."""
        i = len(lows)
        if i == len(degrees):
            return _block(controller, cells, unions, degrees, lows, scope)
        chain: list[Stmt] = []
        for low in range(cells.shape[i] - 2, -1, -1):
            steps = blocks((*lows, low))
            test = build.compare("==", degrees[i].first, Const(low)) if cells.shape[i] > 2 else None
            chain = steps if not chain or test is None else [Branch(test, tuple(steps), tuple(chain))]
        return chain

    firing.body += blocks(())
    found: Means = []
    for union in unions:
        steps, raw, numbers = union.mean(division, True, scope)
        found.append(([Comment(f"centroid of {union.output.name}"), *steps], raw, numbers))
    return found


def _block(
    controller: Controller,
    cells: CellRules,
    unions: list[Union],
    degrees: list[Degrees],
    lows: tuple[int, ...],
    scope: Scope,
) -> list[Stmt]:
    names = [i.terms[k].name + " " + i.terms[k + 1].name for i, k in zip(controller.inputs, lows, strict=True)]
    block = Block(degrees, scope)
    block.body.append(Comment("between the peaks of " + ", ".join(names)))
    strides = [math.prod(cells.shape[i + 1 :]) for i in range(len(lows))]
    for o, union in enumerate(unions):
        output = union.output
        named: dict[int, set[tuple[int, ...]]] = {}
        for corner in product((0, 1), repeat=len(lows)):
            cell = sum((k + b) * s for k, b, s in zip(lows, corner, strides, strict=True))
            named.setdefault(cells.consequents[o][cell], set()).add(corner)
        heights = {
            k: block.strength(formula(Cells(c)), f"{output.name}_{output.terms[k].name}")
            for k, c in sorted(named.items())
        }
        block.body += union.at(heights, scope)
    return block.body
