"""Floats into a unit and out of it."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from fuzzyspec.exact.signals import from_coherent, to_coherent
from fuzzyspec.model.units import Unit

NUMBERS = range(-50, 51)
SCALES = sorted({Fraction(a, b) for k in range(1, 13) for a, b in ((k, 1), (1, k))})


@pytest.mark.parametrize("offset", [0, -3])
@pytest.mark.parametrize("scale", SCALES, ids=str)
def test_whole_scales_cost_one_rounding(scale: Fraction, offset: int) -> None:
    """Where the scale or its reciprocal is whole, a value gets to coherent units and back as if divided once."""
    unit = Unit("u", (), scale, Fraction(offset))
    there = to_coherent(np.array(NUMBERS, dtype=np.float64), unit)
    assert there.tolist() == [float(scale * n) + offset for n in NUMBERS]
    back = from_coherent(np.array(NUMBERS, dtype=np.float64), unit)
    assert back.tolist() == [float((n - offset) / scale) for n in NUMBERS]
