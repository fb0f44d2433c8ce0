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
from fuzzyspec.lower.even import AREA_BITS, HEIGHT_SHIFT, EvenOutput, cube, square
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
        area = Local(scope.name(f"{output.name}_area"), "uint32", 0, even.domain << AREA_BITS)
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
        block.body += _sums(output, even, heights, (area, moment), block)
    return block.body


Terms = dict[Expr, int]
"""A sum of atoms, each so many times: heights (times 2**8), squares, cubes."""


@dataclass
class _Linear:
    """Area and moment of a union as sums of its terms' heights, squares and cubes."""

    heights: Terms = field(default_factory=dict)
    rest: Terms = field(default_factory=dict)

    def add(self, times: int, height: Local, squared: Local, squares: int, cubed: Expr | None = None) -> None:
        """Add ``times`` of ``2**8 h - squares * h**2 (+ h**3)``."""
        self.heights[height] = self.heights.get(height, 0) + times
        self.rest[squared] = self.rest.get(squared, 0) - times * squares
        if cubed is not None:
            self.rest[cubed] = self.rest.get(cubed, 0) + times

    def expr(self, hi: int) -> Expr:
        """What is added first, then what is subtracted: the sum is an area or a moment, so it is not negative."""
        parts: list[Expr] = []
        for sign in (1, -1):
            part = build.shift_left(_times(self.heights, sign), HEIGHT_SHIFT)
            parts.append(build.add(part, _times(self.rest, sign)))
        return build.sub_guarded(parts[0], parts[1], hi)


def _times(terms: Terms, sign: int) -> Expr:
    total: Expr = Const(0)
    for atom, times in terms.items():
        if times * sign > 0:
            total = build.add(total, build.mul(atom, Const(times * sign)))
    return total


MOST_BRANCHES = 2
"""Overlaps whose lower term is asked for by a branch each; of more, the lower height is computed."""


def _sums(
    output: Output, even: EvenOutput, heights: dict[int, Local], sums: tuple[Local, Local], block: _Block
) -> list[Stmt]:
    """Set area and moment of the union of a block's terms."""
    body: list[Stmt] = []
    pairs = [k for k in even.met if k in heights and k + 1 in heights]
    parts: dict[int, Local] = {}
    squares: dict[int, Local] = {}
    cubes: dict[int, Local] = {}
    for k, height in heights.items():
        name = f"{output.name}_{output.terms[k].name}"
        squared = square(height, name, block.scope)
        body.append(squared)
        squares[k] = squared.local
        if not even.ends[k] and k not in pairs and k - 1 not in pairs:
            # By itself its area is one atom.
            value = build.sub_guarded(build.shift_left(height, HEIGHT_SHIFT), squared.local, 2**AREA_BITS)
            parts[k] = build.local(block.scope.name(f"{name}_part"), value, ctype="uint32")
            body.append(Define(parts[k], value, True))
        if even.ends[k]:
            value = cube(height, squared.local)
            cubes[k] = build.local(block.scope.name(f"{name}_cube"), value, ctype="uint32")
            body.append(Define(cubes[k], value, True))

    def settled(lower: dict[int, tuple[Local, Local]]) -> list[Stmt]:
        """The rest, where the lower height of the first pairs, and its square, are known."""
        if len(lower) < len(pairs):
            k = pairs[len(lower)]
            if len(pairs) > MOST_BRANCHES:
                name = f"{output.name}_both"
                # Only one term can exceed 1/2: the one that the larger degrees' cell names.
                value = build.capped(build.least(heights[k], heights[k + 1]), DEGREE_ONE // 2)
                least = build.local(block.scope.name(name), value)
                squared = square(least, name, block.scope)
                return [Define(least, value, True), squared, *settled({**lower, k: (least, squared.local)})]
            sides = [settled({**lower, k: (heights[j], squares[j])}) for j in (k, k + 1)]
            return [Branch(build.compare("<", heights[k], heights[k + 1]), tuple(sides[0]), tuple(sides[1]))]
        area, moment = _Linear(), _Linear()
        for k, height in heights.items():
            if k in parts:
                area.rest[parts[k]] = even.counts[k]
                moment.rest[parts[k]] = even.counts[k] * even.peaks[k]
                continue
            area.add(even.counts[k], height, squares[k], 1)
            moment.add(even.counts[k] * even.peaks[k], height, squares[k], 1)
            if even.ends[k]:
                moment.add(even.ends[k], height, squares[k], 2, cubes[k])
        for k, (height, squared_) in lower.items():
            area.add(-1, height, squared_, 2)
            moment.add(-even.peaks[k] - 1, height, squared_, 2)
        return [Assign(sums[0], area.expr(sums[0].hi)), Assign(sums[1], moment.expr(build.UINT32_MAX))]

    return body + settled({})
