"""The last step of a defuzzifier: a quotient of sums becomes a raw."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyspec.fixed.program import Division
from fuzzyspec.lower.mean import mean_to_raw
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.variable import Variable
from tests.lower.lower_models import variables
from tests.lower.lower_running import given as reading
from tests.lower.lower_running import outcome

LARGEST = 2**31 - 1


def pairs(seed: int, n: int) -> list[tuple[int, int]]:
    """Sums with ``0 <= moment <= area``, area of any size, quotients at both ends and near ties."""
    dice = random.Random(seed)
    found = [(0, 1), (1, 1), (0, LARGEST), (LARGEST, LARGEST), (LARGEST - 1, LARGEST), (1, LARGEST), (1, 2), (1, 3)]
    for _ in range(n):
        area = dice.randint(1, min(LARGEST, 2 ** dice.randint(1, 31)))
        exact = Fraction(dice.randint(0, 65536), 65536) * area
        found.append((dice.randint(0, area), area))
        found += [(m, area) for m in (int(exact) - 1, int(exact), int(exact) + 1) if 0 <= m <= area]
    return found


@pytest.mark.parametrize("division", get_args(Division))
@settings(max_examples=60)
@given(variable=variables(), seed=st.integers(0, 2**20))
def test_a_mean_lands_within_the_tails_error(division: Division, variable: Variable, seed: int) -> None:
    """For any sums the raw is legal and within the stated counts of the exact place, at ends that are no raws too."""
    sums = pairs(seed, 60)
    start = [reading("moment", "uint32", 0, LARGEST), reading("area", "uint32", 0, LARGEST)]
    body, raw, tail = mean_to_raw(variable, start[0][1], start[1][1], division, Scope())
    steps = [define for define, _ in start]
    inputs = {"moment": [m for m, _ in sums], "area": [a for _, a in sums]}
    raws = outcome([*steps, *body], {"raw": raw}, inputs)["raw"].tolist()
    own = variable.raw
    for (moment, area), found in zip(sums, raws, strict=True):
        assert own.lo <= found <= own.hi
        exact = own.position(variable.lo + (variable.hi - variable.lo) * Fraction(moment, area))
        assert abs(found - exact) <= tail.error, (moment, area)
