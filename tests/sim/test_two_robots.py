"""The paper's two robots under the generated C, with the exact meaning beside it: what a user's own tests would ask."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firmware_sim.controllers import FIELDS, Brain, Unfit
from firmware_sim.parameters import Parameters
from firmware_sim.pictures import draw
from firmware_sim.record import as_csv, as_recording
from firmware_sim.report import episodes
from firmware_sim.run import Run, Track, simulate
from firmware_sim.scenario import TWO_ROBOTS, Errand, Scenario
from firmware_sim.sensing import Readings
from firmware_sim.trial import Trial, carry_out
from fuzzyspec.api import Spec, load
from fuzzyspec.cli.main import main
from fuzzyspec.exact import dequantise
from fuzzyspec.fixed import run as run_fixed
from fuzzyspec.model.system import ListInput
from fuzzyspec.model.variable import Variable

NAV = Path(__file__).parents[2] / "examples" / "nav.fz"


@pytest.fixture(scope="module")
def spec() -> Spec:
    """nav.fz, compiled once."""
    return load(NAV)


@pytest.fixture(scope="module")
def trial(spec: Spec) -> Trial:
    """The two robots, under the C and under the exact meaning."""
    return carry_out(TWO_ROBOTS, spec, "both")


def tracks(trial: Trial) -> list[Track]:
    """Every robot of both runs."""
    return [track for outcome in trial.outcomes for track in outcome.run.tracks]


def test_both_arrive_and_nobody_touches(trial: Trial) -> None:
    """Under either meaning both robots arrive, and their rims stay apart throughout."""
    assert trial.succeeded
    for outcome in trial.outcomes:
        assert outcome.run.clearance is not None
        assert outcome.run.clearance.distance > 0


def test_behaviors(trial: Trial) -> None:
    """MG acts first and last, and in between FO or AO act for at least three periods on end."""
    for track in tracks(trial):
        acted = episodes(track)
        assert (acted[0].behavior, acted[-1].behavior) == ("MG", "MG")
        assert max(e.samples for e in acted if e.behavior in {"FO", "AO"}) >= 3


def test_the_robots_are_treated_alike(trial: Trial) -> None:
    """The scenario turns into itself by half a turn, and so do the paths: no robot is favoured."""
    for outcome in trial.outcomes:
        one, two = outcome.run.tracks
        assert [s.command.acting for s in one.samples] == [s.command.acting for s in two.samples]
        assert one.arrived == pytest.approx(two.arrived)


def stacked(track: Track) -> dict[str, Any]:
    """A robot's readings as the system's signals, one row a period."""
    width = max(len(s.readings.obstacles) for s in track.samples)
    signals = {"target_bearing": np.array([s.readings.target_bearing for s in track.samples])}
    signals["obstacles.count"] = np.array([len(s.readings.obstacles) for s in track.samples])
    for field in FIELDS:
        rows = [[getattr(o, field) for o in s.readings.obstacles] for s in track.samples]
        signals[f"obstacles.{field}"] = np.array([r + [0.0] * (width - len(r)) for r in rows])
    return signals


def crowd(robots: int) -> Scenario:
    """Robots on a ring that all want to go to the opposite side."""
    angles = [2 * np.pi * k / robots for k in range(robots)]
    places = [(float(3 * np.cos(a)), float(3 * np.sin(a))) for a in angles]
    return Scenario("ring", "Ring", tuple(Errand(f"R{k}", (x, y), (-x, -y)) for k, (x, y) in enumerate(places)))


@pytest.fixture(scope="module", params=[2, 5], ids=["two_robots", "ring_of_five"])
def run(request: pytest.FixtureRequest, spec: Spec) -> Run:
    """Scenarios under the C; in the ring lists are longer, and robots come from all sides."""
    scenario = TWO_ROBOTS if request.param == 2 else crowd(request.param)
    return simulate(scenario, [Brain(spec, "c") for _ in scenario.errands], Parameters(time_limit=60.0))


def variables_of(spec: Spec) -> dict[str, Variable]:
    """nav's inputs by signal name."""
    bearing, obstacles = spec.systems["nav"].inputs
    assert isinstance(bearing, Variable)
    assert isinstance(obstacles, ListInput)
    return {"target_bearing": bearing} | {f"obstacles.{f.name}": f for f in obstacles.fields}


def raws_of(spec: Spec, signals: dict[str, Any]) -> dict[str, Any]:
    """The nearest raws, by exact arithmetic."""

    def nearest(variable: Variable, values: Any) -> Any:
        return np.vectorize(lambda x: variable.raw.nearest(Fraction(x)), otypes=[int])(values)

    variables = variables_of(spec)
    return {k: nearest(variables[k], a) if k in variables else a for k, a in signals.items()}


