"""Sets of machine words: arithmetic progressions that may wrap around.

``Value(lo, hi, step)`` stands for ``lo, lo + step, .. hi`` modulo ``2**bits``, with ``0 <= lo < 2**bits`` and
``hi - lo < 2**bits``; ``step`` is 0 for a single word. Every operation returns a set that holds all results.

A value may also be known relative to another that is not known itself: ``base`` is a name and what was added to it,
modulo ``2**bits``. Values with the same name differ by a number that is known.
"""

from __future__ import annotations

from math import gcd
from typing import Literal, NamedTuple

Operator = Literal["+", "-", "*", "&", "|", "^", "<<", ">>", "asr", "/", "%", "reversed", "?"]


class Value(NamedTuple):
    """Words ``lo, lo + step, .. hi``."""

    lo: int
    hi: int
    step: int
    base: tuple[int, int] | None = None


def anything(bits: int) -> Value:
    """Every word."""
    return Value(0, (1 << bits) - 1, 1)


def constant(word: int, bits: int) -> Value:
    """One word."""
    word &= (1 << bits) - 1
    return Value(word, word, 0)


def between(lo: int, hi: int, step: int, bits: int) -> Value:
    """The words ``lo .. hi``, given as any integers."""
    if hi == lo:
        return constant(lo, bits)
    if hi - lo >= 1 << bits:
        return anything(bits)
    start = lo & ((1 << bits) - 1)
    return Value(start, hi - lo + start, step or 1)


def unsigned(value: Value, bits: int) -> tuple[int, int]:
    """Least and largest, read without sign."""
    top = (1 << bits) - 1
    return (value.lo, value.hi) if value.hi <= top else (0, top)


def signed(value: Value, bits: int) -> tuple[int, int]:
    """Least and largest, read in two's complement."""
    half, whole = 1 << (bits - 1), 1 << bits
    if value.hi < half:
        return value.lo, value.hi
    if value.lo >= half and value.hi < whole + half:
        return value.lo - whole, value.hi - whole
    return -half, half - 1


