"""Raws to real numbers."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fuzzyspec.exact import dequantise
from fuzzyspec.model.units import ONE
from fuzzyspec.model.variable import Raw, Variable
from tests.exact.exact_models import NOWHERE


def _variable(step: Fraction, origin: Fraction) -> Variable:
    raw = Raw("int16", step, origin, -32768, 32767)
    ends = sorted((raw.value(raw.lo), raw.value(raw.hi)))
    return Variable("x", ends[0], ends[1], ONE, raw, NOWHERE)


@given(
    st.fractions(max_denominator=10**12).filter(bool),
    st.fractions(max_denominator=10**12),
    st.lists(st.integers(-40000, 40000), max_size=20),
)
def test_correctly_rounded(step: Fraction, origin: Fraction, raws: list[int]) -> None:
    """The value of every raw, saturated to the legal ones, is the float nearest to the rational."""
    of = _variable(step, origin)
    legal = [max(of.raw.lo, min(of.raw.hi, r)) for r in raws]
    assert dequantise(of, raws).tolist() == [float(of.raw.value(r)) for r in legal]


def test_shapes() -> None:
    """Any shape goes through, none at all too."""
    of = _variable(Fraction(1, 100), Fraction(0))
    assert dequantise(of, np.arange(6).reshape(2, 3)).tolist() == [[0.0, 0.01, 0.02], [0.03, 0.04, 0.05]]
    assert dequantise(of, 7).shape == ()
    assert dequantise(of, np.zeros((0, 4), dtype=np.int64)).shape == (0, 4)
    third = _variable(Fraction(1, 3**40), Fraction(0))
    assert dequantise(third, np.arange(6).reshape(3, 2)).shape == (3, 2)
