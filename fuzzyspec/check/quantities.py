"""Numbers as they are shown to people."""

from __future__ import annotations

from fractions import Fraction

from fuzzyspec.model.units import Unit


def number(value: Fraction | float) -> str:
    """Six digits at most; a rational that needs more is rounded."""
    text = f"{float(value):.6g}"
    return "0" if text == "-0" else text


def quantity(value: Fraction | float, unit: Unit) -> str:
    """A number with its unit's symbol: ``2.5 deg``, ``40 %``; bare where the unit is 1."""
    return f"{number(value)} {unit.symbol}".rstrip()


def interval(lo: Fraction | float, hi: Fraction | float, unit: Unit) -> str:
    """``[0.1, 0.9] m/s``."""
    return f"[{number(lo)}, {number(hi)}] {unit.symbol}".rstrip()
