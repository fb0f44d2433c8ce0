"""The loop around a controller: timing, arrival, clearance, and what is reported of them."""

from __future__ import annotations

import csv
import io
import math
from itertools import pairwise

import pytest

from firmware_sim.motion import Pose
from firmware_sim.parameters import PERIOD, RULES, Parameters, table
from firmware_sim.paths import RESOLUTION, TOUCH
from firmware_sim.record import as_csv, as_recording
from firmware_sim.report import Episode, describe, deviation, episodes
from firmware_sim.run import Command, Controller, Run, simulate
from firmware_sim.scenario import TWO_ROBOTS, Errand, Scenario
from firmware_sim.sensing import Readings

WORLD = Parameters()
ALONE = Scenario("alone", "One robot alone", (Errand("R1", (0.0, 0.0), (1.0, 0.0)),))


def straight(_: Readings) -> Command:
    """Full speed ahead, whatever there is."""
    return Command(0.7, 0.0, "MG")


def keep_left(readings: Readings) -> Command:
    """To the goal in proportion to its bearing, veering left while anything is within 2 m ahead."""
    if any(o.distance < 2 and abs(o.bearing) < 60 for o in readings.obstacles):
        return Command(0.7, -0.25, "FO")
    return Command(0.7, max(-0.3, min(0.3, math.radians(readings.target_bearing) / PERIOD)), "MG")


def run(controller: Controller, scenario: Scenario = TWO_ROBOTS, world: Parameters = WORLD) -> Run:
    """A run with the same controller in every robot."""
    return simulate(scenario, [controller] * len(scenario.errands), world)


def test_straight_arrival() -> None:
    """At 0.1 m/s a robot comes within 0.1 m of a goal 1 m ahead after 9 s, mid-period, and stays there."""
    track = run(straight, ALONE).tracks[0]
    assert track.arrived is not None
    assert abs(track.arrived - 9.0) <= 2 * TOUCH / 0.1
    assert len(track.samples) == 5
    assert track.at(9.5) == track.at(100.0) == track.legs[-1].end
    assert run(straight, ALONE).clearance is None


def test_head_on_collision_is_seen() -> None:
    """Two robots that ignore each other meet halfway: the clearance is minus two radii, and the run has failed."""
    met = run(straight)
    assert met.clearance is not None
    assert met.clearance.distance <= -2 * WORLD.robot_radius + RESOLUTION
    assert abs(met.clearance.time - 20.0) <= RESOLUTION / 0.2
    assert not met.succeeded
    assert "they touched" in list(describe(met))[-1]


def test_time_limit() -> None:
    """A robot that stands still has not arrived when time is up."""
    stuck = run(lambda _: Command(0.0, 0.1, ""), ALONE, Parameters(time_limit=10.0))
    assert stuck.tracks[0].arrived is None
    assert stuck.duration == 10.0
    assert not stuck.succeeded
    assert list(describe(stuck)) == ["R1: none 0 to 10 s; did not arrive"]


def test_starting_at_the_goal() -> None:
    """A robot that starts within the tolerance has arrived at once, without moving."""
    there = Scenario("there", "There", (Errand("R1", (0.0, 0.0), (0.05, 0.0)),))
    track = run(straight, there).tracks[0]
    assert track.arrived == 0.0
    assert track.legs[0].end == Pose(0.0, 0.0, 0.0)


def test_symmetry() -> None:
    """Alike robots in a scenario that turns into itself by half a turn make paths that do so too."""
    passed = run(keep_left)
    assert passed.succeeded
    one, two = passed.tracks
    for a, b in zip(one.samples, two.samples, strict=True):
        assert math.hypot(a.pose.x + b.pose.x - 4, a.pose.y + b.pose.y - 4) <= 1e-9
        assert a.command.acting == b.command.acting


def test_arrived_robots_stand_in_the_way() -> None:
    """A robot that has arrived is still seen by the others, standing."""
    scenario = Scenario(
        "one_near", "One near", (Errand("R1", (0.0, 0.0), (3.0, 0.0)), Errand("R2", (0.0, 2.0), (0.2, 2.0)))
    )
    seen = [s.readings.obstacles[0] for s in run(straight, scenario).tracks[0].samples]
    standing = [o.speed for o in seen[2:]]
    assert standing == pytest.approx([0.1] * len(standing), abs=2**-50)


def test_readings_follow_the_commands() -> None:
    """The relative speed that is seen is 0 at the start, then what the last commands give."""
    first, second = run(straight).tracks[0].samples[:2]
    assert first.readings.obstacles[0].speed == 0.0
    assert abs(second.readings.obstacles[0].speed - 0.2) <= 2**-50


def test_episodes() -> None:
    """Episodes follow each other without a gap, from 0 to the arrival, and count every sample."""
    track = run(keep_left).tracks[0]
    found = episodes(track)
    assert [e.behavior for e in found[:2]] == ["MG", "FO"]
    assert all(a.behavior != b.behavior for a, b in pairwise(found))
    assert found[0].start == 0.0
    assert all(a.end == b.start for a, b in pairwise(found))
    assert found[-1].end == track.arrived
    assert sum(e.samples for e in found) == len(track.samples)
    assert isinstance(found[0], Episode)


def test_deviation() -> None:
    """A run deviates from itself by nothing, and from a slower one by the way that it is ahead."""
    a, b = run(straight, ALONE), run(lambda _: Command(0.35, 0.0, "MG"), ALONE)
    assert deviation(a, a).position == 0.0
    between = deviation(a, b)
    assert abs(between.position - 0.4) <= 2**-50
    assert (between.v, between.w) == (0.35, 0.0)


def test_csv() -> None:
    """The table has one line a sample and robot, in order of time, and its positions are the run's."""
    passed = run(keep_left)
    text = as_csv(passed, [[0.25] * len(t.samples) for t in passed.tracks])
    rows = list(csv.DictReader(io.StringIO(text)))
    assert len(rows) == sum(len(t.samples) for t in passed.tracks)
    assert [float(r["time_s"]) for r in rows] == sorted(float(r["time_s"]) for r in rows)
    last = [r for r in rows if r["robot"] == "R1"][-1]
    assert abs(float(last["x_m"]) - passed.tracks[0].samples[-1].pose.x) <= 0.5e-6
    assert (last["ddc"], last["acting"]) == ("0.250000", "MG")
    assert "-0.000000" not in text


def test_recording() -> None:
    """A recording holds what the robot read, digit for digit, under the names of nav.fz's signals."""
    track = run(keep_left).tracks[0]
    rows = list(csv.DictReader(io.StringIO(as_recording(track))))
    assert len(rows) == len(track.samples)
    for row, sample in zip(rows, track.samples, strict=True):
        assert float(row["target_bearing"]) == sample.readings.target_bearing
        assert float(row["obstacles.0.distance"]) == sample.readings.obstacles[0].distance


def test_open_parameters_are_explained() -> None:
    """Every open parameter has its unit and its reason."""
    rows = list(table(WORLD))
    assert [r.name for r in rows] == list(Parameters.__dataclass_fields__)
    assert all(r.unit and r.why.endswith(".") for r in rows)
    assert len(RULES) == len(set(RULES))
