"""Shapes of shifts and products that a machine of 8 bits computes cheaply. Every integer stays what it is.

A shift of four bytes goes bit by bit there, unless it is by whole bytes; a product of two factors of 16 bits is a fifth
of one of 32. So ``(m u + c) >> k`` is scaled by powers of two until it is shifted by bytes, a multiplier of 17 bits is
parted in ``u + (..)``, and other shifts go by way of bytes. Among the shapes that are equal the cheapest is taken.
"""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyspec.fixed.build import UINT32_MAX
from fuzzyspec.fixed.program import Binary, Compare, Const, Expr, Local

SHORT = 65535
"""The largest factor of a short multiplication."""

# Cycles of avr-gcc 5.4 -O2 on an ATmega328P, counted by simavr with the call's taken off.
_MULTIPLY_BYTES, _MULTIPLY_WORDS, _MULTIPLY_SHORT, _MULTIPLY_MIXED, _MULTIPLY_LONG = 4, 8, 26, 50, 95
_SHIFT_WORD = (0, 2, 4, 6, 6, 8, 9, 5, 2, 3, 4, 5, 4, 5, 6, 5)
_SHIFT_LONG = {0: 0, 1: 4, 2: 8, 8: 4, 16: 1, 24: 4}


def cheapest(expr: Expr) -> Expr:
    """The expression, or where it is a shift to the right the cheapest one that is equal to it; a factor that is
    shifted to the left is shifted after the multiplication."""
    match expr:
        case Binary("*", a, Binary("<<", x, Const(count))) if a.hi <= SHORT and x.hi <= SHORT:
            product = Binary("*", a, x, a.lo * x.lo, a.hi * x.hi)
            return min(expr, Binary("<<", product, Const(count), expr.lo, expr.hi), key=cycles)
        case Binary("*", Binary("<<") as shifted, a) if not isinstance(a, Binary):
            return cheapest(Binary("*", a, shifted, expr.lo, expr.hi))
        case Binary(">>", x, Const(count)) if count and x.hi > SHORT:
            return min(_equal(x, count, expr), key=cycles)
        case _:
            return expr


def plainest(expr: Expr) -> Expr:
    """The expression, or where it is a shift to the right, or its sum with a constant, an equal one with fewer
    operators, on any machine."""
    match expr:
        case Binary(">>", x, Const(count)) if count:
            shorter = [Binary(">>", y, Const(by), expr.lo, expr.hi) if by else y for y, by in _scaled(x, count)]
            return min(shorter, key=operators)
        case Binary("-", Const(top), Binary(">>", Binary() as x, Const(count))) if expr.lo >= 0 and x.lo >= 0:
            # top - floor(y / 2**k) = floor((2**k top + 2**k - 1 - y) / 2**k), and y holds what rounds.
            y, added = _without_constant(x)
            whole = (top << count) + (1 << count) - 1 - added
            if y.lo >= 0 and whole <= UINT32_MAX:
                return Binary(">>", Binary("-", Const(whole), y, 0, whole), Const(count), expr.lo, expr.hi)
            return expr
        case Binary("+", Binary(">>", Binary() as x, Const(count)), Const(more)) if more > 0 and x.lo >= 0:
            y, added = _without_constant(x)
            whole = (more << count) + added
            if y.lo >= 0 and y.hi + whole <= UINT32_MAX:
                total = Binary("+", y, Const(whole), y.lo + whole, y.hi + whole)
                return Binary(">>", total, Const(count), expr.lo, expr.hi)
            return expr
        case _:
            return expr


IMMEDIATE = 255
"""The largest constant that every machine of 32 bits compares with as it is; Thumb loads others, or makes them."""


def without_constant_of_two(test: Compare) -> Compare:
    """A comparison of an unsigned local with a larger power of two asks for the bits from there on: one shift tells."""
    match test:
        case Compare("<" | ">=" as op, Local(_, "uint32") as value, Const(bound)):
            pass
        case Compare("<=" | ">" as op, Local(_, "uint32") as value, Const(last)):
            op, bound = ("<" if op == "<=" else ">="), last + 1
        case _:
            return test
    if not IMMEDIATE < bound <= UINT32_MAX or bound & (bound - 1) or value.lo < 0:
        return test
    count = bound.bit_length() - 1
    above = Binary(">>", value, Const(count), value.lo >> count, value.hi >> count)
    return Compare("==" if op == "<" else "!=", above, Const(0))


def _without_constant(x: Binary) -> tuple[Expr, int]:
    """What a sum adds a constant to, and the constant; else the expression and 0."""
    match x:
        case Binary("+", y, Const(added)) if added >= 0:
            return y, added
        case _:
            return x, 0


def operators(expr: Expr) -> int:
    """How many operators of arithmetic an expression has."""
    return 1 + operators(expr.left) + operators(expr.right) if isinstance(expr, Binary) else 0


def cycles(expr: Expr) -> int:
    """What the operators of an expression cost on AVR, about."""
    match expr:
        case Binary(op, left, right, _, hi):
            return cycles(left) + cycles(right) + _operator(op, left, right, max(hi, left.hi, right.hi))
        case _:
            return 0


