"""What the paper prints about its experiment, and the one table of what it leaves open."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields

PERIOD = 2.0
"""Sampling period T, s (section 4.2)."""

TOP_SPEED = 0.1
"""Maximum velocity of the robots, m/s (section 4.2)."""

TOP_COMMAND = 0.7
"""Upper end of the controller's v, m/s (section 3.2.2)."""


def _open(value: float, unit: str, why: str) -> float:
    """A field of the table: its value, its unit and why it is what it is."""
    default: float = field(default=value, metadata={"unit": unit, "why": why})
    return default


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters:
    """Every number of the robots' world that the paper leaves open. `table` lists them with unit and reason."""

    robot_radius: float = _open(0.2, "m", "R_rob is not printed. nav.fz's R_robot is the same; both robots have it.")
    safe_distance: float = _open(
        0.4,
        "m",
        "D_s is not printed. A robot's diameter; nav.fz's D_safe is the same. Here it serves the recorded DDC only.",
    )
    v_scale: float = _open(
        TOP_SPEED / TOP_COMMAND,
        "1",
        "Commands reach 0.7 m/s, the robots 0.1 m/s. Scaled, not clipped: clipping would leave Z and one speed.",
    )
    w_scale: float = _open(
        1.0,
        "1",
        "No range of w is printed, so nothing asks for a scale: w is turned as commanded. Scaled like v, a robot would "
        "turn by 5 degrees a step at most and could not get out of the way.",
    )
    goal_tolerance: float = _open(
        0.1, "m", "Step 2 names no tolerance, and no robot that moves 0.2 m a step meets a point. Half a step."
    )
    start_heading: float = _open(
        0.0, "deg", "Headings at the start are not printed: off the direction to the goal, left positive."
    )
    sensor_range: float = _open(
        8.0, "m", "Nothing is said of how far robots see. nav.fz's range for distance, more than the field is long."
    )
    time_limit: float = _open(
        120.0, "s", "The paper's curves end near 100 s. A robot that has not arrived by then has failed."
    )


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table."""

    name: str
    value: float
    unit: str
    why: str


def table(parameters: Parameters) -> Iterator[Row]:
    """The open parameters in their order."""
    for f in fields(parameters):
        yield Row(f.name, getattr(parameters, f.name), f.metadata["unit"], f.metadata["why"])


RULES = (
    "Robots decide at the same instants, every T, and hold v and w in between; each arc is driven exactly.",
    "A robot sees another's centre, radius and velocity, without error, and nothing of its goal or its commands.",
    "The velocity that is seen is what the last command gave, along the present heading; at the start it is 0.",
    "A robot has arrived when its path first comes within the goal tolerance, between samples too; there it stays.",
    "Robots that touch do not push each other: the clearance turns negative, and the run has failed.",
    "No tie is broken by hand: the robots are alike, and the controller's own turn to the left parts them.",
)
"""What else the paper leaves open: how it is settled here, in words."""
