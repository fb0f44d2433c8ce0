"""Quotients of a system hold their certificate where their divisors come near 0."""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from fuzzyspec import load
from fuzzyspec.fixed.program import Local
from fuzzyspec.lower.scaled import Scaled
from fuzzyspec.model.variable import Variable

STAGE = """
controller stage {
    input x in [0, 1] { partition A B C }
    output y in [0.503, 0.997] raw uint8 { partition A B C full }
    table y by x { A: A B: B C: C }
}
"""

SYSTEMS = {
    "a divisor that falls as its raw rises": (STAGE, "1 / (1.05 - stage(x: x / 4 s).y)", "x in [0, 4] s", ""),
    "a divisor that is smaller in the exact meaning": (STAGE, "1 / (stage(x: x).y - 0.5)", "x in [0, 1]", ""),
    "counts that run backwards": (
        "",
        "clamp(1 s / x otherwise 0, 0, 7)",
        "x in [0, 4] s raw uint16 4095..0",
        "",
    ),
    "a constant less an input": ("", "clamp(1 s / (4 s - x) otherwise 0, 0, 7)", "x in [0, 4] s", ""),
    "a dividend rounded to the divisor's step": (
        "",
        "clamp(z / (x + y / 64) otherwise 0 m/s, -1 m/s, 3 m/s)",
        "x in [0, 1] s raw uint16 0..65535",
        "input y in [0, 1] s raw uint16 0..65535  input z in [0, 6] m raw uint16 0..65521",
    ),
    "a fallback far outside a narrow place": (
        "",
        "clamp(y / x otherwise y + 40, 0.001, 0.002)",
        "x in [0, 1]",
        "input y in [-70, 80]",
    ),
    "an inexact dividend that stays off 0": (
        STAGE,
        "clamp((stage(x: x).y * 1 s + 0.5 s) / y otherwise 0, 0, 7)",
        "x in [0, 1]",
        "input y in [0, 2] s",
    ),
    "an inexact dividend below 0": (
        STAGE,
        "clamp((0.5 s - 3 s * stage(x: x).y) / y otherwise 0, -6, 2)",
        "x in [0, 1]",
        "input y in [0, 2] s",
    ),
    "a square over a sum with it": (
        "",
        "x * x / (x * x + 3.3 s^2)",
        "x in [-7.77, 12.3] s",
        "",
    ),
}


def near_ends(lo: int, hi: int, few: int) -> list[int]:
    """Raws near both ends, and some between."""
    return sorted({*range(lo, lo + few), *range(hi - few + 1, hi + 1), *range(lo, hi + 1, max(1, (hi - lo) // few))})


@pytest.mark.parametrize("name", SYSTEMS)
def test_quotients_hold_their_bound(name: str) -> None:
    """The error is within the certified one, at the ends of the raws and between, for divisors of every kind."""
    before, value, first, others = SYSTEMS[name]
    spec = load(f"module m\n{before}\nsystem s {{\n  input {first}  {others}\n  output q = {value}\n}}\n")
    ports = [i for i in spec.systems["s"].inputs if isinstance(i, Variable)]
    grids = [near_ends(p.raw.lo, p.raw.hi, 2000 if len(ports) == 1 else 12) for p in ports]
    points = np.array(list(product(*grids)), dtype=np.int64)
    raws = {p.name: points[:, k] for k, p in enumerate(ports)}
    found = spec.fixed("s", raws, raw=True)
    exact = spec.exact("s", spec.dequantise("s", raws), decisions=found.decisions)
    bound = spec.certificate("s").output("q").error
    assert bound is None or np.abs(found.outputs["q"] - exact.outputs["q"]).max() <= float(bound)


@pytest.mark.parametrize("name", ["an inexact dividend that stays off 0", "an inexact dividend below 0"])
def test_a_quotient_that_saturates_before_its_divisor_is_0_has_a_bound(name: str) -> None:
    """Lemma "quotient": near 0 of the divisor both meanings are at the range's end, so errors count elsewhere only."""
    before, value, first, others = SYSTEMS[name]
    spec = load(f"module m\n{before}\nsystem s {{\n  input {first}  {others}\n  output q = {value}\n}}\n")
    found = spec.certificate("s").output("q").percent_of_range
    assert found is not None
    assert found < 2


def test_a_value_that_falls_knows_its_ends() -> None:
    """With a negative step the low end belongs to the highest integer."""
    value = Scaled(Local("i", "uint16", 3, 10), Fraction(-1, 2), Fraction(7), Fraction(0))
    assert (value.lo, value.hi) == (Fraction(2), Fraction(11, 2))


def test_what_cannot_be_the_largest_adds_no_error() -> None:
    """Of ``max`` only operands count that can be the result: a coarse one far below the others does not."""
    spec = load(
        f"module m\n{STAGE}\nsystem s {{ input x in [0, 1]  output q = max(stage(x: x).y, x + 2)"
        "  output p = min(stage(x: x).y, x - 2)  output r = max(stage(x: x).y, x) }"
    )
    found = spec.certificate("s")
    coarse, fine = found.output("r").percent_of_range, [found.output(o).percent_of_range for o in ("q", "p")]
    assert coarse is not None
    for percent in fine:
        assert percent is not None
        assert percent * 50 < coarse
