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
    Table,
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
class _Minor:
    """The smaller degree of one input, and what taking it instead of the major adds to the cell's index."""

    degree: Local
    step: Local


def fire_minors(controller: Controller, cells: CellRules, degrees: list[Degrees], firing: Firing, scope: Scope) -> None:
    """Append to ``firing`` the statements that raise the levels of every active cell."""
    body = firing.body
    body.append(Comment("rules: the cell of the larger degrees, and how each smaller degree leaves it"))
    strides = [math.prod(cells.shape[i + 1 :]) for i in range(len(cells.shape))]
    last = math.prod(cells.shape) - 1
    base: Expr = Const(0)
    minors: list[_Minor] = []
    for i, (d, stride) in enumerate(zip(degrees, strides, strict=True)):
        minor, at = _minor(controller.inputs[i].name, d, stride, max(strides), body, scope)
        minors.append(minor)
        total = build.add(base, at)
        base = build.local(scope.name("cell"), total)
        body.append(Define(base, total, True))
    _sort(minors, body, scope)
    walk = _Walk(controller, firing, consequent_tables(controller, cells, firing, scope), scope, last)
    walk.owners = owner_table(controller, cells, firing, scope)
    majors = build.sub(Const(DEGREE_ONE), minors[0].degree)
    strength = build.local(scope.name("majors"), majors)
    body.append(Define(strength, majors, True))
    body += walk.cell(base, strength, always=True)
    offsets: list[Expr] = [base]
    for minor in minors:
        here: list[Stmt] = []
        places: list[Expr] = []
        for offset in offsets:
            # Every such sum is the index of a cell: majors and minors both lie in their input's terms.
            moved = build.add_bounded(offset, minor.step, last)
            place = Local(scope.name("cell"), "int32", 0, last)
            here.append(Define(place, moved, True))
            places.append(place)
        body += here
        body.append(
            Branch(
                build.compare(">", minor.degree, Const(0)),
                tuple(s for p in places for s in walk.cell(p, minor.degree, always=False)),
            )
        )
        offsets += places
    walk.ties(offsets, minors, strength, body)


def _minor(name: str, d: Degrees, stride: int, widest: int, body: list[Stmt], scope: Scope) -> tuple[_Minor, Expr]:
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
    return _Minor(degree, step), at


def _sort(minors: list[_Minor], body: list[Stmt], scope: Scope) -> None:
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


@dataclass
class _Walk:
    controller: Controller
    firing: Firing
    consequents: list[tuple[int, Table]]
    scope: Scope
    last: int
    owners: Table | None = None

    def cell(self, row: Expr, strength: Local, always: bool) -> list[Stmt]:
        """One cell's strength enters the levels of its consequents; the acting behavior is that of the majors' cell."""
        body: list[Stmt] = []
        for o, table in self.consequents:
            output = self.controller.outputs[o]
            hi = max(table.values)
            term = Local(self.scope.name(f"{output.name}_term"), "uint8", min(table.values), hi)
            body.append(Define(term, Element(table.name, "uint8", row, term.lo, hi, True), True))
            holes = len(output.terms) if hi == len(output.terms) else None
            body += raise_level(self.controller, self.firing, o, term, strength, holes)
        if self.owners is not None and (always or 0 in self.owners.values):
            body += act(self.owners, row, strength, self.firing, self.scope)
        return body

    def ties(self, places: list[Expr], minors: list[_Minor], majors: Local, body: list[Stmt]) -> None:
        """Where a minor is 1/2 its cells are as strong as that of the majors: the higher priority acts."""
        if self.owners is None or 0 in self.owners.values:
            return
        equal: list[Stmt] = []
        for i, minor in enumerate(minors):
            inner = [
                s
                for p in places[2**i : 2 ** (i + 1)]
                for s in act(self.owners, p, minor.degree, self.firing, self.scope)
            ]
            equal.append(Branch(build.compare("==", minor.degree, majors), tuple(inner)))
        body.append(Branch(build.compare("==", minors[0].degree, majors), tuple(equal)))
