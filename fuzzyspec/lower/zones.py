"""Fuzzification by zones: where terms are no strong partition, which of them are active follows from the raw's place.

Between two neighbouring breakpoints of an input's terms every degree is one straight line, and most are 0. A search
finds the zone; there the active terms' degrees alone are computed, and a number tells which terms they are.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Assign, Const, Define, Expr, Local, Stmt
from fuzzyspec.lower.fuzzify import Degrees, Piece, Reading, Run, search, straight_pieces
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


def zones_of(item: Input, named: Container[int] | None = None) -> list[Zone]:
    """An input's zones in order, as these of its terms part them (else all); together they are all legal raws."""
    raw = item.variable.raw
    terms = [straight_pieces(t.shape, raw) for t in item.terms]
    active = [(k, p) for k, pieces in enumerate(terms) for p in pieces if p.line.top and _asked(k, named)]
    cuts = sorted({0, raw.hi - raw.lo + 1} | {c for _, p in active for c in (p.start, p.end + 1)})
    found: list[Zone] = []
    for start, beyond in pairwise(cuts):
        here = tuple((k, p) for k, p in active if p.start <= start <= p.end)
        if found and found[-1].pieces == here:
            start = found.pop().start
        found.append(Zone(start, beyond - 1, here))
    return found


def _asked(term: int, named: Container[int] | None) -> bool:
    return named is None or term in named


def groups_of(item: Input, named: Container[int] | None = None) -> dict[tuple[int, ...], int]:
    """The sets of terms that can be active at once, and how many raws each has."""
    found: dict[tuple[int, ...], int] = {}
    for zone in zones_of(item, named):
        found[zone.terms] = found.get(zone.terms, 0) + zone.width
    return found


def zoned(item: Input, given: Reading, scope: Scope, named: Container[int] | None = None) -> tuple[list[Stmt], Degrees]:
    """Statements that compute the degrees of one input from its raw, zone by zone, and saturate it on the way.

    Only these of its terms, or all.
    """
    groups = tuple(groups_of(item, named))
    group = Local(scope.name(f"{item.name}_group"), "uint8", 0, len(groups) - 1)
    most = max(map(len, groups))
    members = tuple(Local(scope.name(f"{item.name}_mu"), "uint16", 0, DEGREE_ONE) for _ in range(most))
    body: list[Stmt] = [Define(m, Const(0), False) for m in ((group, *members) if len(groups) > 1 else members)]
    runs: list[Run] = []
    errors = [Fraction(0)] * len(item.terms)
    for zone in zones_of(item, named):
        number = groups.index(zone.terms)
        steps: list[Stmt] = [Assign(group, Const(number))] if number else []
        for member, (term, piece) in zip(members, zone.pieces, strict=False):
            steps.append(Assign(member, _degree(piece, given)))
            errors[term] = max(errors[term], piece.line.error / DEGREE_ONE)
        runs.append((zone.start, zone.end, steps))
    body += search(runs, given)
    first: Expr = group if len(groups) > 1 else Const(0)
    return body, Degrees("", most, first, tuple(errors), None, groups, members)


def _degree(piece: Piece, given: Reading) -> Expr:
    if not piece.line.slope:
        return Const(piece.line.offset >> piece.line.shift)
    value = piece.line.expr(given.beyond(piece.start, piece.end - piece.start))
    if value.hi <= DEGREE_ONE:
        return value
    # A line that a rounding takes above 1 is capped.
    return build.select(build.compare("<", value, Const(DEGREE_ONE)), value, Const(DEGREE_ONE))
