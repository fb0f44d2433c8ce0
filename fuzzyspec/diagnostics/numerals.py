"""Exact numbers as text: integer arithmetic only, so every machine prints the same digits."""

from __future__ import annotations

from fractions import Fraction

_PLACES = 6


def exact(value: Fraction) -> str:
    """A terminating decimal of at most six places, else ``p/q``."""
    scaled = value * 10**_PLACES
    if scaled.denominator != 1:
        return f"{value.numerator}/{value.denominator}"
    return _decimal(scaled.numerator, _PLACES)


def upper(value: Fraction, significant: int = 2) -> str:
    """A decimal of ``significant`` digits that is not below ``value`` (which is not negative)."""
    if value < 0:
        raise ValueError("an upper bound of a magnitude is not negative")
    if value == 0:
        return "0"
    places = significant - _magnitude(value)
    scaled = value * Fraction(10) ** places
    digits = -(-scaled.numerator // scaled.denominator)
    return _decimal(digits, places) if places > 0 else str(digits * 10**-places)


def nearest(value: Fraction, places: int) -> str:
    """A decimal of at most ``places`` places, rounded to nearest, ties up."""
    scaled = value * 10**places + Fraction(1, 2)
    return _decimal(scaled.numerator // scaled.denominator, places)


def _magnitude(value: Fraction) -> int:
    """The smallest m with ``value < 10**m``."""
    m = len(str(value.numerator)) - len(str(value.denominator))
    while value >= Fraction(10) ** m:
        m += 1
    while value < Fraction(10) ** (m - 1):
        m -= 1
    return m


def _decimal(digits: int, places: int) -> str:
    """``digits / 10**places`` without trailing zeros."""
    sign = "-" if digits < 0 else ""
    whole, part = divmod(abs(digits), 10**places)
    tail = str(part).rjust(places, "0").rstrip("0")
    return f"{sign}{whole}.{tail}" if tail else f"{sign}{whole}"
