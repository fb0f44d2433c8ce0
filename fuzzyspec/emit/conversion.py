"""Integer macros between raws and thousandths of a unit: ``NAV_OBSTACLES_DISTANCE_FROM_MM(x)`` and ``_TO_MM(raw)``."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.emit.ctypes import LIMITS, spelled
from fuzzyspec.fixed.program import CType
from fuzzyspec.model.variable import Variable

_TAKES_MILLI = frozenset({"m", "s", "A", "K", "V", "W", "N", "Pa", "Hz", "rad"})


@dataclass(frozen=True, slots=True)
class Conversion:
    """A macro: what follows the signal's name, its parameter, its body and one line on its domain."""

    suffix: str
    parameter: str
    body: str
    note: str


@dataclass(frozen=True, slots=True)
class _Affine:
    """``floor((gain * x + shift) / divisor) - back`` over ``lo .. hi``; the dividend is never negative."""

    gain: int
    shift: int
    divisor: int
    back: int


def conversions(variable: Variable, ctype: CType) -> tuple[Conversion, ...]:
    """Both directions where thousandths, else whole units, stay within 32 bits; else none."""
    for name, factor, words in _scales(variable):
        low, high = sorted((variable.lo * factor, variable.hi * factor))
        lo, hi = math.ceil(low), math.floor(high)
        raw = variable.raw
        from_gain = 1 / (raw.step * factor)
        there = _affine(from_gain, -raw.origin / raw.step, lo, hi, LIMITS[ctype])
        back = _affine(raw.step * factor, raw.origin * factor, raw.lo, raw.hi, LIMITS["int32"])
        if there is None or back is None or lo > hi:
            continue
        return (
            Conversion(f"FROM_{name}", "x", _body(there, "x", spelled(ctype)), f"x in {words}, {lo} .. {hi}"),
            Conversion(f"TO_{name}", "raw", _body(back, "raw", "int32_t"), f"in {words}"),
        )
    return ()


def _scales(variable: Variable) -> list[tuple[str, Fraction, str]]:
    """Candidates: name, how many of it make the variable's unit, and what it is called."""
    symbol = variable.unit.symbol
    spoken = "".join(c if c.isalnum() else "_" for c in symbol.replace("/", "_per_").replace("%", "percent"))
    above = symbol.split("/")[0]
    if symbol == "kg":
        milli = ("G", Fraction(1000), "g")
    elif above in _TAKES_MILLI:
        milli = (f"M{spoken.upper()}", Fraction(1000), f"m{symbol}")
    else:
        milli = ("MILLI", Fraction(1000), f"thousandths of {symbol}" if symbol else "thousandths")
    whole = (spoken.upper() or "WHOLE", Fraction(1), symbol or "whole numbers")
    return [milli, whole]


def _affine(gain: Fraction, offset: Fraction, lo: int, hi: int, limits: tuple[int, int]) -> _Affine | None:
    """Nearest integer to ``gain * x + offset``, ties up, in one 32-bit division; None where that does not fit."""
    halved = offset + Fraction(1, 2)
    divisor = math.lcm(gain.denominator, halved.denominator)
    slope, start = int(gain * divisor), int(halved * divisor)
    ends = [(slope * x + start) // divisor for x in (lo, hi)]
    back = max(0, -min(ends))
    shift = start + back * divisor
    steps = [abs(shift), divisor, *(abs(slope * x) for x in (lo, hi, 1)), *(slope * x + shift for x in (lo, hi))]
    if max(steps) >= 2**31 or min(ends) < limits[0] or max(ends) > limits[1]:
        return None
    return _Affine(slope, shift, divisor, back)


def _body(form: _Affine, parameter: str, result: str) -> str:
    gain = str(form.gain) if form.gain > 0 else f"({form.gain})"
    text = f"((int32_t)({parameter}) * {gain})" if form.gain != 1 else f"(int32_t)({parameter})"
    if form.shift:
        text = f"({text} {'+' if form.shift > 0 else '-'} {abs(form.shift)})"
    if form.divisor != 1:
        text = f"({text} / {form.divisor})"
    if form.back:
        text = f"({text} - {form.back})"
    return f"(({result}){text})"
