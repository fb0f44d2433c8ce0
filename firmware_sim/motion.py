"""Differential drive on the exact arc.

World headings run counter-clockwise from the x axis, as usual. The paper's equation (1), w = (v_L - v_R) / D, makes w
positive for a right turn, which is clockwise: the heading's rate is -w. That minus sign stands in `along_arc` and
nowhere else. (The paper's (2) prints cos where sin belongs, and its (4) moves by the arc's length instead of its
chord.)
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Pose:
    """Position in m and heading in rad, counter-clockwise; the heading is not wrapped."""

    x: float
    y: float
    heading: float

    def distance(self, other: Pose) -> float:
        return math.hypot(other.x - self.x, other.y - self.y)

    def direction(self, other: Pose) -> float:
        """Direction from here to there in the world's frame, rad; 0 where they coincide."""
        return math.atan2(other.y - self.y, other.x - self.x)


def along_arc(pose: Pose, v: float, w: float, t: float) -> Pose:
    """Where a robot is after ``t`` s at ``v`` m/s and ``w`` rad/s (``w`` > 0 turns right).

    The chord of an arc that turns by phi is ``2 R sin(phi/2)`` long, ``R = v t / phi``, and points along the heading
    halfway through; written with sin(x)/x so that straight motion is no special case.
    """
    turn = -w * t
    chord = v * t * _sinc(turn / 2)
    halfway = pose.heading + turn / 2
    return Pose(pose.x + chord * math.cos(halfway), pose.y + chord * math.sin(halfway), pose.heading + turn)


def _sinc(x: float) -> float:
    return math.sin(x) / x if x else 1.0


def wrapped_degrees(angle: float) -> float:
    """An angle in rad as degrees in [-180, 180)."""
    return (math.degrees(angle) + 180.0) % 360.0 - 180.0
