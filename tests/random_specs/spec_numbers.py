"""Numbers, units, ranges and raws of random specs."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from fractions import Fraction

Interval = tuple[Fraction, Fraction]

UNITS: dict[str, tuple[str, ...]] = {
    "1": ("", "", "", "%", "rad"),
    "m": ("m", "m", "mm", "cm", "inch"),
    "s": ("s", "s", "ms"),
    "deg": ("deg", "deg", "tick"),
    "K": ("K", "degC"),
    "m/s": ("m/s", "mm/s"),
}
"""Units that a random variable of a dimension may have."""

SCALES: dict[str, Fraction] = {
    "%": Fraction(1, 100),
    "mm": Fraction(1, 1000),
    "cm": Fraction(1, 100),
    "inch": Fraction(254, 10000),
    "ms": Fraction(1, 1000),
    "mm/s": Fraction(1, 1000),
    "tick": Fraction(3, 10),
}
"""Coherent value of 1 of a unit, where it is not 1."""

DECLARED = "unit inch = 25.4 mm\nunit tick = 0.3 deg\nparam third = 2 * (1 - 1/2) / 3"

COUNTS = ("uint16 0..4095", "uint16 4095..0", "int16 -1000..1000", "uint8 0..200", "int8 100..-100", "uint8 0..3")

TYPES = {"uint8": (0, 255), "int8": (-128, 127), "uint16": (0, 65535), "int16": (-32768, 32767)}


def number(value: Fraction) -> str:
    """A decimal where it ends soon, else a quotient (constant expressions are exact)."""
    for digits in range(7):
        if (value * 10**digits).denominator == 1:
            whole = int(value * 10**digits)
            sign, whole = ("-" if whole < 0 else ""), abs(whole)
            text = str(whole).rjust(digits + 1, "0")
            return sign + (text if digits == 0 else f"{text[:-digits]}.{text[-digits:]}")
    return f"{value.numerator}/{value.denominator}"


@dataclass(frozen=True)
class Ranged:
    """A declared range with its unit and raw clause; ``lo`` and ``hi`` are in the unit."""

    lo: Fraction
    hi: Fraction
    unit: str
    dim: str
    raw: str

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        return f"[{number(self.lo)}, {number(self.hi)}]{unit}{self.raw}"

    @property
    def coherent(self) -> Interval:
        """The range in coherent units."""
        lo, hi = (coherent(v, self.unit) for v in (self.lo, self.hi))
        return lo, hi

    @property
    def span(self) -> Fraction:
        return self.hi - self.lo


def coherent(value: Fraction, unit: str) -> Fraction:
    """A value in coherent units."""
    return value + Fraction(27315, 100) if unit == "degC" else value * SCALES.get(unit, Fraction(1))


class Numbers:
    """Draws ranges and raws."""

    def __init__(self, dice: random.Random) -> None:
        self.dice = dice

    def decimal(self, lo: float, hi: float) -> Fraction:
        """A number with up to three decimals."""
        scale = 10 ** self.dice.choice((0, 1, 2, 3))
        return Fraction(self.dice.randint(math.ceil(lo * scale), math.floor(hi * scale)), scale)

    def ranged(self, dim: str | None = None, *, from_zero: bool = False) -> Ranged:
        """Any range that some raw can carry."""
        chosen = self.dice.choice(list(UNITS)) if dim is None else dim
        unit = self.dice.choice(UNITS[chosen])
        while True:
            lo, hi = self._ends(from_zero)
            raw = self._raw(lo, hi)
            if raw is not None:
                return Ranged(lo, hi, unit, chosen, raw)

    def _ends(self, from_zero: bool) -> Interval:
        kind = self.dice.random()
        if from_zero or kind < 0.3:
            return Fraction(0), max(self.decimal(0, 60), Fraction(1, 2))
        if kind < 0.36:
            return Fraction(1, 1000), Fraction(1, 500)
        if kind < 0.42:
            return Fraction(-30000), Fraction(30000)
        if kind < 0.47:
            return self.decimal(-9, -4), Fraction(0)
        lo = self.decimal(-200, 50)
        return lo, lo + max(self.decimal(1, 100) if kind < 0.9 else self.decimal(200, 3000), Fraction(1, 2))

    def _raw(self, lo: Fraction, hi: Fraction) -> str | None:
        kind = self.dice.random()
        if kind < 0.12:
            ends = (
                "uint16 0..4095",
                "uint16 4095..0",
                "int16 -1000..1000",
                "uint8 0..200",
                "int8 100..-100",
                "uint8 0..3",
            )
            return f" raw {self.dice.choice(ends)}"
        if kind < 0.24:
            return self._step(lo, hi)
        if kind < 0.6:
            ctype = self.dice.choice(list(TYPES))
            return f" raw {ctype}" if legal(lo, hi, ctype) else None
        return "" if legal(lo, hi, "uint16" if lo >= 0 else "int16") else None

    def _step(self, lo: Fraction, hi: Fraction) -> str | None:
        """A step that need not divide the range."""
        step = self.dice.choice((Fraction(1, 100), Fraction(1, 7), Fraction(3, 10), (hi - lo) / 997, (hi - lo) / 30000))
        low, high = math.ceil(lo / step), math.floor(hi / step)
        fitting = [t for t, (a, b) in TYPES.items() if a <= low and high <= b and (a < 0 or lo >= 0)]
        if high - low < 2 or not fitting:
            return None
        return f" raw {self.dice.choice(fitting)} step {number(step)}"


def legal(lo: Fraction, hi: Fraction, ctype: str) -> bool:
    """Whether the finest power of two that fits has three legal raws or more."""
    low, high = TYPES[ctype]
    scale = Fraction(2) ** 30
    while not (low <= lo * scale and hi * scale <= high):
        scale /= 2
        if scale < Fraction(1, 2**30):
            return False
    return math.floor(hi * scale) - math.ceil(lo * scale) >= 2
