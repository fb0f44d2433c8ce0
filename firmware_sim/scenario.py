"""Who starts where and wants to go where."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Errand:
    """A robot's name, start and goal (x, y in m)."""

    robot: str
    start: tuple[float, float]
    goal: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Scenario:
    name: str
    title: str
    errands: tuple[Errand, ...]


TWO_ROBOTS = Scenario(
    name="two_robots",
    title="Two robots swap places",
    errands=(Errand("R1", (0.0, 2.0), (4.0, 2.0)), Errand("R2", (4.0, 2.0), (0.0, 2.0))),
)
"""Section 4.2 of the paper: head-on, 4 m apart."""

SCENARIOS = {s.name: s for s in (TWO_ROBOTS,)}
