"""Integer polynomials of a clip height: ``base + d (a1 - d (t1 +- d t2))`` with d in Q15.

Each bracket is non-negative (docs/numbers.md), so everything is unsigned; each multiplier keeps 16 bits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
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
    """Integer coefficients; ``shift`` brings the product to the common scale."""

    base: int
    first: int
    second: int
    third: int
    third_adds: bool
    shift: int
    length: int

    def steps(self, d: Local, name: str, scope: Scope) -> tuple[list[Stmt], Expr]:
        """Statements and the value at ``d`` (0 .. length)."""
        if self.first == 0 and self.second == 0:
            return [], Const(self.base)
        body: list[Stmt] = []
        factor: Expr = Const(self.first)
        if self.second or self.third:
            slope: Expr = Const(self.second)
            if self.third:
                curve = product(d, self.third)
                if self.third_adds:
                    slope = build.add(curve, slope)
                else:
                    slope = build.sub_guarded(slope, curve, self.second)
                bound = build.local(scope.name(f"{name}_slope"), slope, ctype="uint32")
                body.append(Define(bound, slope, True))
                drop = build.rounded_shift(_bounded(d, bound), Q)
            else:
                drop = product(d, self.second)
            factor = build.sub_guarded(Const(self.first), drop, self.first)
            width = build.local(scope.name(f"{name}_width"), factor, ctype="uint32")
            body.append(Define(width, factor, True))
            factor = width
        value = build.rounded_shift(build.mul(d, factor), self.shift)
        return body, build.add(value, Const(self.base))

    def smallest_factor(self) -> int:
        """The least value of the outer bracket; negative means that the rounding broke it."""
        d = np.arange(self.length + 1, dtype=np.int64)
        half = 1 << (Q - 1)
        curve = (d * self.third + half) >> Q
        slope = self.second + curve if self.third_adds else self.second - curve
        if slope.min() < 0:
            return int(slope.min())
        return int((self.first - ((d * slope + half) >> Q)).min())


def _bounded(d: Local, factor: Local) -> Expr:
    """``d * factor``: their product stays below ``2**15 * first`` although their intervals alone do not show it."""
    return Binary("*", d, factor, 0, min(d.hi * factor.hi, 2**32 - 2**15))


def product(d: Local, factor: int) -> Expr:
    """``round(d * factor / 2**15)``, by the shortest exact way."""
    zeros = (factor & -factor).bit_length() - 1 if factor else 0
    if zeros >= Q:
        return build.mul(d, Const(factor >> Q))
    return build.rounded_shift(build.mul(d, Const(factor >> zeros)), Q - zeros)


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
    second = math.floor(-a2 * unit + HALF)
    third = math.floor(abs(a3) * unit + HALF)
    result = Horner(math.floor(scale * base + HALF), first, max(second, 0), third, a3 < 0, shift, length)
    # A rounding may take a bracket that touches 0 below it: give it back, one unit at a time.
    for _ in range(4):
        if result.smallest_factor() >= 0:
            return result
        slope_end = result.second - ((length * third + 2 ** (Q - 1)) >> Q)
        if not result.third_adds and slope_end < 0:
            result = Horner(result.base, result.first, result.second - slope_end, third, False, shift, length)
        else:
            result = Horner(result.base, result.first + 1, result.second, third, result.third_adds, shift, length)
    raise AssertionError("a bracket of a clipped set's polynomial is negative")
