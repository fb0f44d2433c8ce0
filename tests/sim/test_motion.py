"""Properties of motion on arcs."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from firmware_sim.motion import Pose, along_arc, wrapped_degrees

POSES = st.builds(Pose, st.floats(-8, 8), st.floats(-8, 8), st.floats(-math.pi, math.pi))
SPEEDS = st.floats(0, 0.7)
TURNS = st.floats(-1, 1)
TIMES = st.floats(0, 4)

ULPS = 64 * 2.0**-52
"""Rounding of a few operations on numbers near 8; each property says how much of it can come up."""


def same(a: Pose, b: Pose) -> bool:
    """Whether two poses differ by rounding at most."""
    return a.distance(b) <= 8 * ULPS and abs(a.heading - b.heading) <= 8 * ULPS


@given(POSES, SPEEDS, TURNS, TIMES, TIMES)
def test_arcs_compose(pose: Pose, v: float, w: float, s: float, t: float) -> None:
    """Driving an arc for s and then for t ends where driving it for s + t ends."""
    assert same(along_arc(along_arc(pose, v, w, s), v, w, t), along_arc(pose, v, w, s + t))


@given(POSES, SPEEDS, TURNS, TIMES)
def test_there_and_back(pose: Pose, v: float, w: float, t: float) -> None:
    """Driving an arc backwards in time returns to its start."""
    assert same(along_arc(along_arc(pose, v, w, t), v, w, -t), pose)


@given(POSES, SPEEDS, TIMES, st.floats(0, 1e-3))
def test_straight_limit(pose: Pose, v: float, t: float, w: float) -> None:
    """As w goes to 0 the arc goes to the straight line: off by at most v w t^2 / 2, and not at all at w = 0."""
    straight = Pose(pose.x + v * t * math.cos(pose.heading), pose.y + v * t * math.sin(pose.heading), pose.heading)
    assert along_arc(pose, v, w, t).distance(straight) <= v * w * t * t / 2 + 8 * ULPS
    assert same(along_arc(pose, v, 0.0, t), straight)


@given(POSES, SPEEDS, st.floats(0.05, 1), TIMES)
def test_chord(pose: Pose, v: float, w: float, t: float) -> None:
    """The chord of an arc that turns by phi is 2 R sin(phi / 2) long, not phi R as the paper's (4) has it."""
    radius, phi = v / w, w * t
    assert abs(pose.distance(along_arc(pose, v, w, t)) - 2 * radius * abs(math.sin(phi / 2))) <= 20 * ULPS


@given(POSES, st.floats(0.1, 0.7), st.floats(0.05, 1), st.floats(0.1, 2))
def test_positive_w_turns_right(pose: Pose, v: float, w: float, t: float) -> None:
    """With w > 0 the robot ends to the right of its heading, and its heading has gone down by w t."""
    end = along_arc(pose, v, w, t)
    leftwards = -math.sin(pose.heading) * (end.x - pose.x) + math.cos(pose.heading) * (end.y - pose.y)
    assert leftwards < 0
    assert abs(pose.heading - end.heading - w * t) <= ULPS


def test_right_turn_quarter() -> None:
    """Eastbound, a quarter turn at w > 0 about a circle of 1 m ends 1 m on, 1 m to the south, southbound."""
    end = along_arc(Pose(0, 0, 0), math.pi / 4, math.pi / 4, 2)
    assert same(end, Pose(1, -1, -math.pi / 2))


@given(st.floats(-100, 100))
def test_wrapping(angle: float) -> None:
    """A wrapped angle lies in [-180, 180) and differs by whole turns."""
    wrapped = wrapped_degrees(angle)
    assert -180 <= wrapped < 180
    assert abs(math.sin(math.radians(wrapped)) - math.sin(angle)) <= 1000 * ULPS
    assert abs(math.cos(math.radians(wrapped)) - math.cos(angle)) <= 1000 * ULPS
