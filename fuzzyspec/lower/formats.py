"""Integer formats of an interpolation: its places, the degrees of its last inputs, and how its result becomes a raw.

**Narrow**: all places of every output are small multiples of one step, so that a place times a degree fits 16 bits, and
two outputs go into one word. **Wide**: places are raw counts of 16 bits. Lemma "multilinear" of docs/numbers.md.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Const, Define, Expr, Stmt
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.controller import CellRules, Controller
from fuzzyspec.model.term import Singleton
from fuzzyspec.model.variable import Variable

HALF = Fraction(1, 2)
FIELD_MAX = 65535
"""Of a wide place, and of a narrow place times a degree."""
DEGREE_BITS = DEGREE_ONE.bit_length() - 1
TOLERATED = Fraction(15, 100000)
"""The narrow format may cost this part of an output's range beyond what the wide one costs."""


@dataclass(frozen=True)
class Places:
    """One output's places by cell: ``integers`` times ``unit`` above ``base``, in counts from the lowest legal raw;
    each is off by at most ``error`` counts. ``edges`` and ``mixed`` are relative to the range (lemma)."""

    variable: Variable
    integers: tuple[int, ...]
    base: Fraction
    unit: Fraction
    error: Fraction
    edges: tuple[Fraction, ...]
    mixed: Fraction

    @property
    def most(self) -> int:
        return max(self.integers)

    @property
    def counts(self) -> int:
        return self.variable.raw.hi - self.variable.raw.lo

    @property
    def sliver(self) -> Fraction:
        """The larger of the parts of a count that lie between the range's ends and the legal raws next to them."""
        low, top = _counts(self.variable, (Fraction(0), Fraction(1)))
        return max(-low, top - self.counts)


@dataclass(frozen=True)
class Format:
    """How a whole controller is interpolated.

    ``inner`` inputs (the last one or two) are combined first, as one sum of places times weights of ``bits`` bits; it
    is shifted right by ``dropped``. Each of ``shifts`` is that of one outer input's interpolation, the last input's
    first.
    """

    narrow: bool
    inner: int
    bits: int
    dropped: int
    shifts: tuple[int, ...]
    outputs: tuple[Places, ...]

    def floors(self) -> Fraction:
        """What the shifts lose at most, in units of a place: later interpolations do not enlarge it."""
        scale, lost = self.bits - self.dropped, Fraction(0)
        if self.dropped:
            lost += Fraction(1, 2**scale)
        for shift in self.shifts:
            scale += DEGREE_BITS - shift
            if shift:
                lost += Fraction(1, 2**scale)
        return lost

    @property
    def scale(self) -> int:
        """Fraction bits of the interpolated place."""
        return self.bits - self.dropped + sum(DEGREE_BITS - s for s in self.shifts)

    def rounding(self, o: int) -> Fraction:
        """Bounds, in counts, what places, products of degrees and shifts of an output are rounded by."""
        found = self.outputs[o]
        width = abs(found.variable.hi - found.variable.lo) / abs(found.variable.raw.step)
        products = found.mixed * width / 2 ** (self.bits + 1) if self.inner > 1 else Fraction(0)
        return found.error + self.floors() * found.unit + products


