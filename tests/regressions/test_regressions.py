"""Specs that once went wrong, each through everything: C, integer program, exact meaning."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fuzzyspec import load
from tests.random_specs.agreement import examine

SPECS = sorted(Path(__file__).parent.glob("*.fz"))


@pytest.mark.parametrize("path", SPECS, ids=lambda p: p.stem)
@pytest.mark.parametrize("choice", [0, 4])
def test_regression(path: Path, choice: int) -> None:
    """C is the program bit for bit, the program within its certificate, for two choices of strategies."""
    examine(load(path), choice, 1000)


def test_values_outside_of_their_places_are_told() -> None:
    """A value that can never be inside of its place sets the status bit at every step; one that always is, at none."""
    spec = load(Path(__file__).parent / "outside_of_its_place.fz")
    found = spec.fixed("step", {"x": np.linspace(0, 1, 9)})
    for name, value in (("above", -4.0), ("below", 4.0), ("constant", 5.0)):
        assert found.flag(f"SATURATED_{name.upper()}").all()
        assert set(found.outputs[name].tolist()) == {value}
    assert "SATURATED_INSIDE" not in found.bits
