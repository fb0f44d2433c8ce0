"""The scalar lemmas of docs/numbers.md, each for all numbers of its domain by an SMT solver.

Every claim is also made a little stronger than it is, and must then fail: so that it says something.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import z3

from tests.proofs.symbolic import Known

NUMBERS = Path(__file__).resolve().parents[2] / "docs" / "numbers.md"

ELSEWHERE = {
    "set": "tests/lower/test_centroid.py",  # over all heights, by exhaustion
    "centroid": "tests/lower/test_bounds.py",  # of integrals; its algebra is below
    "slope": "tests/lower/test_slopes.py",  # of integrals over segments
    "digit": "tests/proofs/test_kernels_proved.py",  # with the code that it is of
}
"""Lemmas that are no statement about a few numbers, and where they are tested."""


def proved(known: Known, claim: Any, too_much: Any) -> None:
    """The claim follows from what is known, which contradicts nothing, and the stronger claim does not."""
    known.consistent()
    known.prove(claim, "the lemma")
    solver = z3.Solver()
    solver.add(*known.facts, z3.Not(too_much))
    assert solver.check() == z3.sat, "more than the lemma says is not refuted"


def size(x: Any) -> Any:
    """The absolute value."""
    return z3.If(x >= 0, x, -x)


def largest(*values: Any) -> Any:
    """``max``."""
    found = values[0]
    for value in values[1:]:
        found = z3.If(found >= value, found, value)
    return found


def least(*values: Any) -> Any:
    """``min``."""
    found = values[0]
    for value in values[1:]:
        found = z3.If(found <= value, found, value)
    return found


def near(known: Known, value: Any, by: Any) -> Any:
    """A number that is off from a value by at most so much."""
    return known.number(lambda n: n <= value + by, lambda n: n >= value - by)


def between(known: Known, low: Any, high: Any) -> Any:
    """A number of an interval."""
    return known.number(lambda n: n >= low, lambda n: n <= high)


def floored(known: Known, value: Any) -> Any:
    """The floor, of which no more is known than that it is at most the value and less than 1 below it."""
    return known.number(lambda f: f <= value, lambda f: f > value - 1)


def test_line() -> None:
    """A rounded line is off by at most half a unit and its drift at the worse end of the piece."""
    known = Known()
    n = between(known, 1, 65535)
    u = between(known, 0, n)
    y0, k, c, m = (known.number() for _ in range(4))  # c and m over 2^s
    value = floored(known, c + m * u)
    start, end = c - z3.RealVal("1/2") - y0, c - z3.RealVal("1/2") - y0 + (m - k) * n
    drift = largest(size(start), size(end))
    error = size(value - (y0 + k * u))
    proved(known, error <= z3.RealVal("1/2") + drift, error <= z3.RealVal("49/100") + drift)


def test_scale() -> None:
    """A floored line with a rising drift D is off by more than o - 1 and by at most D + o."""
    known = Known()
    n = between(known, 1, 65535)
    u = between(known, 0, n)
    z0, k, m, c = (known.number() for _ in range(4))
    known.facts.append(m >= k)
    drift, o = (m - k) * n, c - z0
    off = floored(known, c + m * u) - (z0 + k * u)
    proved(known, z3.And(off > o - 1, off <= drift + o), off <= drift + o - z3.RealVal("1/100"))


def test_least_and_greatest() -> None:
    """`min` and `max` of numbers that are off by at most e and f are off by at most the larger of these."""
    for joined in (least, largest):
        known = Known()
        e, f = between(known, 0, 1), between(known, 0, 1)
        a, b = between(known, 0, 1), between(known, 0, 1)
        off = size(joined(near(known, a, e), near(known, b, f)) - joined(a, b))
        proved(known, off <= largest(e, f), off <= (e + f) / 2)


def test_an_operand_that_cannot_be_the_least() -> None:
    """An operand that is above the other in both meanings adds nothing to the error of `min`."""
    known = Known()
    e, f = between(known, 0, 1), between(known, 0, 1)
    a = between(known, 0, 1)
    b = between(known, a + e + f, 3)
    off = size(least(near(known, a, e), near(known, b, f)) - least(a, b))
    proved(known, off <= e, off <= e / 2)


def test_product_of_degrees() -> None:
    """A rounded product of degrees is off by both errors, each at most once, and half a unit."""
    known = Known()
    e, f, half = between(known, 0, 1), between(known, 0, 1), z3.RealVal("1/65536")
    a, b = between(known, 0, 1), between(known, 0, 1)
    x, y = near(known, a, e), near(known, b, f)
    known.facts += [x >= 0, x <= 1, y >= 0, y <= 1]
    off = size(near(known, x * y, half) - a * b)
    proved(known, off <= e + f + half, off <= e + f)


def test_centroid() -> None:
    """A quotient of sums that are off is off by what the sums are, moments taken about it, over the area."""
    known = Known()
    area, other = between(known, 1, 100), between(known, 1, 100)
    moment, wrong = known.number(), known.number()
    y, got = known.number(), known.number()
    known.facts += [y * area == moment, got * other == wrong]
    lever = (wrong - moment) - y * (other - area)
    proved(known, (got - y) * other == lever, (got - y) * area == lever)


def test_average() -> None:
    """A weighted average of two places moves by each weight's error times its distance, over the weights' sum."""
    known = Known()
    e, f = between(known, 0, 1), between(known, 0, 1)
    a, b = between(known, 1, 2), between(known, 1, 2)
    p, q = between(known, -1, 1), between(known, -1, 1)
    a1, b1 = near(known, a, e), near(known, b, f)
    known.facts += [a1 >= z3.RealVal("1/10"), b1 >= z3.RealVal("1/10")]
    y, got = known.number(), known.number()
    known.facts += [y * (a + b) == p * a + q * b, got * (a1 + b1) == p * a1 + q * b1]
    moved = (got - y) * (a1 + b1)
    proved(known, moved == (a1 - a) * (p - y) + (b1 - b) * (q - y), moved == (a1 - a) * (p - y))


def test_multilinear() -> None:
    """An interpolation between places moves by the degree's error times their distance, and by no more than theirs."""
    known = Known()
    d = between(known, 0, 1)
    e, r = between(known, 0, 1), between(known, 0, 1)
    low, high = between(known, -1, 1), between(known, -1, 1)
    d1, low1, high1 = near(known, d, e), near(known, low, r), near(known, high, r)
    known.facts += [d1 >= 0, d1 <= 1]
    moved = size(low1 * (1 - d1) + high1 * d1 - (low * (1 - d) + high * d))
    proved(known, moved <= size(high - low) * e + r, moved <= size(high - low) * e + r / 2)