def _operator(op: str, left: Expr, right: Expr, largest: int) -> int:
    size = 1 if largest <= 255 else 2 if largest <= SHORT else 4
    match op, right:
        case "*", Const(by) if by & (by - 1) == 0:
            return _shift(by.bit_length() - 1, size, up=True)
        case "*", _:
            if size < 4:
                return _MULTIPLY_WORDS if size == 2 else _MULTIPLY_BYTES
            short = (left.hi <= SHORT) + (right.hi <= SHORT)
            return (_MULTIPLY_LONG, _MULTIPLY_MIXED, _MULTIPLY_SHORT)[short]
        case (("<<" | ">>"), Const(count)):
            return _shift(count, size, up=op == "<<")
        case _:
            return size


def _shift(count: int, size: int, up: bool) -> int:
    if size < 4:
        return _SHIFT_WORD[count] if count < len(_SHIFT_WORD) else size
    if up and 2 < count < 8:
        return 4 * count + 4
    return _SHIFT_LONG.get(count, 7 * count + 14)


def _equal(x: Expr, count: int, whole: Binary) -> Iterator[Expr]:
    """Shapes of ``x >> count``, itself first."""
    for scaled, by in _scaled(x, count):
        yield from _shifted(scaled, by, whole)
        if by == 16:
            yield from _parted(scaled, whole)


def _shifted(x: Expr, count: int, whole: Binary) -> Iterator[Expr]:
    """``x >> count`` directly, or by way of whole bytes."""
    lo, hi = whole.lo, whole.hi
    yield Binary(">>", x, Const(count), lo, hi) if count else x
    for whole_bytes in (8, 16):
        up, down = whole_bytes - count, count - whole_bytes
        if up > 0 and x.hi << up <= UINT32_MAX:
            raised = Binary("<<", x, Const(up), x.lo << up, x.hi << up)
            yield Binary(">>", raised, Const(whole_bytes), lo, hi)
        if down > 0 and x.hi >> whole_bytes <= SHORT:
            short = Binary(">>", x, Const(whole_bytes), x.lo >> whole_bytes, x.hi >> whole_bytes)
            yield Binary(">>", short, Const(down), lo, hi)


def _scaled(x: Expr, count: int) -> Iterator[tuple[Expr, int]]:
    """``x`` times powers of two, with the count that takes them back: the same integer after the shift."""
    yield x, count
    for up in range(-count, 17 - count):
        if up:
            found = _times(x, up)
            if found is not None:
                yield found, count + up


def _times(x: Expr, up: int) -> Expr | None:
    """``floor(x 2**up)`` with the power in the factors: None where it does not go into them, or 32 bits do not do."""
    if _raised(x.hi, up) > UINT32_MAX:
        return None
    lo, hi = _raised(x.lo, up), _raised(x.hi, up)
    match x:
        case Binary("+", Binary("*") as product, Const(c)):
            factors = _times(product, up)
            if factors is None:
                return None
            c = _raised(c, up)
            return Binary("+", factors, Const(c), lo, hi) if c else factors
        case Binary("-", Const(c), Binary("*") as product):
            factors = _times(product, up)
            return None if factors is None else Binary("-", Const(_raised(c, up)), factors, lo, hi)
        case Binary("*", u, Const(m)) if up >= 0 or m % (1 << -up) == 0:
            by = _raised(m, up)
            return u if by == 1 else Binary("*", u, Const(by), lo, hi)
        case Binary("*", left, right) if up > 0 and not isinstance(right, Const):
            if left.hi << up <= SHORT:
                return Binary("*", _doubled(left, up), right, lo, hi)
            if right.hi << up <= SHORT:
                return Binary("*", left, _doubled(right, up), lo, hi)
            return None
        case _:
            return None


def _raised(value: int, up: int) -> int:
    return value << up if up >= 0 else value >> -up


def _doubled(factor: Expr, up: int) -> Expr:
    return Binary("<<", factor, Const(up), factor.lo << up, factor.hi << up)


def _parted(x: Expr, whole: Binary) -> Iterator[Expr]:
    """``(m u + c) >> 16`` with a long m as ``h u + ((l u + c) >> 16)``; u is named twice: nearly an atom."""
    match x:
        case Binary("+", Binary("*", u, Const(m)), Const(c)) if m > SHORT and _is_short(u):
            high, low = m >> 16, m & SHORT
            rest: Expr = Const(c)
            if low:
                product = Binary("*", u, Const(low), u.lo * low, u.hi * low)
                rest = Binary("+", product, Const(c), product.lo + c, product.hi + c)
            yield Binary("+", _multiple(u, high), _halved(rest), whole.lo, whole.hi)
        case Binary("-", Const(c), Binary("*", u, Const(m))) if m > SHORT and _is_short(u):
            high, low = m >> 16, m & SHORT
            rest = Const(c)
            if low:
                product = Binary("*", u, Const(low), u.lo * low, u.hi * low)
                rest = Binary("-", Const(c), product, max(c - product.hi, 0), c - product.lo)
            yield Binary("-", _halved(rest), _multiple(u, high), whole.lo, whole.hi)
        case _:
            pass


def _is_short(u: Expr) -> bool:
    match u:
        case Local() | Binary("+" | "-", Local(), Const()):
            return u.lo >= 0 and u.hi <= SHORT
        case _:
            return False


def _multiple(u: Expr, by: int) -> Expr:
    return u if by == 1 else Binary("*", u, Const(by), u.lo * by, u.hi * by)


def _halved(x: Expr) -> Expr:
    if isinstance(x, Const):
        return Const(x.value >> 16)
    return Binary(">>", x, Const(16), x.lo >> 16, x.hi >> 16)
