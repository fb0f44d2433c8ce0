"""Block by block, where blocks that are alike share their code.

Which terms of the inputs are active makes a block of cells (``lower.cells``). Blocks whose cells name the same terms,
or in an even output terms as far apart, have the same formulas: they are of one kind. A table tells a block's kind, and
the place of its lowest term where that is all that differs. So also tables of many cells, and inputs whose terms are no
strong partition, are fired without asking any cell that cannot fire.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Assign, Branch, Comment, Const, Define, Division, Element, Expr, Local, Stmt, Table
from fuzzyspec.lower.cells import Block
from fuzzyspec.lower.even import EvenOutput, even_output
from fuzzyspec.lower.fire import Firing, reaches_half, used_terms
from fuzzyspec.lower.fuzzify import Degrees
from fuzzyspec.lower.lattice import Cells, formula
from fuzzyspec.lower.levels import Means
from fuzzyspec.lower.scope import Scope
from fuzzyspec.lower.strategy import Precision
from fuzzyspec.lower.unions import Union
from fuzzyspec.lower.zones import groups_of
from fuzzyspec.model.controller import CellRules, Controller, Input

MOST_INPUTS, MOST_BLOCKS, MOST_KINDS = 3, 256, 48
"""What is looked at, and how many kinds are written out."""

Named = dict[int, Cells]
"""The cells of a block that name each term of an output, by term."""


@dataclass(frozen=True)
class Kind:
    """Blocks of one code: the terms that are named, by output, as in the first of them.

    ``places``: by output, whether the lowest term's place is looked up. ``share``: of all raws, how many lead here.
    """

    named: tuple[Named, ...]
    places: tuple[bool, ...]
    share: float


@dataclass(frozen=True)
class Plan:
    """Every block's kind, and by output its lowest term; blocks are numbered as cells are, the last input fastest."""

    kinds: tuple[Kind, ...]
    kind_of: tuple[int, ...]
    lowest: tuple[tuple[int, ...], ...]


def applies(controller: Controller, precision: Precision = "full") -> bool:
    """Whether a controller can be computed this way."""
    infer, cells = controller.infer, controller.cells
    if cells is None or controller.sentences or controller.behaviors or len(controller.inputs) > MOST_INPUTS:
        return False
    if (infer.and_, infer.aggregate, infer.defuzzify) != ("min", "max", "centroid"):
        return False
    if math.prod(len(_groups(i)) for i in controller.inputs) > MOST_BLOCKS:
        return False
    return len(_plan(controller, precision).kinds) <= MOST_KINDS


def _strong(item: Input) -> bool:
    return item.peaks is not None and len(item.peaks) > 1


def _groups(item: Input) -> dict[tuple[int, ...], int]:
    """The terms that may be active together, with the share of raws that they are in."""
    if not _strong(item):
        return groups_of(item)
    assert item.peaks is not None
    steps = [abs(b - a) / item.variable.raw.step for a, b in zip(item.peaks, item.peaks[1:], strict=False)]
    return {(k, k + 1): max(1, math.floor(abs(s))) for k, s in enumerate(steps)}


@lru_cache(maxsize=64)
def _plan(controller: Controller, precision: Precision) -> Plan:
    assert controller.cells is not None
    evens = [even_output(o, precision) for o in controller.outputs]
    groups = [_groups(i) for i in controller.inputs]
    blocks = [(named, share) for named, share in _blocks(controller.cells, groups)]
    keys = [tuple(map(_alike, named, evens)) for named, _ in blocks]
    shares: dict[tuple[object, ...], float] = {}
    for key, (_, share) in zip(keys, blocks, strict=True):
        shares[key] = shares.get(key, 0.0) + share
    order = sorted(shares, key=lambda key: (-shares[key], keys.index(key)))
    lowest = tuple(tuple(min(named[o], default=0) for named, _ in blocks) for o in range(len(evens)))
    kinds: list[Kind] = []
    for key in order:
        mine = [b for b, k in enumerate(keys) if k == key]
        places = tuple(len({low[b] for b in mine}) > 1 for low in lowest)
        kinds.append(Kind(blocks[mine[0]][0], places, shares[key]))
    return Plan(tuple(kinds), tuple(order.index(k) for k in keys), lowest)


def _blocks(cells: CellRules, groups: list[dict[tuple[int, ...], int]]) -> Iterator[tuple[tuple[Named, ...], float]]:
    """What every block names, and its share of the raws."""
    strides = [math.prod(cells.shape[i + 1 :]) for i in range(len(cells.shape))]
    for chosen in product(*(g.items() for g in groups)):
        found: list[Named] = []
        for terms in cells.consequents:
            named: dict[int, set[tuple[int, ...]]] = {}
            for corner in product(*(range(len(active)) for active, _ in chosen)):
                at = sum(chosen[i][0][place] * strides[i] for i, place in enumerate(corner))
                if terms[at] != -1:
                    named.setdefault(terms[at], set()).add(corner)
            found.append({k: Cells(named[k]) for k in sorted(named)})
        share = math.prod(raws / sum(g.values()) for (_, raws), g in zip(chosen, groups, strict=True))
        yield tuple(found), share


