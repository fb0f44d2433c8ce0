"""The loop: sense, decide, move."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Protocol

from firmware_sim.motion import Pose
from firmware_sim.parameters import PERIOD, Parameters
from firmware_sim.paths import Leg, arrival, least_distance
from firmware_sim.scenario import Errand, Scenario
from firmware_sim.sensing import Body, Readings, sense


@dataclass(frozen=True, slots=True)
class Command:
    """What a controller answers: v in m/s, w in rad/s (> 0 turns right), the acting behavior's name ("" for none)."""

    v: float
    w: float
    acting: str


class Controller(Protocol):
    """One robot's controller, called once a period; it may keep a state between calls."""

    def __call__(self, readings: Readings, /) -> Command: ...


@dataclass(frozen=True, slots=True)
class Sample:
    """One period of one robot: when (s), where, what it read, what it was told. The leg is driven from here."""

    time: float
    pose: Pose
    readings: Readings
    command: Command


@dataclass(frozen=True, slots=True)
class Track:
    """One robot's run. ``legs`` holds one leg a sample; ``arrived`` is None if it never came to its goal."""

    errand: Errand
    samples: tuple[Sample, ...]
    legs: tuple[Leg, ...]
    arrived: float | None

    def at(self, t: float) -> Pose:
        """The pose at any time from 0 on; where it stopped, it stays."""
        return self.legs[min(int(t / PERIOD), len(self.legs) - 1)].at(t)


@dataclass(frozen=True, slots=True)
class Clearance:
    """The smallest distance of two robots' rims over the whole run, m; when (s); whose."""

    distance: float
    time: float
    robots: tuple[str, str]


@dataclass(frozen=True, slots=True)
class Run:
    """What happened. ``clearance`` is None for a robot alone."""

    scenario: Scenario
    parameters: Parameters
    tracks: tuple[Track, ...]
    duration: float
    clearance: Clearance | None

    @property
    def succeeded(self) -> bool:
        """Everybody arrived and nobody touched."""
        apart = self.clearance is None or self.clearance.distance > 0
        return apart and all(t.arrived is not None for t in self.tracks)


class _Robot:
    """A robot on its way; everything that changes during a run is here."""

    def __init__(self, errand: Errand, controller: Controller, parameters: Parameters) -> None:
        start, self.goal = Pose(*errand.start, 0.0), Pose(*errand.goal, 0.0)
        heading = start.direction(self.goal) + math.radians(parameters.start_heading)
        self.errand, self.controller, self.parameters = errand, controller, parameters
        self.body = Body(Pose(start.x, start.y, heading), parameters.robot_radius, 0.0)
        self.samples: list[Sample] = []
        self.legs: list[Leg] = []
        self.arrived: float | None = None

    def decide(self, time: float, others: Sequence[Body]) -> Sample:
        readings = sense(self.body, self.goal, others, self.parameters.sensor_range)
        return Sample(time, self.body.pose, readings, self.controller(readings))

    def move(self, sample: Sample) -> None:
        v, w = sample.command.v * self.parameters.v_scale, sample.command.w * self.parameters.w_scale
        leg = Leg(sample.time, PERIOD, sample.pose, v, w)
        self.arrived = arrival(leg, self.goal, self.parameters.goal_tolerance)
        if self.arrived is not None:
            leg = Leg(sample.time, self.arrived - sample.time, sample.pose, v, w)
        self.samples.append(sample)
        self.legs.append(leg)
        self.body = Body(leg.end, self.body.radius, v if self.arrived is None else 0.0)


def simulate(scenario: Scenario, controllers: Sequence[Controller], parameters: Parameters) -> Run:
    """Run a scenario with one controller a robot (in the errands' order) until all have arrived or time is up."""
    robots = [_Robot(e, c, parameters) for e, c in zip(scenario.errands, controllers, strict=True)]
    periods = 0
    while periods * PERIOD < parameters.time_limit and any(r.arrived is None for r in robots):
        bodies = [r.body for r in robots]
        decided = [
            (robot, robot.decide(periods * PERIOD, bodies[:i] + bodies[i + 1 :]))
            for i, robot in enumerate(robots)
            if robot.arrived is None
        ]
        for robot, sample in decided:
            robot.move(sample)
        periods += 1
    tracks = tuple(Track(r.errand, tuple(r.samples), tuple(r.legs), r.arrived) for r in robots)
    return Run(scenario, parameters, tracks, periods * PERIOD, _clearance(tracks, periods, parameters))


def _clearance(tracks: Sequence[Track], periods: int, parameters: Parameters) -> Clearance | None:
    found: list[Clearance] = []
    for a, b in combinations(tracks, 2):
        for k in range(periods):
            leg_a, leg_b = a.legs[min(k, len(a.legs) - 1)], b.legs[min(k, len(b.legs) - 1)]
            distance, time = least_distance(leg_a, leg_b, k * PERIOD, (k + 1) * PERIOD)
            found.append(Clearance(distance - 2 * parameters.robot_radius, time, (a.errand.robot, b.errand.robot)))
    return min(found, key=lambda c: c.distance, default=None)