def values_of(spec: Spec, raws: dict[str, Any]) -> dict[str, Any]:
    """The values that the raws stand for."""
    variables = variables_of(spec)
    return {k: dequantise(variables[k], a) if k in variables else a for k, a in raws.items()}


def test_c_is_the_integer_program_and_within_its_bounds(spec: Spec, run: Run) -> None:
    """At every reading of a run the C is the integer program, and within the certified error along its decisions."""
    for track in run.tracks:
        raws = raws_of(spec, stacked(track))
        c = spec.native("nav", raws, raw=True)
        fixed = run_fixed(spec.lowered.program, "nav", raws, record=True)
        assert all(np.array_equal(c.raws[k], fixed.outputs[k]) for k in c.raws)
        assert np.array_equal(c.status, fixed.status)
        exact = spec.exact("nav", values_of(spec, raws), decisions=fixed.decisions)
        for bound in spec.certificate("nav").outputs:
            assert bound.error is not None, bound.reason
            worst = np.max(np.abs(c.outputs[bound.output] - exact.outputs[bound.output]))
            assert worst <= float(bound.error), bound.output


def test_replay_of_a_recording(spec: Spec, trial: Trial, tmp_path: Path) -> None:
    """What a robot read, replayed by verify: C, integer program and exact meaning hold together at every row."""
    recording = tmp_path / "readings.csv"
    recording.write_text(as_recording(trial.main.run.tracks[0]), encoding="utf-8")
    report = spec.verify(scenario=recording, sanitize=False)
    assert report.ok


def test_nobody_in_sight(spec: Spec) -> None:
    """With an empty list both meanings drive straight at a target ahead, at full speed, MG acting."""
    for meaning in ("c", "exact"):
        command = Brain(spec, meaning)(Readings(0.0, ()))
        assert command.acting == "MG"
        assert abs(command.v - 0.7) <= float(spec.certificate("nav").output("v").error or 0)
        assert abs(command.w) <= float(spec.certificate("nav").output("w").error or 0)


def test_deviation_is_small(trial: Trial) -> None:
    """The two runs take the same decisions, so their commands differ by little more than the certified errors."""
    assert trial.apart is not None
    assert trial.beside is not None
    for a, b in zip(trial.main.run.tracks, trial.beside.run.tracks, strict=True):
        assert [s.command.acting for s in a.samples] == [s.command.acting for s in b.samples]


def test_other_specs_are_refused() -> None:
    """A spec without the robots' interface is refused, saying what is wanted."""
    with pytest.raises(Unfit, match="0 systems"):
        Brain(load(NAV.with_name("tipper.fz")), "exact")
    with pytest.raises(Unfit, match=r"obstacles\.bearing.*target_bearing"):
        Brain(load(NAV.with_name("temperature.fz")), "exact")


def test_command(trial: Trial, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The command prints what happened and writes pictures and numbers, the same bytes as any other run of it."""
    assert main(["sim", "two_robots", "-o", str(tmp_path)]) == 0
    written = {f.name: f.read_bytes() for f in tmp_path.iterdir()}
    assert trial.beside is not None
    again = draw(trial.main.run, trial.main.ddc, trial.beside.run, ("generated C", "exact meaning"))
    assert [name[:4] for name in again] == ["fig6", "fig7", "fig8", "fig9"]
    assert again == {name: written[name] for name in written if name.endswith(".png")}
    assert all(picture.startswith(b"\x89PNG") for picture in again.values())
    assert written["run_c.csv"] == as_csv(trial.main.run, trial.main.ddc).encode()
    said = capsys.readouterr().out
    for word in ("R1: MG 0 to", "smallest clearance:", "arrived at", "exact meaning in the loop", "apart at most"):
        assert word in said


def test_command_as_data(capsys: pytest.CaptureFixture[str]) -> None:
    """``--format json`` gives the outcome as data, and one meaning alone can be asked for."""
    assert main(["sim", "two_robots", "--controller", "exact", "--format", "json", "--spec", str(NAV)]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["succeeded"] is True
    assert [run["controller"] for run in data["runs"]] == ["exact"]
    assert {robot["name"] for robot in data["runs"][0]["robots"]} == {"R1", "R2"}
    assert data["files"] == []


def test_command_refuses(capsys: pytest.CaptureFixture[str]) -> None:
    """A spec that is not for robots ends in one line and status 2."""
    assert main(["sim", "two_robots", "--spec", str(NAV.with_name("tipper.fz"))]) == 2
    assert capsys.readouterr().err.count("\n") == 1