def test_inner_weights() -> None:
    """The four corners' weights are never negative and sum to one, however the product of the degrees is rounded."""
    for bits in (4, 8, 15):
        one = 2**bits
        a, b, product = z3.Ints("a b product")
        known = Known([a >= 0, a <= one, b >= 0, b <= one])
        known.facts += [2 * one * product <= 2 * a * b + one, 2 * one * product > 2 * a * b - one]
        rest = one - a - b + product
        proved(
            known,
            z3.And(product >= 0, a - product >= 0, b - product >= 0, rest >= 0),
            z3.And(product >= 0, a - product >= 1),
        )


def test_halves() -> None:
    """Two outputs' weighted sums in one word: each half holds its own sum, and the word is below 2^32."""
    weights, places = ([z3.Int(f"{name}{k}") for k in range(4)] for name in "wp")
    one, most = z3.Ints("one most")
    known = Known([one >= 1, most >= 0, z3.Sum(weights) == one, most * one < 2**16])
    known.facts += [z3.And(w >= 0, p >= 0, p <= most) for w, p in zip(weights, places, strict=True)]
    for w, p in zip(weights, places, strict=True):
        known.prove(z3.And(w * p >= 0, w * p <= w * most), "a weighted place is at most the weighted largest")
        known.facts += [w * p >= 0, w * p <= w * most]
    known.facts.append(z3.Sum([w * most for w in weights]) == one * most)
    total = z3.Sum([w * p for w, p in zip(weights, places, strict=True)])
    known.prove(z3.And(total >= 0, total < 2**16), "a half holds its sum")
    low, high = z3.Ints("low high")
    word = Known([low >= 0, low < 2**16, high >= 0, high < 2**16])
    packed = low + 2**16 * high
    proved(word, z3.And(packed < 2**32, packed % 2**16 == low, packed / 2**16 == high), packed < 2**31)


