"""Fuzzification by zones: where terms are no strong partition, which of them are active follows from the raw's place.

Between two neighbouring breakpoints of an input's terms every degree is one straight line, and most are 0. A search
finds the zone; there the active terms' degrees alone are computed, and a number tells which terms they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Assign, Branch, Const, Define, Expr, Local, Stmt
from fuzzyspec.lower.fuzzify import Degrees, Piece, position_expr, straight_pieces
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.controller import Input


@dataclass(frozen=True, slots=True)
class Zone:
    """Raw positions ``start .. end`` and the pieces of the terms that are active there, by term."""

    start: int
    end: int
    pieces: tuple[tuple[int, Piece], ...]

    @property
    def terms(self) -> tuple[int, ...]:
        return tuple(k for k, _ in self.pieces)

    @property
    def width(self) -> int:
        return self.end - self.start + 1


def zones_of(item: Input) -> list[Zone]:
    """An input's zones in order; together they are all legal raws."""
    raw = item.variable.raw
    terms = [straight_pieces(t.shape, raw) for t in item.terms]
    active = [(k, p) for k, pieces in enumerate(terms) for p in pieces if p.line.top]
    cuts = sorted({0, raw.hi - raw.lo + 1} | {c for _, p in active for c in (p.start, p.end + 1)})
    found: list[Zone] = []
    for start, beyond in pairwise(cuts):
        here = tuple((k, p) for k, p in active if p.start <= start <= p.end)
        if found and found[-1].pieces == here:
            start = found.pop().start
        found.append(Zone(start, beyond - 1, here))
    return found


def groups_of(item: Input) -> dict[tuple[int, ...], int]:
    """The sets of terms that can be active at once, and how many raws each has."""
    found: dict[tuple[int, ...], int] = {}
    for zone in zones_of(item):
        found[zone.terms] = found.get(zone.terms, 0) + zone.width
    return found


def zoned(item: Input, raw: Expr, scope: Scope) -> tuple[list[Stmt], Degrees]:
    """Statements that compute the degrees of one input from its saturated raw, zone by zone."""
    body: list[Stmt] = []
    at = position_expr(item.variable.raw, raw)
    if not isinstance(at, Local):
        bound = build.local(scope.name(f"{item.name}_at"), at)
        body.append(Define(bound, at, True))
        at = bound
    zones = zones_of(item)
    groups = tuple(groups_of(item))
    group = Local(scope.name(f"{item.name}_group"), "uint8", 0, len(groups) - 1)
    most = max(map(len, groups))
    members = tuple(Local(scope.name(f"{item.name}_mu"), "uint16", 0, DEGREE_ONE) for _ in range(most))
    body += [Define(m, Const(0), False) for m in ((group, *members) if len(groups) > 1 else members)]
    body += _search(zones, groups, group, members, at)
    error = max(p.line.error for z in zones for _, p in z.pieces) / DEGREE_ONE
    first: Expr = group if len(groups) > 1 else Const(0)
    return body, Degrees("", most, first, error, None, groups, members)


def _search(
    zones: list[Zone], groups: tuple[tuple[int, ...], ...], group: Local, members: tuple[Local, ...], at: Local
) -> list[Stmt]:
    """What leads to the zones by few comparisons, the wider a zone the fewer."""
    if len(zones) == 1:
        (zone,) = zones
        number = groups.index(zone.terms)
        own: list[Stmt] = [Assign(group, Const(number))] if number else []
        return own + [Assign(m, _degree(p, at)) for m, (_, p) in zip(members, zone.pieces, strict=False)]
    cut = min(
        range(1, len(zones)),
        key=lambda c: abs(sum(z.width for z in zones[:c]) - sum(z.width for z in zones[c:])),
    )
    below = _search(zones[:cut], groups, group, members, at)
    beyond = _search(zones[cut:], groups, group, members, at)
    return [Branch(build.compare("<", at, Const(zones[cut].start)), tuple(below), tuple(beyond))]


def _degree(piece: Piece, at: Local) -> Expr:
    if not piece.line.slope:
        return Const(piece.line.offset >> piece.line.shift)
    value = piece.line.expr(build.sub_guarded(at, Const(piece.start), piece.end - piece.start))
    if value.hi <= DEGREE_ONE:
        return value
    # A line that a rounding takes above 1 is capped.
    return build.select(build.compare("<", value, Const(DEGREE_ONE)), value, Const(DEGREE_ONE))
