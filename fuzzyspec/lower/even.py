"""Even outputs: triangles of one width that meet at 1/2 or not at all, whose areas are three integer functions.

With the spacing as unit, a half triangle clipped at c has the area ``c - c**2 / 2``, the overlap of two neighbours
``c - c**2`` (up to 1/2), and an end's half triangle has, about its peak, the moment ``(c - c**2) / 2 + c**3 / 6``.
Whole triangles and overlaps have their means at their middles. So squares and, for the ends, cubes of the clip heights
are all that any program for such an output computes, and every such program adds the same integers.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Const, Define, Expr, Local, Stmt
from fuzzyspec.lower.clipped import ClippedSet, clipped_sets
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.scope import Scope
from fuzzyspec.lower.sets import Evaluated, Floats, Scale, all_heights, closed_form
from fuzzyspec.lower.strategy import Precision
from fuzzyspec.model.controller import Output

MAX_TERMS = 8
"""Sets of terms are bits of a byte."""


@dataclass(frozen=True)
class Bits:
    """A half triangle's area of 1/2 spacing is ``2**area``, its moment's unit that times half a spacing.

    Areas times the range keep ``divisor`` bits: 24, so that two hardware divisions make a quotient, or 16: one does.
    """

    area: int
    divisor: int

    @property
    def height_shift(self) -> int:
        return self.area - 14

    @property
    def moment_bias(self) -> int:
        """Keeps a sum of moments positive: an end's cube may be subtracted before the rest of its moment comes."""
        return 1 << (self.area + 1)


BITS: Mapping[Precision, Bits] = {"full": Bits(22, 24), "short": Bits(14, 16)}
MAX_SPAN = 20
"""Half spacings in a range, and what is integrated over: keeps sums of moments below 2**32."""