def _alike(named: Named, even: EvenOutput | None) -> object:
    """The same for blocks of one code: terms named by the same cells, the same terms, or as far apart in an even output
    (those of half triangles are like no others)."""
    if even is None or not named or any(even.ends[k] for k in named) or min(even.peaks) < 0:
        return tuple(named.items())
    low = min(named)
    shapes = [(even.peaks[k] - even.peaks[low], even.counts[k], k in even.met and k + 1 in named) for k in named]
    return tuple((k - low, *shape, cells) for (k, cells), shape in zip(named.items(), shapes, strict=True))


def fire_kinds(
    controller: Controller,
    degrees: list[Degrees],
    firing: Firing,
    division: Division,
    precision: Precision,
    scope: Scope,
) -> Means:
    """Append the statements up to every output's sums to ``firing``; the rest of each output is returned."""
    plan = _plan(controller, precision)
    body = firing.body
    body.append(Comment("rules: the kind of the block of cells that may fire"))
    number: Expr = Const(0)
    for found, item in zip(degrees, controller.inputs, strict=True):
        number = build.add(build.mul(number, Const(len(_groups(item)))), found.first)
    if not isinstance(number, Const | Local):
        bound = build.local(scope.name("block"), number)
        body.append(Define(bound, number, True))
        number = bound
    kind = _kind(plan.kind_of, number, firing, scope)
    alone = all(map(_strong, controller.inputs))
    sums: list[_Sums] = []
    for o, output in enumerate(controller.outputs):
        union = Union.of(output, precision, body, scope, alone)
        levels = union.declared(used_terms(controller, o), body, scope)
        sums.append(_Sums(union, levels, _places(union, plan, o, number, firing, scope)))
        if not controller.always_fires[o]:
            firing.strongest[o] = Local(scope.name(f"{output.name}_strongest"), "uint32", 0, firing.one)
            body.append(Define(firing.strongest[o], Const(0), False))
    body += _choice(plan, range(len(plan.kinds)), kind, sums, degrees, firing, scope)
    means: Means = []
    for o, (output, own) in enumerate(zip(controller.outputs, sums, strict=True)):
        fires = o not in firing.strongest and reaches_half(controller, o)
        steps, raw, numbers = own.union.mean(division, fires, scope)
        lead: list[Stmt] = [] if o in firing.strongest else [Comment(f"centroid of {output.name}")]
        means.append(([*lead, *own.union.summed(own.levels, scope), *steps], raw, numbers))
    return means


@dataclass(frozen=True)
class _Sums:
    """One output: its sums, its terms' levels where it is not even, and the place of a block's lowest term."""

    union: Union
    levels: dict[int, Local]
    place: Expr


def _kind(kinds: tuple[int, ...], number: Expr, firing: Firing, scope: Scope) -> Expr:
    """A block's kind, which is its number where every block is of its own."""
    if kinds == tuple(range(len(kinds))):
        return number
    table = Table(scope.name("kinds"), "uint8", kinds)
    firing.tables.append(table)
    value = Element(table.name, "uint8", number, min(kinds), max(kinds), True)
    kind = build.local(scope.name("kind"), value)
    firing.body.append(Define(kind, value, True))
    return kind


def _places(union: Union, plan: Plan, o: int, number: Expr, firing: Firing, scope: Scope) -> Expr:
    """The place of an output's lowest term in a block, from a table that is there if some kind asks for it."""
    if union.even is None or not any(kind.places[o] for kind in plan.kinds):
        return Const(0)
    places = tuple(union.even.peaks[low] for low in plan.lowest[o])
    table = Table(scope.name(f"{union.output.name}_places"), "uint8", places)
    firing.tables.append(table)
    return Element(table.name, "uint8", number, min(places), max(places), True)


def _choice(
    plan: Plan,
    kinds: range,
    kind: Expr,
    sums: list[_Sums],
    degrees: list[Degrees],
    firing: Firing,
    scope: Scope,
) -> list[Stmt]:
    """The code of these kinds, found by comparisons: the more frequent a kind, the fewer."""
    if len(kinds) == 1:
        return _code(plan.kinds[kinds[0]], sums, degrees, firing, scope)
    shares = [plan.kinds[k].share for k in kinds]
    cut = min(range(1, len(kinds)), key=lambda c: abs(sum(shares[:c]) - sum(shares[c:])))
    test = build.compare("<", kind, Const(kinds[cut])) if cut > 1 else build.compare("==", kind, Const(kinds[0]))
    sides = [_choice(plan, part, kind, sums, degrees, firing, scope) for part in (kinds[:cut], kinds[cut:])]
    return [Branch(test, tuple(sides[0]), tuple(sides[1]))]


def _code(kind: Kind, sums: list[_Sums], degrees: list[Degrees], firing: Firing, scope: Scope) -> list[Stmt]:
    block = Block(degrees, scope)
    for o, (own, named) in enumerate(zip(sums, kind.named, strict=True)):
        if not named:
            continue
        output = own.union.output
        heights = {t: block.strength(formula(c), f"{output.name}_{output.terms[t].name}") for t, c in named.items()}
        if o in firing.strongest:
            best = block.strength(formula(Cells(frozenset().union(*named.values()))), f"{output.name}_best")
            block.body.append(Assign(firing.strongest[o], best))
        if own.union.even is None:
            block.body += [Assign(own.levels[t], h) for t, h in heights.items()]
        elif kind.places[o]:
            block.body += own.union.shifted(heights, min(named), own.place, scope)
        else:
            block.body += own.union.at(heights, scope)
    return block.body
