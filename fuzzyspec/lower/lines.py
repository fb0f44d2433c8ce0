"""Straight lines in integers: ``y = (offset + slope * u) >> shift`` or, falling, ``(offset - slope * u) >> shift``."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Const, Expr

DEGREE_ONE = 1 << 15
"""A degree of 1: degrees are Q15 in uint16."""

MAX_SHIFT = 16
"""``y <= 2**15`` with 16 fraction bits stays below 2**32."""

HALF = Fraction(1, 2)


@dataclass(frozen=True, slots=True)
class Line:
    """A rounded line over ``u = 0 .. length``.

    ``error`` bounds ``|y - (start + slope * u)|`` in units of y (lemma "line" of docs/numbers.md); ``top`` is the
    largest y it takes, which may exceed the true one by a rounding.
    """

    slope: int
    falling: bool
    offset: int
    shift: int
    length: int
    error: Fraction
    top: int

    def expr(self, u: Expr) -> Expr:
        """The line at ``u``, an atom with ``0 <= u <= length``."""
        if self.length == 0:
            return Const(self.offset >> self.shift)
        step = build.mul(u, Const(self.slope))
        if self.falling:
            value = build.sub_guarded(Const(self.offset), step, self.offset)
        else:
            value = build.add(step, Const(self.offset))
        return build.shift_right(value, self.shift)


@lru_cache(maxsize=1024)
def fit(start: Fraction, slope: Fraction, length: int) -> Line:
    """The integer line nearest to ``start + slope * u`` over ``u = 0 .. length``, all values in [0, 2**15].

    The multiplier is rounded; the offset splits the drift that this causes over the line evenly.
    """
    for shift in range(MAX_SHIFT):
        if (slope * 2**shift).denominator == 1 and (start * 2**shift).denominator == 1:
            break
    else:
        shift = MAX_SHIFT
    scale = 2**shift
    half = HALF if shift else Fraction(0)
    falling = slope < 0
    m = math.floor(abs(slope) * scale + HALF)
    while True:
        drift = (m - abs(slope) * scale) * length * (-1 if falling else 1)
        offset = max(0, math.floor((start + half) * scale - drift / 2 + HALF))
        if not falling or offset - m * length >= 0:
            break
        m -= 1
    signed = -m if falling else m
    at_start = Fraction(offset, scale) - half - start
    at_end = at_start + (Fraction(signed, scale) - slope) * length
    top = max(offset, offset + signed * length) >> shift
    error = half + max(abs(at_start), abs(at_end))
    if shift:
        error = min(error, _farthest(start, slope, length, offset, signed, shift))
    # Below 1, so a degree that is exactly 0 or 1 comes out exactly.
    assert error < 1
    return Line(m, falling, offset, shift, length, error, top)


def _farthest(start: Fraction, slope: Fraction, length: int, offset: int, signed: int, shift: int) -> Fraction:
    """The largest error over all u, each looked at; 1 where that takes more than 64 bits."""
    common = math.lcm(start.denominator, slope.denominator)
    if common >= 2**30 or length > 2**16:
        return Fraction(1)
    u = np.arange(length + 1, dtype=np.int64)
    exact = int(start * common) + int(slope * common) * u
    return Fraction(int(np.abs(((offset + signed * u) >> shift) * common - exact).max()), common)
