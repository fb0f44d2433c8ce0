"""What an evaluation in real numbers gives back, and the shapes that it takes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
Arrays = Mapping[str, Any]
"""Signal name to anything that numpy reads as an array."""


@dataclass(frozen=True, slots=True)
class Exact:
    """The real-valued meaning of one step, over N independent cases.

    ``outputs``: name to (N,) in the declared unit; ``acting`` is the code as a float. ``decisions``: key to (N,) or
    (N, capacity) integers, what this meaning decides by itself, whatever it was told to take. ``margins``: same keys
    and shapes, how far the operands of the decision are apart (0 is a tie), in degrees or coherent units. Where a
    decision is not asked (an element beyond the count, a branch that is not taken) it is -1 and its margin infinite.
    ``state``: what is held for the next step, in the declared unit.
    """

    outputs: dict[str, Floats]
    decisions: dict[str, Ints]
    margins: dict[str, Floats]
    state: dict[str, Floats]
