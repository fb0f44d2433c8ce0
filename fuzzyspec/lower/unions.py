"""The union of the clipped terms of one block of cells, each at a height that is known by its local.

The sums are those of ``lower.centroid``, set by set, with what cannot fire left out.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Assign, Branch, Const, Define, Division, Expr, Local, Stmt
from fuzzyspec.lower.centroid import CentroidNumbers, any_mean, declared_sums, differences, even_mean, weight_of
from fuzzyspec.lower.clipped import ClippedSet, clipped_sets
from fuzzyspec.lower.even import Bits, EvenOutput, cube, even_output, square
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.scope import Scope
from fuzzyspec.lower.sets import evaluate, scale_of
from fuzzyspec.lower.strategy import Precision
from fuzzyspec.model.controller import Output


@dataclass
class Union:
    """An output's sums: area and moment, and of an output that is not even what is taken off both.

    ``alone``: only one term can exceed 1/2, for the inputs are strong partitions.
    """

    output: Output
    even: EvenOutput | None
    forms: tuple[ClippedSet, ...]
    sums: dict[str, Local]
    alone: bool

    @staticmethod
    def of(output: Output, precision: Precision, body: list[Stmt], scope: Scope, alone: bool = True) -> Union:
        """Append the statements that declare the sums. Raises TooManySets."""
        even, forms = even_output(output, precision), clipped_sets(output)
        if even is None:
            return Union(output, None, forms, declared_sums(output, forms, body, scope), alone)
        tops = {"area": even.domain << even.bits.area, "moment": build.UINT32_MAX}
        sums = {n: Local(scope.name(f"{output.name}_{n}"), "uint32", 0, hi) for n, hi in tops.items()}
        body += [Define(s, Const(0), False) for s in sums.values()]
        return Union(output, even, forms, sums, alone)

    def at(self, heights: dict[int, Local], scope: Scope) -> list[Stmt]:
        """Set the sums where the terms that may fire are clipped at these heights."""
        if self.even is not None:
            return _even(self.output, self.even, heights, self.sums, self.alone, scope)
        return _any(self.output, self.forms, heights, self.sums, scope)

    def shifted(self, heights: dict[int, Local], lowest: int, place: Expr, scope: Scope) -> list[Stmt]:
        """The same for terms of an even output, no half triangle among them, of which the lowest lies at ``place``:
        moments are taken about that. Code for ``heights`` as they are here serves all terms as far apart."""
        assert self.even is not None
        area, moment = self.sums["area"], self.sums["moment"]
        about = build.mul(area, place)
        about = build.capped(about, build.UINT32_MAX)
        steps = _even(self.output, self.even, heights, self.sums, self.alone, scope, self.even.peaks[lowest])
        return [*steps, Assign(moment, build.add_bounded(moment, about, moment.hi))]

    def declared(self, used: frozenset[int], body: list[Stmt], scope: Scope) -> dict[int, Local]:
        """Append the statements that declare a level of 0 for the terms that are used, if the output is not even."""
        if self.even is not None:
            return {}
        names = {k: f"{self.output.name}_{self.output.terms[k].name}" for k in sorted(used)}
        levels = {k: Local(scope.name(name), "uint16", 0, DEGREE_ONE) for k, name in names.items()}
        body += [Define(level, Const(0), False) for level in levels.values()]
        return levels

    def summed(self, levels: dict[int, Local], scope: Scope) -> list[Stmt]:
        """Add up the sums from declared levels: a set of terms is asked for only where all of them are reached."""
        return [s for form in self.forms if len(form.members) == 1 for s in self._nested(form, levels, None, scope)]

    def _nested(self, form: ClippedSet, levels: dict[int, Local], low: Local | None, scope: Scope) -> list[Stmt]:
        if not set(form.members) <= set(levels):
            return []
        name = f"{self.output.name}_" + "_".join(self.output.terms[k].name for k in form.members)
        own = levels[form.members[-1]]
        inner: list[Stmt] = []
        height = own
        if low is not None:
            value = build.least(low, own)
            height = build.local(scope.name(name), value)
            inner.append(Define(height, value, True))
        steps, parts = _parts(form, self.forms, height, scope, name)
        inner += steps
        inner += [Assign(self.sums[n], build.add_bounded(self.sums[n], v, build.UINT32_MAX)) for n, v in parts]
        for other in self.forms:
            if other.members[:-1] == form.members:
                inner += self._nested(other, levels, height, scope)
        return [Branch(build.compare(">", own, Const(0)), tuple(inner))]

    def mean(self, division: Division, fires: bool, scope: Scope) -> tuple[list[Stmt], Expr, CentroidNumbers]:
        """The raw; ``fires``: some height is at least 1/2."""
        if self.even is not None:
            return even_mean(self.output, self.even, self.sums["area"], self.sums["moment"], division, scope, fires)
        body: list[Stmt] = []
        area, moment = differences(self.output, self.sums, body, scope)
        steps, raw, numbers = any_mean(self.output, self.forms, area, moment, division, scope, fires)
        return body + steps, raw, numbers


Terms = dict[Expr, int]
"""A sum of atoms, each so many times: heights (times 2**8), squares, cubes."""


@dataclass
class _Linear:
    """Area and moment of a union as sums of its terms' heights, squares and cubes."""

    bits: Bits
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
            part = build.shift_left(_times(self.heights, sign), self.bits.height_shift)
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


