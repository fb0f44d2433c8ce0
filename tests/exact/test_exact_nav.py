"""The whole navigation step of examples/nav.fz, worked out a second time from the paper's equations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fuzzyspec.check import check
from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.exact import (
    Point,
    controller_point,
    dequantise,
    evaluate_system,
    evaluate_system_exactly,
)
from fuzzyspec.model.controller import Controller
from fuzzyspec.model.system import ListInput, System
from fuzzyspec.syntax import parse
from tests.exact.exact_rounding import U, output_error, strength_error

EXAMPLES = Path(__file__).parents[2] / "examples"
LANES = 60


@cache
def nav() -> tuple[System, Controller, Controller]:
    """The system and its two layers."""
    source = Source("nav.fz", (EXAMPLES / "nav.fz").read_text(encoding="utf-8"))
    module, diagnostics = check(*_parsed(source))
    assert module is not None, diagnostics
    return module.systems[0], module.controllers[0], module.controllers[1]


def _parsed(source: Source) -> Any:
    tree, diagnostics = parse(source)
    return tree, source, diagnostics


@dataclass(frozen=True)
class Worked:
    """A step worked out: the values that leave, and how far float64 may be from each."""

    outputs: dict[str, Fraction]
    errors: dict[str, Fraction]
    drive: Point
    drive_error: Fraction
    """Of the second layer's strengths."""


def work_out(inputs: Mapping[str, Any]) -> Worked:
    """Equations 5 to 7, definition 7 and equation 1, for one case."""
    _, danger, velocity = nav()
    sectors: dict[str, list[tuple[Fraction, Fraction]]] = {"left": [], "front": [], "right": []}
    for number in range(min(inputs["obstacles.count"], 16)):
        distance, bearing, speed, radius = (
            inputs[f"obstacles.{f}"][number] for f in ("distance", "bearing", "speed", "radius")
        )
        gap = max(Fraction(0), distance - Fraction(1, 5) - radius)
        # constants of up to 8 m, two differences
        gap_error = 4 * 8 * U
        closing = 2 * speed
        if closing:
            eta_t = min(Fraction(6), gap / closing)
            eta_t_error = min(Fraction(6), gap_error / closing + 4 * U * gap / closing)
        else:
            eta_t, eta_t_error = Fraction(6), Fraction(0)
        eta_d = min(Fraction(4), gap / Fraction(2, 5))
        eta_d_error = gap_error * Fraction(5, 2) + 4 * 4 * U
        point = controller_point(danger, {"eta_t": eta_t, "eta_d": eta_d})
        error = output_error(danger, danger.outputs[0], point, {"eta_t": eta_t_error, "eta_d": eta_d_error})
        assert error is not None
        for sector, low, high in (("left", -90, -30), ("front", -30, 30), ("right", 30, 90)):
            if low <= bearing <= high:
                sectors[sector].append((point.outputs["ddc"], error))
    target = max(Fraction(-90), min(Fraction(90), inputs["target_bearing"]))
    layer2 = {"target": target} | {s: max((d for d, _ in found), default=Fraction(0)) for s, found in sectors.items()}
    off = {s: max((e for _, e in found), default=Fraction(0)) for s, found in sectors.items()}
    drive = controller_point(velocity, layer2)
    v, w = drive.outputs["v"], drive.outputs["w"]
    errors = [output_error(velocity, o, drive, off) for o in velocity.outputs]
    v_error, w_error = (e for e in errors if e is not None)
    half = Fraction(3, 10) / 2
    wheel_error = v_error + half * w_error + 4 * U
    return Worked(
        {"v": v, "w": w, "acting": Fraction(drive.acting), "v_left": v + half * w, "v_right": v - half * w},
        {"v": v_error, "w": w_error, "v_left": wheel_error, "v_right": wheel_error},
        drive,
        strength_error(velocity, off),
    )


def _raws() -> dict[str, Any]:
    """Counts over all raws, with stillness, shared edges and touching among them, lists from none to past the most."""
    system, _, _ = nav()
    rng = np.random.default_rng(20)
    found: dict[str, Any] = {"obstacles.count": rng.integers(0, 19, LANES)}
    found["obstacles.count"][:3] = 0, 16, 18
    for signal in system.inputs:
        if isinstance(signal, ListInput):
            for f in signal.fields:
                drawn = rng.integers(f.raw.lo, f.raw.hi + 1, (LANES, 18))
                special = [f.raw.nearest(Fraction(n)) for n in (0, 30, -30, 90, -90)]
                often = rng.random(drawn.shape) < 0.3
                found[f"obstacles.{f.name}"] = np.where(often, rng.choice(special, drawn.shape), drawn)
        else:
            found[signal.name] = rng.integers(signal.raw.lo, signal.raw.hi + 1, LANES)
    return found


def _values(raws: dict[str, Any]) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """The same inputs as float64 arrays and as rationals."""
    system, _, _ = nav()
    floats: dict[str, Any] = {"obstacles.count": raws["obstacles.count"]}
    exact: list[dict[str, Any]] = [{"obstacles.count": int(n)} for n in raws["obstacles.count"]]
    variables = {}
    for signal in system.inputs:
        if isinstance(signal, ListInput):
            variables |= {f"{signal.name}.{f.name}": f for f in signal.fields}
        else:
            variables[signal.name] = signal
    for name, variable in variables.items():
        floats[name] = dequantise(variable, raws[name])
        for lane, one in enumerate(exact):
            row = raws[name][lane]
            value = variable.raw.value
            one[name] = value(int(row)) if np.ndim(row) == 0 else [value(int(r)) for r in row]
    return floats, exact


@pytest.fixture(scope="module")
def steps() -> tuple[dict[str, Any], list[dict[str, Any]], list[Worked]]:
    """Inputs as float64 arrays and as rationals, and what they come to."""
    floats, exact = _values(_raws())
    return floats, exact, [work_out(one) for one in exact]


Steps = tuple[dict[str, Any], list[dict[str, Any]], list[Worked]]


def test_nav_is_the_papers_step(steps: Steps) -> None:
    """In rationals the system gives exactly what its equations give, for lists of every length."""
    _, points, worked = steps
    for one, expected in zip(points, worked, strict=True):
        assert evaluate_system_exactly(nav()[0], one) == expected.outputs


def test_nav_in_floats(steps: Steps) -> None:
    """In float64 it does so within rounding, and a decision falls otherwise only within rounding of a tie."""
    floats, points, worked = steps
    got = evaluate_system(nav()[0], floats)
    acted: set[int] = set()
    for lane, (one, expected) in enumerate(zip(points, worked, strict=True)):
        acting = int(got.decisions["drive.acting"][lane])
        acted.add(acting)
        if acting != expected.drive.decisions["acting"]:
            assert expected.drive.margins["acting"] <= 2 * expected.drive_error
        for element in range(min(one["obstacles.count"], 16)):
            bearing = one["obstacles.bearing"][element]
            asked = [bearing >= -90, bearing <= -30, bearing >= -30, bearing <= 30, bearing >= 30, bearing <= 90]
            assert [bool(got.decisions[f"test_{k}"][lane, element]) for k in range(1, 7)] == asked
        for name, error in expected.errors.items():
            assert abs(Fraction(float(got.outputs[name][lane])) - expected.outputs[name]) <= error
    assert acted == {1, 2, 3}
