"""Block by block, where blocks that are alike share their code.

Which terms of the inputs are active makes a block of cells (``lower.cells``). Blocks whose cells name the same terms,
or in an even output terms as far apart, have the same formulas: they are of one kind. A table tells a block's kind, and
the place of its lowest term where that is all that differs. So also tables of many cells, and inputs whose terms are no
strong partition, are fired without asking any cell that cannot fire; and sentence rules, if none
has a weight, for in a block parts of them are settled by terms that are not active.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from typing import Literal

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Assign, Branch, Comment, Const, Define, Division, Element, Expr, Local, Stmt, Table
from fuzzyspec.lower.cells import Block
from fuzzyspec.lower.even import EvenOutput, even_output
from fuzzyspec.lower.fire import Firing, reaches_half, used_terms
from fuzzyspec.lower.fuzzify import Degrees
from fuzzyspec.lower.lattice import Cells, Formula, Higher, degrees_in, formula, joined, of_sentence, terms_in
from fuzzyspec.lower.levels import Means
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.scope import Scope
from fuzzyspec.lower.strategy import Precision
from fuzzyspec.lower.unions import Union
from fuzzyspec.lower.zones import groups_of
from fuzzyspec.model.controller import Controller, Input

MOST_INPUTS, MOST_BLOCKS, MOST_KINDS = 3, 256, 48
"""What is looked at, and how many kinds are written out."""

Height = Formula | Literal[True]
"""A strength in a block; True where it is 1 whatever the degrees are."""
Named = dict[int, Height]
"""What an output's terms are clipped at in a block, by term that is named there."""


@dataclass(frozen=True)
class Kind:
    """Blocks of one code: terms and strengths, and the largest strength, by output, as in the first of them.

    ``places``: by output, whether the lowest term's place is looked up. ``share``: of all raws, how many lead here.
    """

    named: tuple[Named, ...]
    best: tuple[Height | None, ...]
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
    infer = controller.infer
    if controller.behaviors or len(controller.inputs) > MOST_INPUTS:
        return False
    if (infer.and_, infer.or_, infer.aggregate, infer.defuzzify) != ("min", "max", "max", "centroid"):
        return False
    if any(rule.weight != 1 for rule in controller.sentences):
        return False
    if bool(controller.sentences) == (controller.cells is not None):
        return False
    if math.prod(len(g) for g in _groups(controller)) > MOST_BLOCKS:
        return False
    kinds = _plan(controller, precision).kinds
    return len(kinds) <= MOST_KINDS and (not controller.sentences or _all_asked(controller, kinds))


def _all_asked(controller: Controller, kinds: tuple[Kind, ...]) -> bool:
    """Whether there is no local for a degree or a block that sentences never ask for."""
    heights = [h for kind in kinds for named in kind.named for h in named.values() if h is not True]
    asked = {degree for h in heights for degree in degrees_in(h)}
    groups = _groups(controller)
    for i, item in enumerate(controller.inputs):
        places = {place for j, place in asked if j == i}
        if not places or (not _strong(item) and len(places) < max(map(len, groups[i]))):
            return False
    return len(kinds) > 1


def named_terms(controller: Controller, i: int) -> frozenset[int] | None:
    """The terms of an input that sentences name; None where there are no sentences."""
    if not controller.sentences:
        return None
    return frozenset(t for rule in controller.sentences for j, t in terms_in(rule.antecedent) if j == i)


def _strong(item: Input) -> bool:
    return item.peaks is not None and len(item.peaks) > 1


def _groups(controller: Controller) -> list[dict[tuple[int, ...], int]]:
    """By input the terms that may be active together, with the share of raws that they are in."""
    return [_together(item, named_terms(controller, i)) for i, item in enumerate(controller.inputs)]


def _together(item: Input, named: frozenset[int] | None) -> dict[tuple[int, ...], int]:
    if not _strong(item):
        return groups_of(item, named)
    assert item.peaks is not None
    steps = [abs(b - a) / item.variable.raw.step for a, b in zip(item.peaks, item.peaks[1:], strict=False)]
    return {(k, k + 1): max(1, math.floor(abs(s))) for k, s in enumerate(steps)}


