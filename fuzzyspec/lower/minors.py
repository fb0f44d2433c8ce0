"""Firing by sorted minors: cell rules over strong partitions with min, the strongest cells first.

Of the two active terms of an input the one with the smaller degree m <= 1/2 is its minor, the other its major. A
cell's strength
is the smallest of its degrees: the smallest minor in it, or, in the cell of majors only, ``1 - (the largest
minor)``. With the
minors sorted downwards there are n + 1 strengths in all: that of the majors, then for each minor in turn the cells
which hold it and any of the larger ones (1, 2, 4 .. of them). No minimum is taken cell by cell.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    Assign,
    Branch,
    Comment,
    Const,
    Define,
    Element,
    Expr,
    Local,
    Stmt,
)
from fuzzyspec.lower.fire import Firing, act, consequent_tables, owner_table, raise_level
from fuzzyspec.lower.fuzzify import Degrees
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.controller import CellRules, Controller

HALF_DEGREE = DEGREE_ONE // 2
MOST_INPUTS = 5
"""Cells are written out one by one: 2**5 of them at most."""


def applies(controller: Controller) -> bool:
    """Whether a controller's cells can be fired this way."""
    return (
        controller.cells is not None
        and not controller.sentences
        and controller.infer.and_ == "min"
        and controller.infer.aggregate == "max"
        and 2 <= len(controller.inputs) <= MOST_INPUTS
        and all(i.peaks is not None and len(i.peaks) > 1 for i in controller.inputs)
    )


@dataclass
class Minor:
    """The smaller degree of one input, and what taking it instead of the major adds to the cell's index."""

    degree: Local
    step: Local


Group = tuple[Local, list[Expr]]
"""A strength and the indices of the cells that have it."""
Act = Callable[[Expr, Local], list[Stmt]]


@dataclass
class Minors:
    """The cell of the majors and the minors of every input, the largest first."""

    base: Expr
    sorted: list[Minor]

    @staticmethod
    def of(controller: Controller, cells: CellRules, degrees: list[Degrees], body: list[Stmt], scope: Scope) -> Minors:
        """Append the statements that find and sort them."""
        body.append(Comment("rules: the cell of the larger degrees, and how each smaller degree leaves it"))
        strides = [math.prod(cells.shape[i + 1 :]) for i in range(len(cells.shape))]
        base: Expr = Const(0)
        minors: list[Minor] = []
        for i, (d, stride) in enumerate(zip(degrees, strides, strict=True)):
            minor, at = _minor(controller.inputs[i].name, d, stride, max(strides), body, scope)
            minors.append(minor)
            total = build.add(base, at)
            base = build.local(scope.name("cell"), total, ctype="uint32")
            body.append(Define(base, total, True))
        _sort(minors, body, scope)
        return Minors(base, minors)

    def groups(self, last: int, body: list[Stmt], scope: Scope) -> list[Group]:
        """The n + 1 strengths and their cells, strongest first; ``last`` is the largest index of a cell."""
        majors = build.sub(Const(DEGREE_ONE), self.sorted[0].degree)
        strength = build.local(scope.name("majors"), majors)
        body.append(Define(strength, majors, True))
        found: list[Group] = [(strength, [self.base])]
        offsets: list[Expr] = [self.base]
        for minor in self.sorted:
            places: list[Expr] = []
            for offset in offsets:
                # Every such sum is the index of a cell: majors and minors both lie in their input's terms.
                place = Local(scope.name("cell"), "int32", 0, last)
                body.append(Define(place, build.add_bounded(offset, minor.step, last), True))
                places.append(place)
            found.append((minor.degree, places))
            offsets += places
        return found

    def ties(self, groups: list[Group], act: Act, body: list[Stmt]) -> None:
        """Where a minor is 1/2 its cells are as strong as that of the majors: the higher priority acts."""
        majors = groups[0][0]
        equal: list[Stmt] = []
        for strength, places in groups[1:]:
            inner = [s for p in places for s in act(p, strength)]
            equal.append(Branch(build.compare("==", strength, majors), tuple(inner)))
        body.append(Branch(build.compare("==", groups[1][0], majors), tuple(equal)))


def fire_minors(controller: Controller, cells: CellRules, degrees: list[Degrees], firing: Firing, scope: Scope) -> None:
    """Append to ``firing`` the statements that raise the levels of every active cell."""
    body = firing.body
    minors = Minors.of(controller, cells, degrees, body, scope)
    consequents = consequent_tables(controller, cells, firing, scope)
    owners = owner_table(controller, cells, firing, scope)
    groups = minors.groups(math.prod(cells.shape) - 1, body, scope)
    unowned = owners is not None and 0 in owners.values

    def fired(row: Expr, strength: Local, acts: bool) -> list[Stmt]:
        steps: list[Stmt] = []
        for o, table in consequents:
            output = controller.outputs[o]
            hi = max(table.values)
            term = Local(scope.name(f"{output.name}_term"), "uint8", min(table.values), hi)
            steps.append(Define(term, Element(table.name, "uint8", row, term.lo, hi, True), True))
            holes = len(output.terms) if hi == len(output.terms) else None
            steps += raise_level(controller, firing, o, term, strength, holes)
        return steps + (act(owners, row, strength, firing, scope) if owners is not None and acts else [])

    for level, (strength, places) in enumerate(groups):
        steps = [s for p in places for s in fired(p, strength, level == 0 or unowned)]
        if level:
            body.append(Branch(build.compare(">", strength, Const(0)), tuple(steps)))
        else:
            body += steps
    if owners is not None and not unowned:
        minors.ties(groups, lambda p, s: act(owners, p, s, firing, scope), body)


def _minor(name: str, d: Degrees, stride: int, widest: int, body: list[Stmt], scope: Scope) -> tuple[Minor, Expr]:
    upper = d.upper
    assert upper is not None
    low = build.mul(d.first, Const(stride))
    degree = Local(scope.name(f"{name}_minor"), "uint16", 0, HALF_DEGREE)
    step = Local(scope.name(f"{name}_step"), "int32", -widest, widest)
    at = Local(scope.name(f"{name}_at"), "int32", 0, low.hi + stride)
    above = build.sub_guarded(Const(DEGREE_ONE), upper, HALF_DEGREE)
    body += [
        Define(degree, Const(0), False),
        Define(step, Const(stride), False),
        Define(at, low, False),
        Branch(
            build.compare(">", upper, Const(HALF_DEGREE)),
            (
                Assign(degree, above),
                Assign(step, Const(-stride)),
                Assign(at, build.add(low, Const(stride))),
            ),
            (Assign(degree, build.sub_guarded(upper, Const(0), HALF_DEGREE)),),
        ),
    ]
    return Minor(degree, step), at


def _sort(minors: list[Minor], body: list[Stmt], scope: Scope) -> None:
    """A network of exchanges that leaves the largest minor first (insertion order, n (n - 1) / 2 exchanges)."""
    for end in range(len(minors) - 1, 0, -1):
        for i in range(end):
            a, b = minors[i], minors[i + 1]
            kept = Local(scope.name("kept"), "uint16", 0, HALF_DEGREE)
            kept_step = Local(scope.name("kept_step"), "int32", a.step.lo, a.step.hi)
            body.append(
                Branch(
                    build.compare("<", a.degree, b.degree),
                    (
                        Define(kept, a.degree, True),
                        Define(kept_step, a.step, True),
                        Assign(a.degree, b.degree),
                        Assign(a.step, b.step),
                        Assign(b.degree, kept),
                        Assign(b.step, kept_step),
                    ),
                )
            )
