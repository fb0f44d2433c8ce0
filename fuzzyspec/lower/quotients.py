"""Division into a ranged place: a 16-bit quotient of integers that stay exact."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import AllOf, Const, Division, Select, Test
from fuzzyspec.lower.scaled import Arithmetic, Scaled, cause_of, constant

QUOTIENT_ONE = 1 << 16


def divide(
    arithmetic: Arithmetic, x: Scaled, y: Scaled, into: tuple[Fraction, Fraction], division: Division, name: str
) -> Scaled:
    """``x / y`` saturated into a range (docs/numbers.md, lemma "quotient").

    With ``t = (x/y - lo) / (hi - lo)`` the program computes ``(x - lo y) / ((hi - lo) y)``, numerator and divisor
    exact in
    one step: no correlation between them is lost, nothing overflows, and x/0 is the end on x's side. Raises RangeError
    where the divisor's integers may be 0 although its range is not, or hold both signs.
    """
    if y.hi < -y.lo:
        x, y = arithmetic.negated(x), arithmetic.negated(y)
    if y.lo < 0:
        # The exact divisor has one sign, so what lies beyond 0 is error, and clamping takes some of it away.
        if -y.lo > y.error:
            raise build.RangeError("the divisor may have both signs")
        y = arithmetic.largest([y, constant(Fraction(0))], f"{name}_by")
    lo, hi = into
    if lo == hi:
        return constant(lo)
    above_low = arithmetic.plus(x, arithmetic.by_constant(y, -lo), name)
    extent = arithmetic.by_constant(y, hi - lo)
    p, q = arithmetic.common([above_low, extent], name)
    # What numerator and divisor were rounded by on the way here; 0 wherever the bits can hold both.
    numerator_off = p.error - x.error - abs(lo) * y.error
    divisor_off = q.error - extent.error
    signed = arithmetic.bind(p.expr, name)
    num = arithmetic.bind(build.greatest(signed, Const(0)), f"{name}_num")
    den = arithmetic.bind(q.expr, f"{name}_den")
    if den.lo < 0:
        den = arithmetic.bind(build.greatest(den, Const(0)), f"{name}_den")
    ratio = build.quotient(num, den, division)
    if signed.lo < 0 and den.lo <= 0:
        # A negative x over 0 is the low end; the quotient kernel alone would give the high one.
        ratio = Select(build.compare("<=", signed, Const(0)), Const(0), ratio, 0, QUOTIENT_ONE)
    t = arithmetic.bind(ratio, name)
    step = (hi - lo) / QUOTIENT_ONE
    half = step / 2
    error, cause = half, cause_of(x, y)
    if x.error or y.error or numerator_off or divisor_off:
        spread = hi - lo
        worst = x.error + max(abs(lo), abs(hi)) * y.error + numerator_off + divisor_off
        nearest = (
            max(y.lo, _unsaturated(x, into, numerator_off + abs(lo) * divisor_off / spread)) - divisor_off / spread
        )
        error += min(spread, worst / nearest) if nearest > 0 else spread
        if 4 * error > spread:
            cause = f"{name}: its divisor comes near 0 while its operands carry an error"
    return Scaled(t, step, lo + half, error, cause)


def _unsaturated(x: Scaled, into: tuple[Fraction, Fraction], off: Fraction) -> Fraction:
    """What a divisor's size is at least where ``x`` by it is not saturated, from exact operands to computed ones."""
    low, high = x.lo - x.error - off, x.hi + x.error + off
    if low > 0 and into[1] > 0:
        return low / into[1]
    if high < 0 and into[0] < 0:
        return high / into[0]
    return Fraction(0)


def zero_over_zero(arithmetic: Arithmetic, x: Scaled, y: Scaled, name: str) -> tuple[Test, Fraction]:
    """The test for 0/0 and the width of its band in coherent units."""
    p, q = arithmetic.common([x, y], name)
    a, b = arithmetic.bind(p.expr, name), arithmetic.bind(q.expr, f"{name}_den")
    test = AllOf((build.compare("==", a, Const(0)), build.compare("==", b, Const(0))))
    return test, max(p.error, q.error)


def settle(arithmetic: Arithmetic, test: Test, quotient: Scaled, fallback: Scaled, name: str) -> Scaled:
    """The fallback where the test holds, in the quotient's format.

    The place that the quotient goes straight into saturates the fallback too: what lies beyond the quotient's range is
    taken to its end, which is no error.
    """
    half = quotient.step / 2
    inside = _within(arithmetic, fallback, quotient.offset - half, quotient.offset + QUOTIENT_ONE * quotient.step, name)
    other = arithmetic.restep(
        arithmetic.rounded(inside, quotient.step, quotient.offset, name), quotient.step, quotient.offset
    )
    settled = arithmetic.bind(build.greatest(arithmetic.bind(other.expr, name), Const(0)), name)
    settled = build.least(settled, Const(QUOTIENT_ONE))
    expr = build.select(test, settled, quotient.expr)
    return Scaled(
        arithmetic.bind(expr, name), quotient.step, quotient.offset, max(quotient.error, other.error), quotient.cause
    )


def _within(arithmetic: Arithmetic, value: Scaled, lo: Fraction, hi: Fraction, name: str) -> Scaled:
    """A value taken to the nearest of its own steps around ``lo .. hi``, where it leaves that."""
    ends = sorted(((lo - value.offset) / value.step, (hi - value.offset) / value.step))
    i = build.greatest(arithmetic.bind(value.expr, name), Const(math.floor(ends[0])))
    return replace(value, expr=build.least(arithmetic.bind(i, name), Const(math.ceil(ends[1]))))