@lru_cache(maxsize=64)
def _plan(controller: Controller, precision: Precision) -> Plan:
    evens = [even_output(o, precision) for o in controller.outputs]
    blocks = list(_blocks(controller))
    keys = [tuple(map(_alike, block.named, evens)) for block in blocks]
    shares: dict[tuple[object, ...], float] = {}
    for key, block in zip(keys, blocks, strict=True):
        shares[key] = shares.get(key, 0.0) + block.share
    order = sorted(shares, key=lambda key: (-shares[key], keys.index(key)))
    lowest = tuple(tuple(min(block.named[o], default=0) for block in blocks) for o in range(len(evens)))
    kinds: list[Kind] = []
    for key in order:
        mine = [b for b, k in enumerate(keys) if k == key]
        places = tuple(len({low[b] for b in mine}) > 1 for low in lowest)
        kinds.append(replace(blocks[mine[0]], places=places, share=shares[key]))
    return Plan(tuple(kinds), tuple(order.index(k) for k in keys), lowest)


def _blocks(controller: Controller) -> Iterator[Kind]:
    """Every block as if it were alone of its kind."""
    groups = _groups(controller)
    sizes = [sum(g.values()) for g in groups]
    for chosen in product(*(g.items() for g in groups)):
        active = [terms for terms, _ in chosen]
        share = math.prod(raws / size for (_, raws), size in zip(chosen, sizes, strict=True))
        by = _of_sentences if controller.cells is None else _of_cells
        found = [by(controller, o, active) for o in range(len(controller.outputs))]
        yield Kind(tuple(n for n, _ in found), tuple(b for _, b in found), (False,) * len(found), share)


def _of_cells(controller: Controller, o: int, active: list[tuple[int, ...]]) -> tuple[Named, Height | None]:
    """What cells name of an output, and their largest strength."""
    cells = controller.cells
    assert cells is not None
    strides = [math.prod(cells.shape[i + 1 :]) for i in range(len(cells.shape))]
    named: dict[int, set[tuple[int, ...]]] = {}
    for corner in product(*(range(len(terms)) for terms in active)):
        term = cells.consequents[o][sum(active[i][place] * strides[i] for i, place in enumerate(corner))]
        if term != -1:
            named.setdefault(term, set()).add(corner)
    heights: Named = {k: formula(Cells(named[k])) for k in sorted(named)}
    return heights, formula(Cells(frozenset().union(*named.values()))) if named else None


def _of_sentences(controller: Controller, o: int, active: list[tuple[int, ...]]) -> tuple[Named, Height | None]:
    """The same of sentences."""
    parts: dict[int, list[Formula | bool]] = {}
    for rule in controller.sentences:
        for output, term in rule.consequents:
            if output == o:
                parts.setdefault(term, []).append(of_sentence(rule.antecedent, active))
    found = {k: joined(Higher, parts[k]) for k in sorted(parts)}
    heights: Named = {k: h for k, h in found.items() if h is not False}
    best = joined(Higher, list(heights.values()))
    return heights, None if best is False else best


def _alike(named: Named, even: EvenOutput | None) -> object:
    """The same for blocks of one code: terms at the same strengths, the same terms, or as far apart in an even output
    (those of half triangles are like no others)."""
    if even is None or not named or any(even.ends[k] for k in named) or min(even.peaks) < 0:
        return tuple(named.items())
    low = min(named)
    shapes = [(even.peaks[k] - even.peaks[low], even.counts[k], k in even.met and k + 1 in named) for k in named]
    return tuple((k - low, *shape, height) for (k, height), shape in zip(named.items(), shapes, strict=True))


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
    body.append(Comment("rules: the kind of the block in which they may fire"))
    number: Expr = Const(0)
    for found, groups in zip(degrees, _groups(controller), strict=True):
        number = build.add(build.mul(number, Const(len(groups))), found.first)
    if not isinstance(number, Const | Local):
        bound = build.local(scope.name("block"), number)
        body.append(Define(bound, number, True))
        number = bound
    kind = _kind(plan.kind_of, number, firing, scope)
    alone = controller.cells is not None and all(map(_strong, controller.inputs))
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
        heights = {t: _height(block, h, f"{output.name}_{output.terms[t].name}") for t, h in named.items()}
        if o in firing.strongest:
            best = kind.best[o]
            assert best is not None
            block.body.append(Assign(firing.strongest[o], _height(block, best, f"{output.name}_best")))
        if own.union.even is None:
            block.body += [Assign(own.levels[t], h) for t, h in heights.items()]
        elif kind.places[o]:
            block.body += own.union.shifted(heights, min(named), own.place, scope)
        else:
            block.body += own.union.at(heights, scope)
    return block.body


def _height(block: Block, height: Height, name: str) -> Local:
    return block.bind(name, Const(DEGREE_ONE)) if height is True else block.strength(height, name)
