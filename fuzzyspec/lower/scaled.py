"""Crisp arithmetic in integers: ``value = offset + step * i`` with exact rational step and offset.

Sums, differences and products by constants cost no rounding: the common step of two values is the greatest common
divisor
of their steps, as long as the integers stay inside :data:`EXACT_BITS`. Only where they cannot is a value rounded to a
coarser step, and its ``error`` says so. Values are in coherent units.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Const, Define, Expr, Local, Select, Stmt
from fuzzyspec.lower.scope import Scope

HALF = Fraction(1, 2)
EXACT_BITS = 29
"""Integers may span this many bits before a value is rounded: two can still be added, and a difference keeps its
sign."""


@dataclass(frozen=True)
class Scaled:
    """A computed value.

    ``error`` bounds |offset + step * i - exact| (the exact meaning along the same decisions); ``cause`` says where most
    of it comes from, empty where it is rounding alone.
    """

    expr: Expr
    step: Fraction
    offset: Fraction
    error: Fraction
    cause: str = ""

    @property
    def lo(self) -> Fraction:
        return self.offset + min(self.step * self.expr.lo, self.step * self.expr.hi)

    @property
    def hi(self) -> Fraction:
        return self.offset + max(self.step * self.expr.lo, self.step * self.expr.hi)


def constant(value: Fraction) -> Scaled:
    """A value known when compiling."""
    return Scaled(Const(0), Fraction(1), value, Fraction(0))


def cause_of(*values: Scaled) -> str:
    """The cause behind the largest error."""
    return max(values, key=lambda v: v.error).cause


def gcd(*steps: Fraction) -> Fraction:
    """Greatest common divisor of rationals; 0 divides nothing and is left out."""
    used = [abs(s) for s in steps if s]
    if not used:
        return Fraction(1)
    denominator = math.lcm(*(s.denominator for s in used))
    return Fraction(math.gcd(*(int(s * denominator) for s in used)), denominator)


class Arithmetic:
    """Builds statements into ``body``; every intermediate is bound to a named local."""

    def __init__(self, scope: Scope, body: list[Stmt]) -> None:
        self.scope = scope
        self.body = body

    def bind(self, value: Expr, name: str) -> Expr:
        """An atom with the value."""
        if isinstance(value, Const | Local):
            return value
        bound = build.local(self.scope.name(name), value, ctype="int32" if value.lo < 0 else "uint32")
        self.body.append(Define(bound, value, True))
        return bound

    # --- formats --------------------------------------------------------------------------------

    def common(self, values: list[Scaled], name: str, zero: bool = True) -> list[Scaled]:
        """The same values over one step and one offset (0 with ``zero``), rounded only where the bits cannot hold
        them."""
        offset = Fraction(0) if zero else values[0].offset
        moving = [v for v in values if v.expr.lo != v.expr.hi]
        shifts = [v.offset - offset + (v.step * v.expr.lo if v not in moving else 0) for v in values]
        step = gcd(*(v.step for v in moving), *shifts)
        extent = max(abs(end - offset) for v in values for end in (v.lo, v.hi))
        if extent / step < 2**EXACT_BITS:
            return [self.restep(v, step, offset) for v in values]
        coarse = step
        while extent / coarse >= 2**EXACT_BITS:
            coarse *= 2
        # A step that one of the operands already has spares that one its rounding.
        own = [v.step for v in moving if coarse <= v.step and extent / v.step >= 2 ** (EXACT_BITS - 8)]
        target = min(own) if own else coarse
        return [self.restep(self.rounded(v, target, offset, name), target, offset) for v in values]

    def restep(self, value: Scaled, step: Fraction, offset: Fraction) -> Scaled:
        """The same value over a step that divides its own and its offset's distance exactly."""
        if value.expr.lo == value.expr.hi:
            exact = (value.lo - offset) / step
            assert exact.denominator == 1
            return Scaled(Const(int(exact)), step, offset, value.error, value.cause)
        factor, shift = value.step / step, (value.offset - offset) / step
        assert factor.denominator == 1 and shift.denominator == 1
        expr = build.add(build.mul(value.expr, Const(int(factor))), Const(int(shift)))
        return Scaled(expr, step, offset, value.error, value.cause)

    def rounded(self, value: Scaled, step: Fraction, offset: Fraction, name: str) -> Scaled:
        """The nearest multiple of ``step`` from ``offset``."""
        if value.expr.lo == value.expr.hi:
            nearest = math.floor((value.lo - offset) / step + HALF)
            error = abs(offset + step * nearest - value.lo)
            return Scaled(Const(nearest), step, offset, value.error + error, value.cause)
        if (value.step / step).denominator == 1 and ((value.offset - offset) / step).denominator == 1:
            return value
        # From the value's own low end, so that what is scaled is unsigned.
        up = (
            build.sub(value.expr, Const(value.expr.lo))
            if value.step > 0
            else build.sub(Const(value.expr.hi), value.expr)
        )
        low = min(value.lo, value.hi)
        base = math.floor((low - offset) / step)
        rest = (low - offset) / step - base
        scaled, error = self.scale(up, abs(value.step) / step, rest, name)
        expr = build.add(scaled, Const(base))
        return Scaled(self.bind(expr, name), step, offset, value.error + error * step, value.cause)

    def scale(self, u: Expr, ratio: Fraction, rest: Fraction, name: str) -> tuple[Expr, Fraction]:
        """``round(u * ratio + rest)`` of an unsigned ``u``, with a bound on its error in units of the result.

        Multiplier and divisor are the ratio's own where the product fits 32 bits, else its best rational approximation;
        ``u`` is shortened first where it has more bits than the result needs.
        """
        whole = math.floor(rest)
        if whole:
            scaled, error = self.scale(u, ratio, rest - whole, name)
            return build.add(self.bind(scaled, name), Const(whole)), error
        error = Fraction(0)
        if ratio * u.hi < Fraction(1, 1024):
            # The value hardly moves the result: its middle stands for it.
            middle = rest + ratio * u.hi / 2
            nearest = math.floor(middle + HALF)
            return Const(nearest), abs(nearest - middle) + ratio * u.hi / 2
        limit = Fraction(build.UINT32_MAX)
        if u.hi * ratio.numerator + ratio.denominator * (abs(rest) + 1) > limit:
            spare, bounded, lost = _shortest(u.hi, ratio, abs(rest) + 1)
            if spare:
                u = self.bind(build.rounded_shift(u, spare), f"{name}_short")
            error += lost
            ratio = bounded
        a, b = ratio.numerator, ratio.denominator
        add = math.floor((rest + HALF) * b)
        value = build.mul(u, Const(a))
        if add < 0:
            value = build.above(self.bind(value, name), Const(-add))
        else:
            value = build.add(value, Const(add))
        exact = b == 1 and rest.denominator == 1
        if not exact:
            error += HALF + abs(Fraction(add, b) - rest - HALF)
        return build.floor_div(value, Const(b)), error

    # --- operations -----------------------------------------------------------------------------

    def negated(self, a: Scaled) -> Scaled:
        return Scaled(a.expr, -a.step, -a.offset, a.error, a.cause)

    def by_constant(self, a: Scaled, factor: Fraction) -> Scaled:
        if factor == 0:
            return constant(Fraction(0))
        return Scaled(a.expr, a.step * factor, a.offset * factor, a.error * abs(factor), a.cause)

    def plus(self, a: Scaled, b: Scaled, name: str) -> Scaled:
        error, cause = a.error + b.error, cause_of(a, b)
        if a.expr.lo == a.expr.hi:
            return Scaled(b.expr, b.step, b.offset + a.lo, error, cause)
        if b.expr.lo == b.expr.hi:
            return Scaled(a.expr, a.step, a.offset + b.lo, error, cause)
        free = [Scaled(a.expr, a.step, Fraction(0), Fraction(0)), Scaled(b.expr, b.step, Fraction(0), Fraction(0))]
        x, y = self.common(free, name)
        total = self.bind(build.add(x.expr, y.expr), name)
        return Scaled(total, x.step, a.offset + b.offset, error + x.error + y.error, cause)

    def times(self, a: Scaled, b: Scaled, name: str) -> Scaled:
        if a.expr.lo == a.expr.hi:
            return self._widen(self.by_constant(b, a.lo), a.error, b)
        if b.expr.lo == b.expr.hi:
            return self._widen(self.by_constant(a, b.lo), b.error, a)
        x = self._factor(a, name)
        y = x if a == b else self._factor(b, name)
        product = self.bind(build.square(x.expr) if x is y else build.mul(x.expr, y.expr), name)
        largest_a, largest_b = (max(abs(v.lo), abs(v.hi)) for v in (x, y))
        error = x.error * largest_b + y.error * largest_a + x.error * y.error
        return Scaled(product, x.step * y.step, Fraction(0), error, cause_of(a, b))

    def _widen(self, scaled: Scaled, extra: Fraction, other: Scaled) -> Scaled:
        if not extra:
            return scaled
        return replace(scaled, error=scaled.error + extra * (max(abs(other.lo), abs(other.hi)) + other.error))

    def _factor(self, a: Scaled, name: str) -> Scaled:
        """``a`` without offset in at most 15 bits and sign, rounded to nearest."""
        (whole,) = self.common([a], name)
        bits = max(abs(whole.expr.lo), abs(whole.expr.hi)).bit_length()
        if bits <= 15:
            return Scaled(self.bind(whole.expr, name), whole.step, whole.offset, whole.error, whole.cause)
        return self.rounded(whole, whole.step * 2 ** (bits - 15), Fraction(0), f"{name}_factor")

    def smallest(self, values: list[Scaled], name: str) -> Scaled:
        return self._extreme(values, name, least=True)

    def largest(self, values: list[Scaled], name: str) -> Scaled:
        return self._extreme(values, name, least=False)

    def _extreme(self, values: list[Scaled], name: str, least: bool) -> Scaled:
        same = self.common(values, name)
        turn = -1 if least else 1
        surely = max(min(turn * v.lo, turn * v.hi) - v.error for v in same)
        # Only what can be the extreme, in either meaning, moves it.
        may = [v for v in same if max(turn * v.lo, turn * v.hi) + v.error >= surely]
        result = self.bind(same[0].expr, name)
        for v in same[1:]:
            other = self.bind(v.expr, name)
            pick = build.least(result, other) if least else build.greatest(result, other)
            result = self.bind(pick, name)
        return Scaled(result, same[0].step, same[0].offset, max(v.error for v in may), cause_of(*may))

    def absolute(self, a: Scaled, name: str) -> Scaled:
        (whole,) = self.common([a], name)
        value = self.bind(whole.expr, name)
        if value.lo >= 0:
            return whole
        if value.hi <= 0:
            return Scaled(build.sub(Const(0), value), whole.step, whole.offset, whole.error, whole.cause)
        test = build.compare("<", value, Const(0))
        flipped = Select(test, build.sub(Const(0), value), value, 0, max(-value.lo, value.hi))
        return Scaled(self.bind(flipped, name), whole.step, whole.offset, whole.error, whole.cause)