@dataclass(frozen=True)
class EvenOutput:
    """Areas are counted in ``unit`` half triangles, places in equal parts of the range, of which it has ``span``.

    By term, ``halves``: the half triangles that it is made of, ``counts``: its area, ``peaks``: its place, ``ends``: 1
    for a half triangle that falls, -1 for one that rises, 0 for a whole one. ``met``: the terms that overlap the next
    one. ``half``: a half triangle's area, relative to the range. ``domain``: the area of all that is integrated over.
    """

    forms: tuple[ClippedSet, ...]
    halves: tuple[int, ...]
    peaks: tuple[int, ...]
    ends: tuple[int, ...]
    met: tuple[int, ...]
    span: int
    domain: int
    half: Fraction
    unit: int
    bits: Bits

    @property
    def counts(self) -> tuple[int, ...]:
        return tuple(h // self.unit for h in self.halves)

    @property
    def scale(self) -> Scale:
        """Integer units of a relative area."""
        return Scale(2**self.bits.area / (self.half * self.unit), self.span, True)

    @property
    def shift(self) -> int:
        """What area times span, and moment, are shortened by before they are divided."""
        return max(0, (self.domain * self.span << self.bits.area).bit_length() - self.bits.divisor)


def even_output(output: Output, precision: Precision = "full") -> EvenOutput | None:
    """The output's shape, or None where it is not that regular. Raises TooManySets."""
    if not 2 <= len(output.terms) <= MAX_TERMS:
        return None
    forms = clipped_sets(output)
    singles = [f for f in forms if len(f.members) == 1]
    if len(singles) < len(output.terms) or any(len(f.pieces) != 1 for f in forms):
        return None
    widths = [f.pieces[0].width for f in singles]
    spacing = min(w if f.moment_sign else w / 2 for f, (w, _) in zip(singles, widths, strict=True))
    halves = [w / spacing for w, _ in widths]
    if any(h not in (1, 2) or fall != -w for h, (w, fall) in zip(halves, widths, strict=True)):
        return None
    if any((f.moment_sign == 0) != (h == 2) for f, h in zip(singles, halves, strict=True)):
        return None
    pairs = forms[len(singles) :]
    if any(f.members != (f.members[0], f.members[0] + 1) or f.moment_sign for f in pairs):
        return None
    if any(f.pieces[0].width != (spacing, -2 * spacing) for f in pairs):
        return None
    span = 2 / spacing
    peaks = [f.reference * span for f in singles]
    middles = [f.reference * span for f in pairs]
    domain = (output.integrate_hi - output.integrate_lo) / (output.variable.hi - output.variable.lo) * span
    if any(x.denominator != 1 for x in (span, domain, *peaks, *middles)) or max(span, domain) > MAX_SPAN:
        return None
    if any(m != peaks[f.members[0]] + 1 or m != peaks[f.members[1]] - 1 for m, f in zip(middles, pairs, strict=True)):
        return None
    # Without ends and overlaps all counts may have a factor in common, and without ends all places.
    ends = tuple(f.moment_sign for f in singles)
    unit = 1 if pairs else math.gcd(*map(int, halves))
    part = 1 if any(ends) else math.gcd(int(span), *map(int, peaks), *map(int, middles))
    return EvenOutput(
        forms,
        tuple(map(int, halves)),
        tuple(int(p) // part for p in peaks),
        ends,
        tuple(f.members[0] for f in pairs),
        int(span) // part,
        int(domain) // unit,
        1 / span,
        unit,
        BITS[precision],
    )


def square(height: Local, bits: Bits, name: str, scope: Scope) -> Define:
    """``c**2`` in the area's unit, rounded down: ``h**2 / 2**8`` at full precision."""
    value = build.shift_right(build.mul(height, height), 30 - bits.area)
    return Define(build.local(scope.name(f"{name}_square"), value, ctype="uint32"), value, True)


def cube(height: Local, squared: Local, bits: Bits) -> Expr:
    """``c**3 / 6`` in the moment's unit, from h and its square: 43691 / 2**10 is 2**8 / 6."""
    kept = min(bits.area, 16)
    rough = build.shift_right(build.mul(build.shift_right(squared, bits.area - kept), height), 15)
    return build.shift_right(build.mul(rough, Const(43691)), 32 - max(bits.area, 16))


def evaluate_even(form: ClippedSet, even: EvenOutput, height: Local, scope: Scope, name: str) -> Evaluated:
    """A half triangle (and its moment, where it is an end's) or an overlap at a height; proved at every height."""
    area_error, moment_error = _errors(form, even)
    steps, area, moment = _draft(form, even.bits, height, scope, name)
    return Evaluated(steps, area, moment, area_error, moment_error, (len(form.members), moment is not None))


@lru_cache(maxsize=256)
def _errors(form: ClippedSet, even: EvenOutput) -> tuple[Floats, Floats]:
    height = Local("h", "uint16", 0, DEGREE_ONE)
    draft, area, moment = _draft(form, even.bits, height, Scope(), "set")
    areas, moments = all_heights(draft, area, moment, height)
    count = even.halves[form.members[0]] if len(form.members) == 1 else 1
    exact_area, exact_moment = closed_form(form)
    half, slack = float(even.half / 2**even.bits.area), 2.0**-44  # float64: under 2**8 roundings of values below 1
    area_error = np.abs(areas * half - exact_area / count) + slack
    if moment is None:
        return area_error, np.zeros_like(exact_area)
    return area_error, np.abs(moments * half / even.span - exact_moment) + slack


def _draft(
    form: ClippedSet, bits: Bits, height: Local, scope: Scope, name: str
) -> tuple[list[Stmt], Local, Local | None]:
    body: list[Stmt] = []
    pair = len(form.members) == 2
    if pair:
        top = DEGREE_ONE // 2
        clipped = Local(scope.name(f"{name}_c"), "uint16", 0, top)
        body.append(Define(clipped, build.least(height, Const(top)), True))
        height = clipped
    squared = square(height, bits, name, scope)
    body.append(squared)
    times = 2 if pair else 1
    less = build.mul(squared.local, Const(times))
    value = build.sub_guarded(build.shift_left(height, bits.height_shift), less, 2**bits.area // times + times - 1)
    area = build.local(scope.name(f"{name}_part"), value, ctype="uint32")
    body.append(Define(area, value, True))
    if pair or not form.moment_sign:
        return body, area, None
    cubed = cube(height, squared.local, bits)
    # The area less another square, more the cube: never negative, for c >= c**2 >= c**2 - c**3 / 3.
    turned = build.sub_guarded(build.add(area, cubed), squared.local, cubed.hi + 2)
    moment = build.local(scope.name(f"{name}_turn"), turned, ctype="uint32")
    body.append(Define(moment, turned, True))
    return body, area, moment
