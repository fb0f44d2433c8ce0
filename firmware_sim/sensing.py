"""What one robot can sense of its goal and of the others, in the paper's conventions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from firmware_sim.motion import Pose, wrapped_degrees


@dataclass(frozen=True, slots=True)
class Body:
    """A circle that moves: pose, radius in m, speed along its heading in m/s."""

    pose: Pose
    radius: float
    speed: float

    @property
    def velocity(self) -> tuple[float, float]:
        return self.speed * math.cos(self.pose.heading), self.speed * math.sin(self.pose.heading)


@dataclass(frozen=True, slots=True)
class Sighting:
    """Another body: distance of the centres (m), azimuth (deg, left negative), relative speed (m/s), radius (m)."""

    distance: float
    bearing: float
    speed: float
    radius: float


@dataclass(frozen=True, slots=True)
class Readings:
    """All that a controller is given."""

    target_bearing: float
    obstacles: tuple[Sighting, ...]


def azimuth(own: Pose, other: Pose) -> float:
    """Definitions 5 and 6: own heading minus the direction to the other, deg in [-180, 180); left is negative."""
    return wrapped_degrees(own.heading - own.direction(other))


def sight(own: Body, other: Body) -> Sighting:
    """One body as another sees it; ``speed`` is |V_RO|, whatever its direction."""
    return Sighting(
        distance=own.pose.distance(other.pose),
        bearing=azimuth(own.pose, other.pose),
        speed=math.dist(own.velocity, other.velocity),
        radius=other.radius,
    )


def sense(own: Body, goal: Pose, others: Sequence[Body], sensor_range: float) -> Readings:
    """The goal's azimuth and every body within range, in the order given."""
    sightings = (sight(own, other) for other in others)
    return Readings(azimuth(own.pose, goal), tuple(s for s in sightings if s.distance <= sensor_range))