def _shortest(top: int, ratio: Fraction, rest: Fraction) -> tuple[int, Fraction, Fraction]:
    """How to multiply ``0 .. top`` by a ratio in 32 bits with the least error.

    Bits to round away first, the ratio to multiply by then, and what both cost. More bits for the one leave fewer
    for the
    other. Raises RangeError where no way goes.
    """
    found: list[tuple[Fraction, int, Fraction]] = []
    for spare in range(max(1, top.bit_length() - 7)):
        short = (top + (1 << spare >> 1)) >> spare
        wanted = ratio * 2**spare
        bounded = _nearby(wanted, short, rest)
        if bounded is not None:
            rounding = wanted * HALF if spare else Fraction(0)
            found.append((rounding + abs(bounded - wanted) * short, spare, bounded))
    if not found:
        raise build.RangeError("a scale factor does not fit 32-bit arithmetic")
    lost, spare, bounded = min(found)
    return spare, bounded, lost


def _nearby(ratio: Fraction, top: int, rest: Fraction) -> Fraction | None:
    """The ratio, or one near it with a numerator and a divisor so small that the product and ``rest`` fit 32 bits."""
    limit = build.UINT32_MAX
    bounded, numerator = ratio, limit // 2 // max(1, top)
    while top * bounded.numerator + bounded.denominator * rest > limit:
        if numerator < 1:
            return None
        bounded = 1 / (1 / ratio).limit_denominator(numerator)
        numerator //= 2
    return bounded
