"""From raw integers to the real numbers that they stand for."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from fuzzyspec.exact.result import Floats
from fuzzyspec.model.variable import Variable

_EXACT = 2**53
"""Up to here float64 holds every integer, and the quotient of two such is correctly rounded."""


def dequantise(variable: Variable, raws: ArrayLike) -> Floats:
    """The values of raws in the variable's unit, correctly rounded: equal rationals give equal floats.

    A raw outside the legal ones counts as the nearest of them, as it does in the C. Any shape; the result has the same.
    """
    step, origin = variable.raw.step, variable.raw.origin
    den = math.lcm(step.denominator, origin.denominator)
    slope, start = int(step * den), int(origin * den)
    counts = np.clip(np.asarray(raws, dtype=np.int64), variable.raw.lo, variable.raw.hi)
    if not counts.size:
        return np.zeros(counts.shape)
    largest = abs(slope) * max(abs(int(counts.min())), abs(int(counts.max()))) + abs(start)
    if max(largest, den) <= _EXACT:
        return np.asarray((counts * slope + start).astype(np.float64) / float(den))
    distinct, where = np.unique(counts, return_inverse=True)
    # int / int of Python is correctly rounded at any size
    values = np.array([(int(r) * slope + start) / den for r in distinct], dtype=np.float64)
    return values[where].reshape(counts.shape)
