"""The last step of every defuzzifier: a weighted mean becomes a raw.

``t = moment / area`` lies in [0, 1], relative to the output's range; a 16-bit quotient of the unshortened sums,
one multiply
and one shift make it a raw.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Const, Define, Division, Expr, Stmt
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.variable import Variable

HALF = Fraction(1, 2)
QUOTIENT_ONE = 1 << 16


@dataclass(frozen=True, slots=True)
class Tail:
    """``error`` bounds |raw - exact position| for an exact t of ``moment / area``, in raw counts (lemma "tail")."""

    error: Fraction


def mean_to_raw(
    variable: Variable, moment: Expr, area: Expr, division: Division, scope: Scope
) -> tuple[list[Stmt], Expr, Tail]:
    """The raw nearest to ``lo + (hi - lo) * moment / area``; needs ``0 <= moment <= area < 2**31``."""
    body: list[Stmt] = []
    ratio = build.quotient(moment, area, division)
    t = build.local(scope.name(f"{variable.name}_t"), ratio)
    body.append(Define(t, ratio, True))
    raw = variable.raw
    # Counted from the legal raw at the low end of the range, upwards in value.
    at_lo, at_hi = raw.position(variable.lo), raw.position(variable.hi)
    low = at_lo - raw.lo if raw.step > 0 else raw.hi - at_lo
    span = abs(at_hi - at_lo)
    counts = raw.hi - raw.lo
    shift = 0
    while shift < 24 and math.floor(span * 2 ** (shift + 1) / QUOTIENT_ONE + HALF) < QUOTIENT_ONE - 1:
        shift += 1
    m = math.floor(span * 2**shift / QUOTIENT_ONE + HALF)
    # The quotient is floored: half its step is added back. The multiplier's rounding drifts over t; half of that
    # is too.
    drift = m * QUOTIENT_ONE - span * 2**shift
    offset = (
        math.floor((low + HALF) * 2**shift + Fraction(m, 2) - drift / 2 + HALF)
        if shift
        else math.floor(low + HALF + Fraction(m, 2))
    )
    offset = min(offset, build.UINT32_MAX - m * QUOTIENT_ONE)
    while shift and m % 2 == 0 and offset % 2 == 0:
        m, shift, offset = m // 2, shift - 1, offset // 2
    scaled = build.mul(t, Const(m))
    if offset < 0:
        bound = build.local(scope.name(f"{variable.name}_scaled"), scaled)
        body.append(Define(bound, scaled, True))
        scaled = build.above(bound, Const(-offset))
    else:
        scaled = build.add(scaled, Const(offset))
    value = build.shift_right(scaled, shift)
    steps = build.local(scope.name(f"{variable.name}_steps"), value)
    body.append(Define(steps, value, True))
    capped = build.least(steps, Const(counts))
    result = build.add(capped, Const(raw.lo)) if raw.step > 0 else build.sub(Const(raw.hi), capped)
    at = [Fraction(offset, 2**shift) - HALF - low + t_ * (Fraction(m * QUOTIENT_ONE, 2**shift) - span) for t_ in (0, 1)]
    half_step = Fraction(m, 2 ** (shift + 1))
    centre = max(abs(a - half_step) for a in at)
    rounding = HALF + centre + half_step
    # Clamping to the legal raws costs at most the part of a count between them and the range's ends.
    sliver = max(-low, span + low - counts, Fraction(0))
    return body, result, Tail(max(rounding, sliver))
