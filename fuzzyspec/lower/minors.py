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
from collections.abc import Callable, Iterator
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
from fuzzyspec.lower.fire import Firing, act, act_equal, act_first, consequent_tables, owner_table, raise_level
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
Act = Callable[[Expr], list[Stmt]]


@dataclass
class Minors:
    """The cell of the majors and the minors of every input, the largest first."""

    base: Local
    sorted: list[Minor]

    @staticmethod
    def of(
        controller: Controller,
        cells: CellRules,
        degrees: list[Degrees],
        body: list[Stmt],
        scope: Scope,
        packed: bool = False,
    ) -> Minors:
        """Append the statements that find and sort them; ``packed`` sorts a degree and its step in one word."""
        body.append(Comment("rules: the cell of the larger degrees, and how each smaller degree leaves it"))
        strides = [math.prod(cells.shape[i + 1 :]) for i in range(len(cells.shape))]
        low: Expr = Const(0)
        for d, stride in zip(degrees, strides, strict=True):
            low = build.add(low, build.mul(d.first, Const(stride)))
        base = Local(scope.name("cell"), "uint32", 0, math.prod(cells.shape) - 1)
        body.append(Define(base, low, False))
        names = [i.name for i in controller.inputs]
        given = zip(names, degrees, strides, strict=True)
        if packed:
            keys = [_key(n, d, s, max(strides), base, body, scope) for n, d, s in given]
            _sort_keys(keys, body, scope)
            return Minors(base, [_unpacked(k, max(strides), body, scope) for k in keys])
        minors = [_minor(n, d, s, max(strides), base, body, scope) for n, d, s in given]
        _sort(minors, body, scope)
        return Minors(base, minors)

    def groups(self, last: int, body: list[Stmt], scope: Scope) -> Iterator[Group]:
        """The n + 1 strengths and their cells, strongest first, each defined in ``body`` when it is asked for.

        ``last`` is the largest index of a cell.
        """
        majors = build.sub(Const(DEGREE_ONE), self.sorted[0].degree)
        strength = build.local(scope.name("majors"), majors)
        body.append(Define(strength, majors, True))
        yield strength, [self.base]
        for i, minor in enumerate(self.sorted):
            # The cells that take this minor and any of the larger ones, each one step from the cell before it (a Gray
            # code), so that none has to be kept.
            at: Expr = self.base
            places: list[Expr] = []
            for count in range(1 << i):
                bit = (count & -count).bit_length() - 1
                step = minor.step if count == 0 else self.sorted[bit].step
                taken = count == 0 or (count ^ count >> 1) >> bit & 1
                # Every such place is the index of a cell: majors and minors both lie in their input's terms.
                value = build.add_bounded(at, step, last) if taken else build.sub_guarded(at, step, last)
                place = Local(scope.name("cell"), "int32", 0, last)
                body.append(Define(place, value, True))
                places.append(place)
                at = place
            yield minor.degree, places

    def ties(self, groups: list[Group], act: Act, body: list[Stmt]) -> None:
        """Where a minor is 1/2 its cells are as strong as that of the majors: the higher priority acts."""
        majors = groups[0][0]
        tied: tuple[Stmt, ...] = ()
        for strength, places in reversed(groups[1:]):
            inner = [s for place in places for s in act(place)]
            tied = (Branch(build.compare("==", strength, majors), (*inner, *tied)),)
        body += tied


def fire_minors(controller: Controller, cells: CellRules, degrees: list[Degrees], firing: Firing, scope: Scope) -> None:
    """Append to ``firing`` the statements that raise the levels of every active cell."""
    body = firing.body
    minors = Minors.of(controller, cells, degrees, body, scope)
    consequents = consequent_tables(controller, cells, firing, scope)
    owners = owner_table(controller, cells, firing, scope)
    groups: list[Group] = []
    unowned = owners is not None and 0 in owners.values

    def fired(row: Expr, strength: Local, level: int) -> list[Stmt]:
        steps: list[Stmt] = []
        for o, table in consequents:
            output = controller.outputs[o]
            hi = max(table.values)
            term = Local(scope.name(f"{output.name}_term"), "uint8", min(table.values), hi)
            steps.append(Define(term, Element(table.name, "uint8", row, term.lo, hi, True), True))
            holes = len(output.terms) if hi == len(output.terms) else None
            steps += raise_level(controller, firing, o, term, strength, holes)
        if owners is not None and (level == 0 or unowned):
            steps += (act if level else act_first)(owners, row, strength, firing, scope)
        return steps

    for level, (strength, places) in enumerate(minors.groups(math.prod(cells.shape) - 1, body, scope)):
        groups.append((strength, places))
        steps = [s for p in places for s in fired(p, strength, level)]
        if level:
            body.append(Branch(build.compare(">", strength, Const(0)), tuple(steps)))
        else:
            body += steps
    if owners is not None and not unowned:
        minors.ties(groups, lambda place: act_equal(owners, place, firing, scope), body)


