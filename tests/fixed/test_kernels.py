"""The two kernels as numpy computes them, over dense grids and at every edge."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fuzzyspec.fixed.run import mul_high, quotient

EDGES = np.array(sorted({2**k + d for k in range(33) for d in (-1, 0, 1) if 0 <= 2**k + d < 2**32}), dtype=np.int64)


def ratio(num: int, den: int) -> int:
    """What the quotient promises, word by word."""
    return num * 65536 // den if num < den else 65536


def test_mul_high_over_every_multiplier() -> None:
    """Every multiplier 0 .. 2**16 against every power of two and its neighbours: Python's own product, shifted."""
    b = np.arange(65537, dtype=np.int64)
    for a in EDGES.tolist():
        assert mul_high(a, b).tolist() == [a * m >> 16 for m in range(65537)]


def test_quotient_over_every_pair_of_small_numbers() -> None:
    """Every pair below 300, equal ones, larger numerators and 0 divisors among them."""
    num, den = (g.ravel() for g in np.meshgrid(np.arange(300), np.arange(300)))
    assert quotient(num, den).tolist() == [ratio(n, d) for n, d in zip(num.tolist(), den.tolist(), strict=True)]


def test_quotient_at_every_edge() -> None:
    """Powers of two and their neighbours against each other, divisors below 2**31 and numerators below 2**32."""
    num, den = (g.ravel() for g in np.meshgrid(EDGES, EDGES[EDGES < 2**31]))
    assert quotient(num, den).tolist() == [ratio(n, d) for n, d in zip(num.tolist(), den.tolist(), strict=True)]


@given(st.lists(st.tuples(st.integers(0, 2**32 - 1), st.integers(0, 2**31 - 1)), min_size=1, max_size=50))
def test_quotient_of_anything(pairs: list[tuple[int, int]]) -> None:
    """Any numerator and any divisor of the domain, divisors just above the numerator too."""
    pairs = [*pairs, *((n, n + 1) for n, _ in pairs if n + 1 < 2**31)]
    num, den = (np.array(column, dtype=np.int64) for column in zip(*pairs, strict=True))
    assert quotient(num, den).tolist() == [ratio(n, d) for n, d in pairs]
