"""Numbers as they are shown to people."""

from __future__ import annotations

from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction

from fuzzyspec.model.units import Unit


def number(value: Fraction | float) -> str:
    """Six digits at most; a rational that needs more is rounded."""
    try:
        text = f"{float(value):.6g}"
    except OverflowError:
        exact = Fraction(value)
        text = f"{Decimal(exact.numerator) / Decimal(exact.denominator):.6g}"
    return "0" if text == "-0" else text


def quantity(value: Fraction | float, unit: Unit) -> str:
    """A number with its unit's symbol: ``2.5 deg``, ``40 %``; bare where the unit is 1."""
    return f"{number(value)} {unit.symbol}".rstrip()


def interval(lo: Fraction | float, hi: Fraction | float, unit: Unit) -> str:
    """``[0.1, 0.9] m/s``."""
    return f"[{number(lo)}, {number(hi)}] {unit.symbol}".rstrip()


def at_most(value: Fraction) -> str:
    """Three digits, rounded up: for a width that nothing exceeds."""
    return _digits(value, ROUND_CEILING)


def at_least(value: Fraction) -> str:
    """As a small fraction, else in three digits, rounded down: for a floor that nothing falls below."""
    return str(value) if value.denominator <= 1024 else _digits(value, ROUND_FLOOR)


def _digits(value: Fraction, rounding: str) -> str:
    context = Context(prec=3, rounding=rounding)
    return f"{context.divide(Decimal(value.numerator), Decimal(value.denominator)):f}"
