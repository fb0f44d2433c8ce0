"""Integer polynomials of a clip height: ``base + d (a1 - d (t1 +- d t2))`` with d in Q15.

Each bracket is non-negative (docs/numbers.md), so everything is unsigned; each multiplier keeps 16 bits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Binary, Const, Define, Expr, Local, Stmt
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.scope import Scope

HALF = Fraction(1, 2)
Q = 15


@dataclass(frozen=True, slots=True)
class Horner:
    """Integer coefficients; ``shift`` brings the product to the common scale.

    ``slope_bits`` are the fraction bits of d times the inner bracket: 15, less on short pieces, where that bracket
    may be large and d has few bits.
    """

    base: int
    first: int
    second: int
    third: int
    third_adds: bool
    shift: int
    length: int
    slope_bits: int

    def steps(self, d: Local, name: str, scope: Scope) -> tuple[list[Stmt], Expr]:
        """Statements and the value at ``d`` (0 .. length)."""
        if self.first == 0 and self.second == 0:
            return [], Const(self.base)
        body: list[Stmt] = []
        factor: Expr = Const(self.first)
        if self.second or self.third:
            slope: Expr = Const(self.second)
            if self.third:
                curve = product(d, self.third, Q)
                if self.third_adds:
                    slope = build.add(curve, slope)
                else:
                    slope = build.sub_guarded(slope, curve, self.second)
                bound = build.local(scope.name(f"{name}_slope"), slope, ctype="uint32")
                body.append(Define(bound, slope, True))
                drop = build.rounded_shift(_bounded(d, bound), self.slope_bits)
            else:
                drop = product(d, self.second, self.slope_bits)
            factor = build.sub_guarded(Const(self.first), drop, self.first)
            width = build.local(scope.name(f"{name}_width"), factor, ctype="uint32")
            body.append(Define(width, factor, True))
            factor = width
        # Not rounded: where a sum has more bits than its factors, half a unit is not worth an addition.
        value = build.shift_right(build.mul(d, factor), self.shift)
        return body, build.add(value, Const(self.base))

    def smallest_factor(self) -> int:
        """The least value of the outer bracket; negative means that the rounding broke it."""
        d = np.arange(self.length + 1, dtype=np.int64)
        half = 1 << (self.slope_bits - 1)
        curve = (d * self.third + (1 << (Q - 1))) >> Q
        slope = self.second + curve if self.third_adds else self.second - curve
        if slope.min() < 0:
            return int(slope.min())
        return int((self.first - ((d * slope + half) >> self.slope_bits)).min())


def _bounded(d: Local, factor: Local) -> Expr:
    """``d * factor``: their product stays below ``2**15 * first`` although their intervals alone do not show it."""
    return Binary("*", d, factor, 0, min(d.hi * factor.hi, 2**32 - 2**15))


def product(d: Local, factor: int, bits: int) -> Expr:
    """``round(d * factor / 2**bits)``, by the shortest exact way."""
    zeros = (factor & -factor).bit_length() - 1 if factor else 0
    if zeros >= bits:
        return build.mul(d, Const(factor >> bits))
    return build.rounded_shift(build.mul(d, Const(factor >> zeros)), bits - zeros)


def fit(base: Fraction, coefficients: tuple[Fraction, Fraction, Fraction], length: int, scale: Fraction) -> Horner:
    """Integers for ``scale * (base + a1 x + a2 x**2 + a3 x**3)``, x = d / 2**15, with ``a1 >= 0 >= a2``.

    The outer bracket takes the finest scale with at most 16 bits.
    """
    a1, a2, a3 = (scale * a for a in coefficients)
    shift = 0
    while shift < 31 and a1 and a1 * Fraction(2 ** (shift + 1), DEGREE_ONE) <= 2**16:
        shift += 1
    unit = Fraction(2**shift, DEGREE_ONE)
    first = math.floor(a1 * unit + HALF)
    bits = Q
    while bits > 4 and 2 * length <= 1 << bits:
        bits -= 1
    slope_unit = unit / 2 ** (Q - bits)
    second = math.floor(-a2 * slope_unit + HALF)
    third = math.floor(abs(a3) * slope_unit + HALF)
    result = Horner(math.floor(scale * base + HALF), first, max(second, 0), third, a3 < 0, shift, length, bits)
    # A rounding may take a bracket that touches 0 below it: give it back, one unit at a time.
    for _ in range(4):
        if result.smallest_factor() >= 0:
            return result
        slope_end = result.second - ((length * third + 2 ** (Q - 1)) >> Q)
        if not result.third_adds and slope_end < 0:
            result = replace(result, second=result.second - slope_end)
        else:
            result = replace(result, first=result.first + 1)
    raise AssertionError("a bracket of a clipped set's polynomial is negative")