def format_of(controller: Controller, cells: CellRules) -> Format:
    """The narrow format where it costs little, else the wide one."""
    tables = [_table(controller, cells, o) for o in range(len(controller.outputs))]
    inner = min(2, len(cells.shape))
    small = [_small(t) for t in tables]
    most = max(p.most for p in small)
    bits = min(DEGREE_BITS, (FIELD_MAX // max(most, 1)).bit_length() - 1)
    if bits > 0:
        outer = len(cells.shape) - inner
        # The first outer interpolation keeps a bit more than 16, the last one goes back to them.
        shifts = (14, *[15] * (outer - 2), 16) if outer > 1 else (15,) * outer
        narrow = Format(True, inner, bits, 0, shifts, tuple(small))
        if all(_cost(narrow, o) <= TOLERATED for o in range(len(small))):
            return narrow
    wide = [_wide(t) for t in tables]
    if len(cells.shape) == inner:
        return Format(False, inner, DEGREE_BITS, 0, (), tuple(wide))
    # 17 bits are kept between the interpolations; the last one's 32 go into the result.
    shifts = (*[15] * (len(cells.shape) - inner - 1), 0)
    return Format(False, inner, DEGREE_BITS, DEGREE_BITS - 1, shifts, tuple(wide))


def as_counts(fmt: Format, o: int, value: Expr, name: str, steps: list[Stmt], scope: Scope) -> tuple[Expr, Fraction]:
    """An interpolated place as counts, rounded to nearest and capped, and a bound of what this step is off by."""
    places = fmt.outputs[o]
    if fmt.narrow:
        factor, offset, shift = _line(places, fmt.scale, value.hi)
        near = build.shift_right(build.add(build.mul(value, Const(factor)), Const(offset)), shift)
        drift = abs(Fraction(factor, 2**shift) - places.unit / 2**fmt.scale) * value.hi
        off = drift + abs(Fraction(offset, 2**shift) - HALF - places.base)
    else:
        near = build.rounded_shift(value, fmt.scale + (1 / places.unit).numerator.bit_length() - 1)
        off = Fraction(0)
    if near.hi > places.counts:
        bound = build.local(scope.name(f"{name}_steps"), near)
        steps.append(Define(bound, near, True))
        near = build.least(bound, Const(places.counts))
    return near, off + HALF


def _line(places: Places, scale: int, most: int) -> tuple[int, int, int]:
    """Factor, offset and shift: by 16 where the factor is then good to a thirty-second of a count, else as far as 32
    bits go."""
    exact = places.unit / 2**scale

    def at(shift: int) -> tuple[int, int]:
        return math.floor(exact * 2**shift + HALF), max(0, math.floor((places.base + HALF) * 2**shift + HALF))

    shift = 16
    while shift and sum(_times(at(shift), most)) > build.UINT32_MAX:
        shift -= 1
    if abs(Fraction(at(shift)[0], 2**shift) - exact) * most * 32 > 1:
        while shift < 31 and sum(_times(at(shift + 1), most)) <= build.UINT32_MAX:
            shift += 1
    return *at(shift), shift


def _times(line: tuple[int, int], most: int) -> tuple[int, int]:
    return line[0] * most, line[1]


def _cost(fmt: Format, o: int) -> Fraction:
    """What a format loses to its shifts and to the bits of its inner degrees, relative to the range."""
    found = fmt.outputs[o]
    width = abs(found.variable.hi - found.variable.lo) / abs(found.variable.raw.step)
    degrees: Fraction = sum(found.edges[-fmt.inner :], Fraction(0)) / 2 ** (fmt.bits + 1)
    return degrees + fmt.rounding(o) / width


@dataclass(frozen=True)
class _Table:
    """What the cells name: by cell one of the terms, whose places are relative to the range."""

    variable: Variable
    shape: tuple[int, ...]
    terms: tuple[int, ...]
    places: tuple[Fraction, ...]

    @property
    def used(self) -> list[int]:
        return sorted(set(self.terms))

    @property
    def counts(self) -> list[Fraction]:
        return _counts(self.variable, self.places)

    def by_cell(self, integers: Mapping[int, int]) -> tuple[int, ...]:
        return tuple(integers[t] for t in self.terms)

    def steepness(self) -> tuple[tuple[Fraction, ...], Fraction]:
        """The largest difference of two neighbours along each input, and the largest mixed one over the last two."""
        common = math.lcm(*(p.denominator for p in self.places))
        # Of integers of any size.
        cells = np.array([int(self.places[t] * common) for t in self.terms], dtype=object).reshape(self.shape)
        along = [np.diff(cells, axis=i) for i in range(len(self.shape))]
        mixed = np.diff(along[-1], axis=-2) if len(self.shape) > 1 else np.zeros(1, dtype=object)
        edges = tuple(Fraction(int(abs(d).max()), common) for d in along)
        return edges, Fraction(int(abs(mixed).max()), common)


def _table(controller: Controller, cells: CellRules, o: int) -> _Table:
    variable = controller.outputs[o].variable
    places: list[Fraction] = []
    for term in controller.outputs[o].terms:
        assert isinstance(term.shape, Singleton)
        places.append((term.shape.at - variable.lo) / (variable.hi - variable.lo))
    return _Table(variable, cells.shape, cells.consequents[o], tuple(places))


def _counts(variable: Variable, places: Sequence[Fraction]) -> list[Fraction]:
    """Relative places as counts from the legal raw of the lowest value."""
    raw = variable.raw
    at_lo, at_hi = raw.position(variable.lo), raw.position(variable.hi)
    low = at_lo - raw.lo if raw.step > 0 else raw.hi - at_lo
    return [low + abs(at_hi - at_lo) * p for p in places]


def _small(table: _Table) -> Places:
    exact = table.counts
    base = min(exact[t] for t in table.used)
    unit = Fraction(0)
    for t in table.used:
        unit = _common(unit, exact[t] - base)
    unit = unit or Fraction(1)
    integers = {t: int((exact[t] - base) / unit) for t in table.used}
    return Places(table.variable, table.by_cell(integers), base, unit, Fraction(0), *table.steepness())


def _common(a: Fraction, b: Fraction) -> Fraction:
    """The greatest common divisor of two rationals."""
    denominator = math.lcm(a.denominator, b.denominator)
    return Fraction(math.gcd(int(a * denominator), int(b * denominator)), denominator)


def _wide(table: _Table) -> Places:
    exact, raw = table.counts, table.variable.raw
    bits = 0
    while (raw.hi - raw.lo + 1) << (bits + 1) <= FIELD_MAX:
        bits += 1
    integers = {t: min(FIELD_MAX, max(0, math.floor(exact[t] * 2**bits + HALF))) for t in table.used}
    worst = max(abs(Fraction(integers[t], 2**bits) - exact[t]) for t in table.used)
    unit = Fraction(1, 2**bits)
    return Places(table.variable, table.by_cell(integers), Fraction(0), unit, worst, *table.steepness())