def _minor(name: str, d: Degrees, stride: int, widest: int, base: Local, body: list[Stmt], scope: Scope) -> Minor:
    upper = d.upper
    assert upper is not None
    degree = Local(scope.name(f"{name}_minor"), "uint16", 0, HALF_DEGREE)
    step = Local(scope.name(f"{name}_step"), "int32", -widest, widest)
    body += [
        Define(degree, Const(0), False),
        Define(step, Const(stride), False),
        Branch(
            build.compare(">", upper, Const(HALF_DEGREE)),
            (
                Assign(degree, build.sub_guarded(Const(DEGREE_ONE), upper, HALF_DEGREE)),
                Assign(step, Const(-stride)),
                Assign(base, build.add_bounded(base, Const(stride), base.hi)),
            ),
            (Assign(degree, build.sub_guarded(upper, Const(0), HALF_DEGREE)),),
        ),
    ]
    return Minor(degree, step)


def _key(name: str, d: Degrees, stride: int, widest: int, base: Local, body: list[Stmt], scope: Scope) -> Local:
    """The minor in the upper half of a word, its step plus the widest one in the lower."""
    upper = d.upper
    assert upper is not None
    key = Local(scope.name(f"{name}_key"), "uint32", 0, (HALF_DEGREE << 16) + 2 * widest)

    def packed(degree: Expr, step: int) -> Expr:
        return build.capped(build.add(build.mul(degree, Const(1 << 16)), Const(widest + step)), key.hi)

    body += [
        Define(key, Const(0), False),
        Branch(
            build.compare(">", upper, Const(HALF_DEGREE)),
            (
                Assign(key, packed(build.sub_guarded(Const(DEGREE_ONE), upper, HALF_DEGREE), -stride)),
                Assign(base, build.add_bounded(base, Const(stride), base.hi)),
            ),
            (Assign(key, packed(build.capped(upper, HALF_DEGREE), stride)),),
        ),
    ]
    return key


def _unpacked(key: Local, widest: int, body: list[Stmt], scope: Scope) -> Minor:
    degree_value = build.shift_right(key, 16)
    low = build.capped(build.bits_and(key, Const(0xFFFF)), 2 * widest)
    step_value = build.sub(low, Const(widest))
    degree = build.local(scope.name("minor"), degree_value)
    step = build.local(scope.name("step"), step_value, ctype="int32")
    body += [Define(degree, degree_value, True), Define(step, step_value, True)]
    return Minor(degree, step)


NETWORKS: dict[int, tuple[tuple[int, int], ...]] = {
    2: ((0, 1),),
    3: ((0, 2), (0, 1), (1, 2)),
    4: ((0, 2), (1, 3), (0, 1), (2, 3), (1, 2)),
    5: ((0, 3), (1, 4), (0, 2), (1, 3), (0, 1), (2, 4), (1, 2), (3, 4), (2, 3)),
}
"""The fewest exchanges that sort 2 to 5 values (Knuth, The Art of Computer Programming 3, 5.3.4)."""


def _sort_keys(keys: list[Local], body: list[Stmt], scope: Scope) -> None:
    """Leave the largest first."""
    for i, j in NETWORKS[len(keys)]:
        a, b = keys[i], keys[j]
        kept = Local(scope.name("kept"), "uint32", a.lo, a.hi)
        swap = (Define(kept, a, True), Assign(a, b), Assign(b, kept))
        body.append(Branch(build.compare("<", a, b), swap))


def _sort(minors: list[Minor], body: list[Stmt], scope: Scope) -> None:
    """Leave the largest minor first."""
    for i, j in NETWORKS[len(minors)]:
        a, b = minors[i], minors[j]
        kept = Local(scope.name("kept"), "uint16", 0, HALF_DEGREE)
        kept_step = Local(scope.name("kept_step"), "int32", a.step.lo, a.step.hi)
        swap = (
            Define(kept, a.degree, True),
            Define(kept_step, a.step, True),
            Assign(a.degree, b.degree),
            Assign(a.step, b.step),
            Assign(b.degree, kept),
            Assign(b.step, kept_step),
        )
        body.append(Branch(build.compare("<", a.degree, b.degree), swap))
