"""Units: a coherent dimension, an exact scale and (for degC) an exact offset."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction


@dataclass(frozen=True, slots=True)
class Unit:
    """``coherent = scale * value + offset``.

    ``dims`` holds the non-zero exponents of the base dimensions (``m``, ``kg``, ``s``, ``A``, ``K`` and
    ``deg``, which is its own), sorted by name; rad and % have none.
    """

    symbol: str
    dims: tuple[tuple[str, int], ...] = ()
    scale: Fraction = Fraction(1)
    offset: Fraction = Fraction(0)

    def to_coherent(self, value: Fraction) -> Fraction:
        return self.scale * value + self.offset

    def from_coherent(self, value: Fraction) -> Fraction:
        return (value - self.offset) / self.scale


ONE = Unit("")
