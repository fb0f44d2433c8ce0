"""Straight lines in integers."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fuzzyspec.fixed.build import UINT32_MAX
from fuzzyspec.lower.lines import DEGREE_ONE, fit

HEIGHTS = st.sampled_from([Fraction(0), Fraction(DEGREE_ONE)]) | st.fractions(0, DEGREE_ONE, max_denominator=60)


@settings(max_examples=200)
@given(start=HEIGHTS, end=HEIGHTS, length=st.integers(0, 65535) | st.integers(0, 9))
@example(start=Fraction(0), end=Fraction(DEGREE_ONE), length=65535)
@example(start=Fraction(DEGREE_ONE), end=Fraction(0), length=3)
@example(start=Fraction(1, 59), end=Fraction(0), length=65535)
def test_a_line_is_within_its_error_everywhere(start: Fraction, end: Fraction, length: int) -> None:
    """At every u the integer line is within its stated error, which some u attains; it takes at most its stated top,
    and fits 32 bits on the way."""
    slope = (end - start) / length if length else Fraction(0)
    line = fit(start, slope, length)
    u = np.arange(length + 1, dtype=np.int64)
    scaled = line.offset + (-line.slope if line.falling else line.slope) * u
    assert scaled.min() >= 0 and scaled.max() <= UINT32_MAX
    y = scaled >> line.shift
    assert y.max() <= line.top
    # |y - (start + slope u)| <= error, multiplied out: all of it are integers.
    d = math.lcm(start.denominator, slope.denominator)
    exact = int(start * d) + int(slope * d) * u
    assert np.abs(y * d - exact).max() == line.error * d
    # What is exactly 0 or 1 comes out exactly: the error stays below one unit.
    assert line.error < 1
    if start == end and start.denominator == 1:
        assert set(y.tolist()) == {int(start)} and line.error == 0


@given(start=st.integers(0, 100), step=st.integers(-5, 300), length=st.integers(1, 20))
def test_integer_lines_are_exact(start: int, step: int, length: int) -> None:
    """A line through integers has no error at all."""
    if start + step * length < 0:
        start -= step * length
    line = fit(Fraction(start), Fraction(step), length)
    assert line.error == 0