def _even(
    output: Output,
    even: EvenOutput,
    heights: dict[int, Local],
    sums: dict[str, Local],
    alone: bool,
    scope: Scope,
    about: int = 0,
) -> list[Stmt]:
    """Set area and moment, the moment about a place that leaves it no less than 0."""
    body: list[Stmt] = []
    bits = even.bits
    pairs = [k for k in even.met if k in heights and k + 1 in heights]
    parts: dict[int, Local] = {}
    squares: dict[int, Local] = {}
    cubes: dict[int, Local] = {}
    for k, height in heights.items():
        name = f"{output.name}_{output.terms[k].name}"
        squared = square(height, bits, name, scope)
        body.append(squared)
        squares[k] = squared.local
        if not even.ends[k] and k not in pairs and k - 1 not in pairs:
            # By itself its area is one atom.
            value = build.sub_guarded(build.shift_left(height, bits.height_shift), squared.local, 2**bits.area)
            parts[k] = build.local(scope.name(f"{name}_part"), value, ctype="uint32")
            body.append(Define(parts[k], value, True))
        if even.ends[k]:
            value = cube(height, squared.local, bits)
            cubes[k] = build.local(scope.name(f"{name}_cube"), value, ctype="uint32")
            body.append(Define(cubes[k], value, True))

    def settled(lower: dict[int, tuple[Local, Local]]) -> list[Stmt]:
        """The rest, where the lower height of the first pairs, and its square, are known."""
        if len(lower) < len(pairs):
            k = pairs[len(lower)]
            if len(pairs) > MOST_BRANCHES or not alone:
                name = f"{output.name}_both"
                value = build.least(heights[k], heights[k + 1])
                # If only one term can exceed 1/2 it is the one that the larger degrees' cell names.
                value = build.capped(value, DEGREE_ONE // 2) if alone else value
                least = build.local(scope.name(name), value)
                steps: list[Stmt] = [Define(least, value, True)]
                if not alone:
                    value = build.least(least, Const(DEGREE_ONE // 2))
                    least = build.local(scope.name(name), value)
                    steps.append(Define(least, value, True))
                squared = square(least, bits, name, scope)
                return [*steps, squared, *settled({**lower, k: (least, squared.local)})]
            sides = [settled({**lower, k: (heights[j], squares[j])}) for j in (k, k + 1)]
            return [Branch(build.compare("<", heights[k], heights[k + 1]), tuple(sides[0]), tuple(sides[1]))]
        area, moment = _Linear(bits), _Linear(bits)
        for k, height in heights.items():
            if k in parts:
                area.rest[parts[k]] = even.counts[k]
                moment.rest[parts[k]] = even.counts[k] * (even.peaks[k] - about)
                continue
            area.add(even.counts[k], height, squares[k], 1)
            moment.add(even.counts[k] * (even.peaks[k] - about), height, squares[k], 1)
            if even.ends[k]:
                moment.add(even.ends[k], height, squares[k], 2, cubes[k])
        for k, (height, squared_) in lower.items():
            area.add(-1, height, squared_, 2)
            moment.add(about - even.peaks[k] - 1, height, squared_, 2)
        return [Assign(s, linear.expr(s.hi)) for s, linear in ((sums["area"], area), (sums["moment"], moment))]

    return body + settled({})


def _any(
    output: Output, forms: tuple[ClippedSet, ...], heights: dict[int, Local], sums: dict[str, Local], scope: Scope
) -> list[Stmt]:
    """Inclusion-exclusion over the sets of these terms that overlap."""
    body: list[Stmt] = []
    lows: dict[tuple[int, ...], Local] = {(k,): h for k, h in heights.items()}
    totals: dict[str, Expr] = dict.fromkeys(sums, Const(0))

    def add(into: str, value: Expr) -> None:
        totals[into] = build.add_bounded(totals[into], value, build.UINT32_MAX)

    for form in forms:
        if not set(form.members) <= set(heights):
            continue
        name = f"{output.name}_" + "_".join(output.terms[k].name for k in form.members)
        if form.members not in lows:
            value = build.least(lows[form.members[:-1]], heights[form.members[-1]])
            lows[form.members] = build.local(scope.name(name), value)
            body.append(Define(lows[form.members], value, True))
        steps, parts = _parts(form, forms, lows[form.members], scope, name)
        body += steps
        for into, value in parts:
            add(into, value)
    return body + [Assign(local, totals[name]) for name, local in sums.items()]


def _parts(
    form: ClippedSet, forms: tuple[ClippedSet, ...], height: Local, scope: Scope, name: str
) -> tuple[list[Stmt], list[tuple[str, Expr]]]:
    """What a set adds to which of the sums, with statements before."""
    scale = scale_of(forms)
    found = evaluate(form, scale, height, scope, name)
    down = form.sign < 0
    parts: list[tuple[str, Expr]] = [("overlap" if down else "area", found.area)]
    weight = weight_of(form, scale)
    if weight:
        part = build.mul(found.area, Const(weight)) if scale.exact else build.mul_high(found.area, Const(weight))
        parts.append(("moment_off" if down else "moment", part))
    if found.moment is not None:
        parts.append(("moment" if form.sign * form.moment_sign > 0 else "moment_off", found.moment))
    return found.steps, parts
