"""Arrivals and clearances are found between samples too."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_sim.motion import Pose
from firmware_sim.paths import RESOLUTION, TOUCH, Leg, arrival, least_distance

POSES = st.builds(Pose, st.floats(-1, 1), st.floats(-1, 1), st.floats(-math.pi, math.pi))
LEGS = st.builds(Leg, st.just(4.0), st.floats(0.5, 2), POSES, st.floats(0, 0.7), st.floats(-1, 1))
EAST = Pose(0, 0, 0)


def test_passing_between_samples_is_seen() -> None:
    """Two robots that pass each other halfway through a period are nearest there, at their lateral offset."""
    a = Leg(0.0, 2.0, EAST, 0.1, 0.0)
    b = Leg(0.0, 2.0, Pose(0.2, 0.5, math.pi), 0.1, 0.0)
    distance, when = least_distance(a, b, 0.0, 2.0)
    assert (distance, when) == (0.5, 1.0)


@settings(max_examples=60)
@given(LEGS, LEGS)
def test_least_distance_against_samples(a: Leg, b: Leg) -> None:
    """The least distance is taken at the time it names; no sample is nearer, and none could be much farther."""
    found, when = least_distance(a, b, 4.0, 6.0)
    assert 4.0 <= when <= 6.0
    assert abs(found - a.at(when).distance(b.at(when))) <= 2**-50
    times = np.linspace(4.0, 6.0, 401)
    sampled = min(a.at(float(t)).distance(b.at(float(t))) for t in times)
    missed = (a.v + b.v) * (times[1] - times[0]) / 2
    assert sampled - missed <= found <= sampled + RESOLUTION


def test_standing_still() -> None:
    """Robots that stand have one distance throughout."""
    a, b = Leg(0.0, 0.0, EAST, 0.1, 0.1), Leg(0.0, 2.0, Pose(3, 4, 0), 0.0, 0.0)
    assert least_distance(a, b, 10.0, 12.0)[0] == 5.0


@settings(max_examples=60)
@given(LEGS, POSES, st.floats(0.05, 0.5))
def test_arrival_against_samples(leg: Leg, goal: Pose, tolerance: float) -> None:
    """At the arrival the goal's circle is met, and before it no sample lies inside; without one, none at all."""
    when = arrival(leg, goal, tolerance)
    if when is not None:
        assert leg.at(when).distance(goal) <= tolerance + TOUCH
    last = leg.start + leg.duration if when is None else when
    times = [float(t) for t in np.linspace(leg.start, last, 201) if t < last]
    assert all(leg.at(t).distance(goal) > tolerance - 2**-40 for t in times)


def test_arrival_ahead() -> None:
    """A robot that drives at a goal 0.2 m ahead at 0.1 m/s comes within 0.1 m after one second."""
    when = arrival(Leg(6.0, 2.0, EAST, 0.1, 0.0), Pose(0.2, 0, 0), 0.1)
    assert when is not None
    assert abs(when - 7.0) <= 2 * TOUCH / 0.1


def test_no_arrival() -> None:
    """A robot that passes at twice the tolerance, or stands, does not arrive."""
    assert arrival(Leg(0.0, 2.0, EAST, 0.1, 0.0), Pose(0.1, 0.2, 0), 0.1) is None
    assert arrival(Leg(0.0, 2.0, EAST, 0.0, 0.3), Pose(0.2, 0.0, 0), 0.1) is None