def operate(operator: Operator, a: Value, b: Value, bits: int) -> Value:
    """What ``a operator b`` may be."""
    match operator:
        case "+":
            if a.step == 0:
                a, b = b, a
            return _moved(between(a.lo + b.lo, a.hi + b.hi, gcd(a.step, b.step), bits), a, b, b.lo, bits)
        case "-":
            if a.base is not None and b.base is not None and a.base[0] == b.base[0]:
                return constant(a.base[1] - b.base[1], bits)
            return _moved(between(a.lo - b.hi, a.hi - b.lo, gcd(a.step, b.step), bits), a, b, -b.lo, bits)
        case "*":
            return _product(a, b, bits)
        case "<<" | ">>" | "asr":
            return _shifted(operator, a, b, bits)
        case "&":
            return _common(a, b, bits)
        case "|":
            if a.step == b.step == 0:
                return constant(a.lo | b.lo, bits)
            (alo, ahi), (blo, bhi) = unsigned(a, bits), unsigned(b, bits)
            return between(max(alo, blo), (1 << (ahi | bhi).bit_length()) - 1, 1, bits)
        case "^":
            if a.step == b.step == 0:
                return constant(a.lo ^ b.lo, bits)
            top = (1 << bits) - 1
            if b.step == 0 and b.lo == top:
                return between(-1 - a.hi, -1 - a.lo, a.step, bits)
            return between(0, (1 << (unsigned(a, bits)[1] | unsigned(b, bits)[1]).bit_length()) - 1, 1, bits)
        case "/":
            (alo, ahi), (blo, bhi) = unsigned(a, bits), unsigned(b, bits)
            return between(alo // bhi, ahi // blo, 1, bits) if blo > 0 else anything(bits)
        case "%":
            (_, ahi), (blo, bhi) = unsigned(a, bits), unsigned(b, bits)
            return between(0, min(ahi, bhi - 1), 1, bits) if blo > 0 else anything(bits)
        case "reversed":
            if a.step:
                return anything(bits)
            return constant(int.from_bytes(a.lo.to_bytes(bits // 8, "little"), "big"), bits)
        case "?":
            return anything(bits)


def _moved(value: Value, a: Value, b: Value, by: int, bits: int) -> Value:
    """``value`` is ``a`` moved by ``b``: where ``b`` is one word, it stays relative to what ``a`` is relative to."""
    if b.step or value.step == 0 or a.base is None:
        return value
    return value._replace(base=(a.base[0], (a.base[1] + by) & ((1 << bits) - 1)))


def _centred(value: Value, bits: int) -> tuple[int, int]:
    """The same residues, as a range that does not run past the top."""
    whole = 1 << bits
    return (value.lo - whole, value.hi - whole) if value.hi >= whole else (value.lo, value.hi)


def _product(a: Value, b: Value, bits: int) -> Value:
    (alo, ahi), (blo, bhi) = _centred(a, bits), _centred(b, bits)
    corners = [x * y for x in (alo, ahi) for y in (blo, bhi)]
    if b.step == 0:
        step = a.step * abs(blo)
    elif a.step == 0:
        step = b.step * abs(alo)
    else:
        step = 1
    return between(min(corners), max(corners), step, bits)


def _shifted(operator: Operator, a: Value, b: Value, bits: int) -> Value:
    if b.step != 0:
        least, most = unsigned(b, bits)
        if operator == ">>" and most < bits:
            lo, hi = unsigned(a, bits)
            return between(lo >> most, hi >> least, 1, bits)
        return anything(bits)
    count = b.lo & 0xFF
    if operator == "<<":
        return _product(a, constant(1 << count, bits), bits) if count < bits else constant(0, bits)
    lo, hi = unsigned(a, bits) if operator == ">>" else signed(a, bits)
    even = a.hi < 1 << bits and a.step % (1 << count) == 0
    return between(lo >> count, hi >> count, a.step >> count if even else 1, bits)


def _common(a: Value, b: Value, bits: int) -> Value:
    if a.step == 0 and b.step != 0:
        a, b = b, a
    if b.step != 0:
        return between(0, min(unsigned(a, bits)[1], unsigned(b, bits)[1]), 1, bits)
    mask = b.lo
    if a.step == 0:
        return constant(a.lo & mask, bits)
    if mask & (mask + 1) == 0 and mask:
        if a.hi <= mask:
            return a
        if a.lo & ~mask == a.hi & ~mask:
            return between(a.lo & mask, a.hi & mask, a.step, bits)
        step = gcd(a.step, mask + 1)
        start = a.lo % step
        return between(start, mask - (mask - start) % step, step, bits)
    if mask == 0:
        return constant(0, bits)
    low = mask & -mask
    most = min(mask, unsigned(a, bits)[1])
    return between(0, most - most % low, low, bits)


def join(a: Value, b: Value, bits: int) -> Value:
    """The least progression found that holds both, relative to nothing."""
    if a[:3] == b[:3]:
        return a._replace(base=None)
    whole = 1 << bits
    best: Value | None = None
    for x, y in ((a, b), (b, a)):
        # From x's low end upwards, with y's first word at or above it.
        start = y.lo if y.lo >= x.lo else y.lo + whole
        hi = max(x.hi, start + y.hi - y.lo)
        if hi - x.lo < whole and (best is None or hi - x.lo < best.hi - best.lo):
            best = Value(x.lo, hi, gcd(gcd(x.step, y.step), start - x.lo) or 1)
    return anything(bits) if best is None else best


def within(value: Value, lo: int, hi: int, bits: int) -> Value | None:
    """The part of a set that lies in ``lo .. hi``, read without sign; None where there is none."""
    whole = 1 << bits
    step = value.step or 1
    found: Value | None = None
    for turn in (0, whole):
        least, most = max(value.lo, lo + turn), min(value.hi, hi + turn)
        least += (value.lo - least) % step
        most -= (most - value.lo) % step
        if least <= most:
            part = between(least, most, step, bits)
            found = part if found is None else join(found, part, bits)
    return None if found is None else _named(found, value)


def _named(part: Value, value: Value) -> Value:
    """A part of a value is relative to the same."""
    return part._replace(base=value.base) if part.step else part


def within_signed(value: Value, lo: int, hi: int, bits: int) -> Value | None:
    """The part of a set that lies in ``lo .. hi``, read in two's complement."""
    half = 1 << (bits - 1)
    moved = within(between(value.lo + half, value.hi + half, value.step, bits), lo + half, hi + half, bits)
    return None if moved is None else _named(between(moved.lo - half, moved.hi - half, moved.step, bits), value)


def without(value: Value, word: int, bits: int) -> Value | None:
    """The set without one word, where that is one of its ends."""
    whole = 1 << bits
    if value.step == 0:
        return None if value.lo == word else value
    if value.lo == word:
        return _named(between(value.lo + value.step, value.hi, value.step, bits), value)
    if value.hi in (word, word + whole):
        return _named(between(value.lo, value.hi - value.step, value.step, bits), value)
    return value


def may_equal(a: Value, b: Value, bits: int) -> bool:
    """Whether some word is in both."""
    whole = 1 << bits
    difference = operate("-", a, b, bits)
    if difference.step == 0:
        return difference.lo == 0
    return any(
        difference.lo <= at <= difference.hi and (at - difference.lo) % difference.step == 0 for at in (0, whole)
    )


def extent(value: Value) -> int:
    """How far the set reaches."""
    return value.hi - value.lo
