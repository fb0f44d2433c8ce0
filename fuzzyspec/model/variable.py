"""Variables: a range in the declared unit and the raw integers that carry it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.model.units import Unit

CType = Literal["uint8", "int8", "uint16", "int16"]

RAW_LIMITS: dict[CType, tuple[int, int]] = {
    "uint8": (0, 255),
    "int8": (-128, 127),
    "uint16": (0, 65535),
    "int16": (-32768, 32767),
}


@dataclass(frozen=True, slots=True)
class Raw:
    """``value = origin + step * raw``, in the variable's unit.

    ``lo <= raw <= hi`` are the legal raws: those whose value lies inside the range. ``step`` is
    negative where counts run backwards.
    """

    ctype: CType
    step: Fraction
    origin: Fraction
    lo: int
    hi: int

    def value(self, raw: int) -> Fraction:
        return self.origin + self.step * raw

    def position(self, value: Fraction) -> Fraction:
        """The (rational) raw that stands for a value; not rounded, not clamped."""
        return (value - self.origin) / self.step

    def nearest(self, value: Fraction) -> int:
        """The nearest legal raw; ties go towards +infinity in raw counts."""
        return max(self.lo, min(self.hi, math.floor(self.position(value) + Fraction(1, 2))))


@dataclass(frozen=True, slots=True)
class Variable:
    """A named quantity with range ``[lo, hi]`` in ``unit``."""

    name: str
    lo: Fraction
    hi: Fraction
    unit: Unit
    raw: Raw
    span: Span
