"""From real numbers to the raws that stand for them: what an application does before it calls the C."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from fuzzyspec.model.variable import RAW_LIMITS, Variable

_NEAR = 1e-6
"""How near to a tie float64 is not trusted to round; the rest is far from one, whatever its own rounding did."""


def quantise(variable: Variable, values: npt.ArrayLike) -> npt.NDArray[np.int64]:
    """The nearest raw of every value in the variable's unit, ties up; any shape, and the result has the same.

    Held within the C type, not within the range: what lies outside the range is for the C to saturate and to tell.
    Raises ValueError for NaN.
    """
    given = np.asarray(values, dtype=np.float64)
    if np.isnan(given).any():
        raise ValueError(f"`{variable.name}` holds NaN")
    low, high = RAW_LIMITS[variable.raw.ctype]
    with np.errstate(over="ignore"):
        position = (given - float(variable.raw.origin)) / float(variable.raw.step) + 0.5
    position = np.clip(position, low - 1.0, high + 1.0)
    raws = np.floor(position)
    tied = np.abs(position - np.round(position)) < _NEAR
    raws[tied] = [_nearest_of(variable, float(v)) for v in given[tied]]
    held: npt.NDArray[np.int64] = np.clip(raws, low, high).astype(np.int64)
    return held


def nearest(variable: Variable, value: Fraction) -> int:
    """The same for one exact value."""
    low, high = RAW_LIMITS[variable.raw.ctype]
    return max(low, min(high, math.floor(variable.raw.position(value) + Fraction(1, 2))))


def _nearest_of(variable: Variable, value: float) -> int:
    low, high = RAW_LIMITS[variable.raw.ctype]
    if math.isinf(value):
        return high if (value > 0) == (variable.raw.step > 0) else low
    return nearest(variable, Fraction(value))
