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
from fuzzyspec.fixed.program import Assign, Branch, Comment, Const, Define, Division, Expr, Local, Stmt
from fuzzyspec.lower.centroid import even_mean, even_sets
from fuzzyspec.lower.even import EvenOutput, evaluate_even
from fuzzyspec.lower.fire import Firing
from fuzzyspec.lower.fuzzify import Degrees
from fuzzyspec.lower.lattice import Cells, Degree, Formula, Higher, Lower, formula
from fuzzyspec.lower.levels import Means
from fuzzyspec.lower.levels import applies as levels_apply
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.controller import CellRules, Controller, Output

MOST_BLOCKS = 16


def applies(controller: Controller) -> list[EvenOutput] | None:
    """The outputs' shapes where a controller can be computed this way, else None."""
    if controller.cells is None or controller.behaviors or len(controller.inputs) > 3:
        return None
    if math.prod(n - 1 for n in controller.cells.shape) > MOST_BLOCKS:
        return None
    return levels_apply(controller)


@dataclass
class _Block:
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

    def _computed(self, wanted: Formula, name: str) -> Local:
        match wanted:
            case Degree():
                upper = self.degrees[wanted.input].upper
                assert upper is not None
                if wanted.which == "upper":
                    return upper
                rest = self.bind("rest", build.sub(Const(DEGREE_ONE), upper))
                return rest if wanted.which == "lower" else self.bind("larger", build.greatest(upper, rest))
            case Lower():
                return self.bind(name, build.least(self.strength(wanted.left, name), self.strength(wanted.right, name)))
            case Higher():
                left, right = self.strength(wanted.left, name), self.strength(wanted.right, name)
                return self.bind(name, build.greatest(left, right))
            case _:
                assert_never(wanted)


def fire_cells(
    controller: Controller,
    cells: CellRules,
    evens: list[EvenOutput],
    degrees: list[Degrees],
    firing: Firing,
    division: Division,
    scope: Scope,
) -> Means:
    """Append the statements up to every output's sums to ``firing``; the rest of each output is returned."""
    sums: list[tuple[Local, Local]] = []
    for output, even in zip(controller.outputs, evens, strict=True):
        area = Local(scope.name(f"{output.name}_area"), "uint32", 0, even.domain << 22)
        moment = Local(scope.name(f"{output.name}_moment"), "uint32", 0, build.UINT32_MAX)
        firing.body += [Define(area, Const(0), False), Define(moment, Const(0), False)]
        sums.append((area, moment))

    def blocks(lows: tuple[int, ...]) -> list[Stmt]:
        """The code for the block of these lower terms, or the choice among those below."""
        i = len(lows)
        if i == len(degrees):
            return _block(controller, cells, evens, degrees, lows, sums, scope)
        chain: list[Stmt] = []
        for low in range(cells.shape[i] - 2, -1, -1):
            steps = blocks((*lows, low))
            test = build.compare("==", degrees[i].first, Const(low)) if cells.shape[i] > 2 else None
            chain = steps if not chain or test is None else [Branch(test, tuple(steps), tuple(chain))]
        return chain

    firing.body += blocks(())
    found: Means = []
    for output, even, (area, moment) in zip(controller.outputs, evens, sums, strict=True):
        steps, raw, numbers = even_mean(output, even, area, moment, even_sets(even), division, scope, fires=True)
        found.append(([Comment(f"centroid of {output.name}"), *steps], raw, numbers))
    return found


def _block(
    controller: Controller,
    cells: CellRules,
    evens: list[EvenOutput],
    degrees: list[Degrees],
    lows: tuple[int, ...],
    sums: list[tuple[Local, Local]],
    scope: Scope,
) -> list[Stmt]:
    names = [i.terms[k].name + " " + i.terms[k + 1].name for i, k in zip(controller.inputs, lows, strict=True)]
    block = _Block(degrees, scope)
    block.body.append(Comment("between the peaks of " + ", ".join(names)))
    strides = [math.prod(cells.shape[i + 1 :]) for i in range(len(lows))]
    for o, (output, even, (area, moment)) in enumerate(zip(controller.outputs, evens, sums, strict=True)):
        named: dict[int, set[tuple[int, ...]]] = {}
        for corner in product((0, 1), repeat=len(lows)):
            cell = sum((k + b) * s for k, b, s in zip(lows, corner, strides, strict=True))
            named.setdefault(cells.consequents[o][cell], set()).add(corner)
        heights = {
            k: block.strength(formula(Cells(c)), f"{output.name}_{output.terms[k].name}")
            for k, c in sorted(named.items())
        }
        a, m = _sums(output, even, heights, block)
        block.body += [Assign(area, build.capped(a, area.hi)), Assign(moment, m)]
    return block.body


def _sums(output: Output, even: EvenOutput, heights: dict[int, Local], block: _Block) -> tuple[Expr, Expr]:
    """Area and moment of the union of a block's terms."""
    area: Expr = Const(0)
    moment: Expr = Const(0)
    less: Expr = Const(0)
    for form in even.forms:
        if not set(form.members) <= set(heights):
            continue
        height = heights[form.members[0]]
        if form.sign < 0:
            # Only one term can exceed 1/2: the one that the larger degrees' cell names.
            height = block.bind(f"{output.name}_both", build.least(height, heights[form.members[1]]))
            height = Local(height.name, height.ctype, 0, DEGREE_ONE // 2)
        found = evaluate_even(form, even, height, block.scope, f"{output.name}_{output.terms[form.members[0]].name}")
        block.body += found.steps
        if form.sign < 0:
            area = build.sub_guarded(area, found.area, area.hi)
            less = build.add(less, build.mul(found.area, Const(even.peaks[form.members[0]] + 1)))
            continue
        count, peak = even.halves[form.members[0]], even.peaks[form.members[0]]
        area = build.add(area, build.mul(found.area, Const(count)))
        moment = build.add(moment, build.mul(found.area, Const(count * peak)))
        if found.moment is not None and form.moment_sign > 0:
            moment = build.add(moment, found.moment)
        elif found.moment is not None:
            less = build.add(less, found.moment)
    return area, build.sub_guarded(moment, less, moment.hi)
