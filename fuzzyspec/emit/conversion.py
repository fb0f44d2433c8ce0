"""Integer macros between raws and thousandths of a unit: ``NAV_OBSTACLES_DISTANCE_FROM_MM(x)`` and ``_TO_MM(raw)``."""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.emit.ctypes import spelled
from fuzzyspec.fixed.program import CType
from fuzzyspec.model.variable import Raw, Variable

_TAKES_MILLI = frozenset({"m", "s", "A", "K", "V", "W", "N", "Pa", "Hz", "rad"})


@dataclass(frozen=True, slots=True)
class Conversion:
    """A pair of macros for one signal: what follows its name, and the bodies over ``x`` and ``raw``.

    ``lo .. hi`` are the whole numbers inside the signal's range, counted in ``words``; ``per_unit`` of these make
    the signal's unit.
    """

    name: str
    words: str
    per_unit: int
    lo: int
    hi: int
    from_body: str
    to_body: str


@dataclass(frozen=True, slots=True)
class _Affine:
    """``floor((gain * x + shift) / divisor) - back``; over its domain the dividend is never negative."""

    gain: int
    shift: int
    divisor: int
    back: int

    def __call__(self, x: int) -> int:
        return (self.gain * x + self.shift) // self.divisor - self.back


def conversion(variable: Variable, ctype: CType) -> Conversion | None:
    """Both directions for thousandths, else for whole units; None where neither stays within 32 bits."""
    raw = variable.raw
    for name, factor, words in _scales(variable):
        low, high = sorted((variable.lo * factor, variable.hi * factor))
        lo, hi = math.ceil(low), math.floor(high)
        if lo >= hi:
            continue
        there = _affine(1 / (raw.step * factor), -raw.origin / raw.step, lo, hi)
        back = _affine(raw.step * factor, raw.origin * factor, raw.lo, raw.hi)
        if there is not None and back is not None:
            from_body = f"(({spelled(ctype)}){_kept_legal(there, raw, lo, hi)})"
            return Conversion(name, words, factor, lo, hi, from_body, _body(back, "raw"))
    return None


def _scales(variable: Variable) -> list[tuple[str, int, str]]:
    """Candidates: name, how many of it make the variable's unit, and what it is called."""
    symbol = variable.unit.symbol
    spoken = "".join(c if c.isalnum() else "_" for c in symbol.replace("/", "_per_").replace("%", "percent"))
    if symbol == "kg":
        milli = ("G", 1000, "g")
    elif symbol.split("/")[0] in _TAKES_MILLI:
        milli = (f"M{spoken.upper()}", 1000, f"m{symbol}")
    else:
        milli = ("MILLI", 1000, f"1/1000 {symbol}".rstrip())
    return [milli, (spoken.upper() or "WHOLE", 1, symbol or "whole numbers")]


def _affine(gain: Fraction, offset: Fraction, lo: int, hi: int) -> _Affine | None:
    """Nearest integer to ``gain * x + offset``, ties up, in one 32-bit division; None where that does not fit."""
    halved = offset + Fraction(1, 2)
    divisor = math.lcm(gain.denominator, halved.denominator)
    slope, start = int(gain * divisor), int(halved * divisor)
    ends = [(slope * x + start) // divisor for x in (lo, hi)]
    back = max(0, -min(ends))
    shift = start + back * divisor
    steps = [abs(shift), divisor, *(abs(slope * x) for x in (lo, hi, 1)), *(slope * x + shift for x in (lo, hi))]
    return _Affine(slope, shift, divisor, back) if max(*steps, *map(abs, ends)) < 2**31 else None


def _kept_legal(form: _Affine, raw: Raw, lo: int, hi: int) -> str:
    """A range end that is not a raw may round to one outside: there the nearest legal raw is named."""
    domain = range(lo, hi + 1)
    rising = 1 if form.gain > 0 else -1
    first, last = (raw.lo, raw.hi) if rising > 0 else (raw.hi, raw.lo)
    start = lo + bisect_left(domain, rising * first, key=lambda x: rising * form(x))
    end = lo + bisect_left(domain, rising * last + 1, key=lambda x: rising * form(x)) - 1
    text = _body(form, "x")
    if end < hi:
        text = f"(((int32_t)(x) > {end}) ? {last} : {text})"
    if start > lo:
        text = f"(((int32_t)(x) < {start}) ? {first} : {text})"
    return text


def _body(form: _Affine, parameter: str) -> str:
    """The form in parentheses, without steps that do nothing."""
    text = f"(int32_t)({parameter})"
    if form.gain != 1:
        text = f"({text} * {form.gain if form.gain > 0 else f'({form.gain})'})"
    if form.shift:
        text = f"({text} {'+' if form.shift > 0 else '-'} {abs(form.shift)})"
    if form.divisor != 1:
        text = f"({text} / {form.divisor})"
    if form.back:
        text = f"({text} - {form.back})"
    return f"({text})" if form == _Affine(1, 0, 1, 0) else text