def test_tail() -> None:
    """A quotient rounded down, scaled with half of its step and of its drift made up, is off by as much as is said."""
    known = Known()
    most = z3.RealVal(65536)
    exact = between(known, 0, most)
    q = floored(known, exact)
    m, unit = between(known, 0, 1), between(known, 0, 1)  # m over 2^s, and what it stands for
    drift = (m - unit) * most
    c = z3.RealVal("1/2") + m / 2 - drift / 2
    raw = floored(known, m * q + c)
    bound = z3.RealVal("1/2") + m / 2 + size(drift) / 2
    off = size(raw - unit * exact)
    proved(known, off <= bound, off <= bound - m / 2)


def test_place() -> None:
    """Saturating moves nothing apart; clamping to legal raws costs what lies beyond them, or what the rest costs."""
    known = Known()
    low, a, b = known.number(), known.number(), known.number()
    high = known.number(lambda h: h >= low)

    def held(x: Any) -> Any:
        return least(largest(x, low), high)

    proved(known, size(held(a) - held(b)) <= size(a - b), size(held(a) - held(b)) <= size(a - b) / 2)
    known = Known()
    last, beyond, error = known.number(), between(known, 0, 1), between(known, 0, 2)
    exact = known.number(lambda x: x <= last + beyond)
    raw = near(known, exact, error)
    clamped = least(raw, last)
    proved(known, size(clamped - exact) <= largest(error, beyond), size(clamped - exact) <= error)


@pytest.mark.gate
def test_quotient() -> None:
    """A saturated quotient moves by at most the dividend's error and R times the divisor's, over the least divisor."""
    known = Known()
    low, e, f = known.number(), between(known, 0, 1), between(known, 0, 1)
    high = known.number(lambda h: h >= low)
    smallest = known.number(lambda s: s > 0)
    y = known.number(lambda n: n >= smallest)
    x, q, got = known.number(), known.number(), known.number()
    x1, y1 = near(known, x, e), near(known, y, f)
    known.facts += [y1 >= smallest, q * y == x, got * y1 == x1]
    reach = largest(size(low), size(high))
    moved = size(least(largest(got, low), high) - least(largest(q, low), high))
    proved(known, moved * smallest <= e + reach * f, moved <= 0)


def test_division_by_a_constant() -> None:
    """One product and a shift are the quotient by d, as long as the numerator is at most the n that is said."""
    x, n, d, m, power, q = z3.Ints("x n d m power q")
    known = Known([d >= 1, power >= 1, m * d >= power, n * (m * d - power) < power])
    known.facts += [x >= 0, x <= n, x * (m * d - power) <= n * (m * d - power)]
    known.facts += [q * power <= x * m, x * m < (q + 1) * power]
    # Times d, in the order in which the products are wanted.
    known.facts += [d * (q * power) <= d * (x * m), d * (x * m) < d * ((q + 1) * power)]
    known.prove(d * (x * m) == x * power + x * (m * d - power), "x m d is x 2^s and an excess")
    excess = z3.Int("excess")
    linear = Known([excess >= 0, excess < power, power >= 1, d >= 1])
    linear.facts += [power * (q * d) <= power * x + excess, power * x + excess < power * (q * d + d)]
    linear.prove(z3.And(q * d <= x, x < q * d + d), "the floor of x / d")


def test_levels_sum() -> None:
    """The union of cuts between two strengths is integrated by its ends, where pairs of neighbours meet at one half."""
    known = Known()
    s, t = between(known, 0, z3.RealVal("1/2")), between(known, 0, z3.RealVal("1/2"))
    n, p = between(known, 1, 8), between(known, 0, 4)
    known.facts.append(2 * p <= n)

    def area(c: Any) -> Any:
        return (n - p) * c - (n - 2 * p) * c * c / 2

    width = n * (1 - s) - p * (1 - 2 * s)
    # Its derivative is the width of the union of cuts, which is not negative where strengths lie.
    slope = area(s) - area(t) - (s - t) * (n - p - (n - 2 * p) * (s + t) / 2)
    proved(known, z3.And(slope == 0, width >= 0, width == n - p - (n - 2 * p) * s), width >= n / 2 + 1)


def test_every_lemma_is_proved_or_tested() -> None:
    """Each lemma that docs/numbers.md names has a test of its name here, or is named with the one elsewhere."""
    named = set(re.findall(r'\*\*Lemma "(\w+)"\*\*', NUMBERS.read_text(encoding="utf-8")))
    here = {name.removeprefix("test_") for name in globals() if name.startswith("test_")}
    assert named, "the page names its lemmas"
    assert named <= here | set(ELSEWHERE), named - here - set(ELSEWHERE)
    assert all((NUMBERS.parents[1] / path).is_file() for path in ELSEWHERE.values())
