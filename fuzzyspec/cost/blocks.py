"""The pieces between the breakpoints of inputs' terms, and the blocks that they make, for the counted limit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from math import ceil, log2, prod

from fuzzyspec.model.controller import Controller, Input
from fuzzyspec.model.term import PiecewiseLinear
from fuzzyspec.model.variable import RAW_LIMITS

MOST = 4096
"""Blocks that are looked at; of more, so many, evenly."""


@dataclass(frozen=True, slots=True)
class Piece:
    """A part of an input's range on which every term is straight: its share of the range; the active terms, of them the
    ``sloped``; and the degrees that are 1 minus another."""

    share: Fraction
    active: tuple[int, ...]
    sloped: tuple[int, ...]
    complements: int


@dataclass(frozen=True)
class Axis:
    """An input cut into pieces."""

    given: Input

    @cached_property
    def pieces(self) -> tuple[Piece, ...]:
        """In order of their values."""
        lo, hi = self.given.variable.lo, self.given.variable.hi
        inside = {x for t in self.given.terms for x, _ in _points(t.shape) if lo < x < hi}
        ends = [lo, *sorted(inside), hi]
        return tuple(self._piece(a, b, (b - a) / (hi - lo)) for a, b in pairwise(ends))

    def _piece(self, a: Fraction, b: Fraction, share: Fraction) -> Piece:
        middle, later = (a + b) / 2, (a + 3 * b) / 4
        degrees = [(height(t.shape, middle), height(t.shape, later)) for t in self.given.terms]
        active = tuple(k for k, (y, z) in enumerate(degrees) if y or z)
        sloped = tuple(k for k in active if degrees[k][0] != degrees[k][1])
        told = [tuple(degrees[k]) for k in sloped]
        pairs = sum((1 - y, 1 - z) in told[:i] for i, (y, z) in enumerate(told))
        return Piece(share, active, sloped, pairs)

    def mean_tests(self, *, halves: bool) -> float:
        """Tests that find the piece: no tree takes fewer on the mean than the entropy of the shares. With ``halves``
        also which half of a sloped piece, which is one more."""
        found = -sum(float(p.share) * log2(p.share) for p in self.pieces)
        return found + sum(float(p.share) for p in self.pieces if p.sloped) if halves else found

    def _open(self) -> list[Piece]:
        """The pieces at those ends of the range that the raw type can pass."""
        raw = self.given.variable.raw
        first, last = self.pieces[0], self.pieces[-1]
        if raw.step < 0:
            first, last = last, first
        least, most = RAW_LIMITS[raw.ctype]
        return [p for p, passed in ((first, raw.lo > least), (last, raw.hi < most)) if passed]

    @property
    def sides(self) -> int:
        """How many ends of the range the raw type can pass."""
        return len(self._open())

    @property
    def lengths(self) -> list[int]:
        """Of the range, where the raw type can pass its upper end: what a raw that is counted from the low one is
        compared with there."""
        raw = self.given.variable.raw
        least, most = RAW_LIMITS[raw.ctype]
        return [raw.hi - (raw.lo if raw.lo > least else 0)] if raw.hi < most else []

    def mean_saturation(self, *, halves: bool) -> float:
        """Tests for these ends: in the piece, or half of it, that lies there."""
        return sum(float(p.share) / (2 if halves and p.sloped else 1) for p in self._open())

    @property
    def thresholds(self) -> list[int]:
        """The raws that are compared with: breakpoints, the middles of sloped pieces, the ends."""
        raw = self.given.variable.raw
        at, found = self.given.variable.lo, [raw.lo, raw.hi]
        for piece in self.pieces:
            width = piece.share * (self.given.variable.hi - self.given.variable.lo)
            found += [ceil(raw.position(at + width / 2))] if piece.sloped else []
            at += width
            found.append(ceil(raw.position(at)))
        return found[:-1]

    @property
    def even(self) -> bool:
        """Whether peaks lie evenly from end to end of the range."""
        peaks, variable = self.given.peaks, self.given.variable
        if peaks is None or (peaks[0], peaks[-1]) != (variable.lo, variable.hi):
            return False
        return len({b - a for a, b in pairwise(peaks)}) == 1

    @property
    def shifted(self) -> bool:
        """Whether the peaks are multiples of one power of two of raws, so that degrees are bits of the raw; or as good
        as, where the range is all of the raw type and its pieces a power of two."""
        peaks = self.given.peaks
        count = len(self.pieces)
        if self.even and not self.sides and count & (count - 1) == 0:
            return True
        if peaks is None or len(peaks) < 2:
            return False
        places = [self.given.variable.raw.position(p) for p in peaks]
        steps = {b - a for a, b in pairwise(places)}
        step = min(steps)
        whole = len(steps) == 1 and step > 0 and step.denominator == 1
        return whole and step.numerator & (step.numerator - 1) == 0 and places[0] % step == 0


_LIMITS = {
    "uint8": (0, 2**8 - 1),
    "int8": (-(2**7), 2**7 - 1),
    "uint16": (0, 2**16 - 1),
    "int16": (-(2**15), 2**15 - 1),
}


def _points(shape: object) -> tuple[tuple[Fraction, Fraction], ...]:
    return shape.points if isinstance(shape, PiecewiseLinear) else ()


def height(shape: object, x: Fraction) -> Fraction:
    """A membership at a value that is no breakpoint; 0 of a singleton."""
    points = _points(shape)
    if not points:
        return Fraction(0)
    if x <= points[0][0]:
        return points[0][1]
    for (a, y), (b, z) in pairwise(points):
        if a < x <= b:
            return y + (z - y) * (x - a) / (b - a)
    return points[-1][1]


@dataclass(frozen=True, slots=True)
class Block:
    """A piece of every input. ``named[o]``: for every active cell the term of output o, unless unset;
    ``sloped``: how many degrees of every active cell are not known to be 1."""

    share: float
    pieces: tuple[Piece, ...]
    named: tuple[tuple[int, ...], ...]
    sloped: tuple[int, ...]


def blocks(controller: Controller, axes: Sequence[Axis]) -> Iterator[Block]:
    """All blocks, or evenly chosen ones with shares of their sum."""
    sizes = [len(a.pieces) for a in axes]
    total = prod(sizes)
    chosen = range(total) if total <= MOST else [total * k // MOST for k in range(MOST)]
    picked = [tuple(a.pieces[i] for a, i in zip(axes, _digits(k, sizes), strict=True)) for k in chosen]
    shares = [prod(float(p.share) for p in pieces) for pieces in picked]
    whole = sum(shares)
    for share, pieces in zip(shares, picked, strict=True):
        cells = list(_cells(controller, pieces))
        named = tuple(tuple(o[c] for c, _ in cells if o[c] >= 0) for o in _consequents(controller))
        yield Block(share / whole, pieces, named, tuple(n for _, n in cells))


def _digits(number: int, sizes: Sequence[int]) -> list[int]:
    found = []
    for size in reversed(sizes):
        number, digit = divmod(number, size)
        found.append(digit)
    return found[::-1]


def _consequents(controller: Controller) -> tuple[tuple[int, ...], ...]:
    return () if controller.cells is None else controller.cells.consequents


def _cells(controller: Controller, pieces: Sequence[Piece]) -> Iterator[tuple[int, int]]:
    """Every active cell, and how many of its degrees are sloped."""
    if controller.cells is None:
        return
    found = [(0, 0)]
    for size, piece in zip(controller.cells.shape, pieces, strict=True):
        found = [(cell * size + k, n + (k in piece.sloped)) for cell, n in found for k in piece.active]
    yield from found
