"""Legs of a path, and questions about them that are answered between samples too.

Both answers are bounds made tight, from how fast a robot moves and how far it can bend off its line in a given time. No
step size decides what is found.
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass
from itertools import pairwise

from firmware_sim.motion import Pose, along_arc

RESOLUTION = 1e-6
"""How closely a least distance is found, m."""

TOUCH = 1e-9
"""How near to a circle a path must come to have met it, m."""


@dataclass(frozen=True, slots=True)
class Leg:
    """From ``start`` (s) for ``duration`` (s) along one arc; from there on the robot stands still."""

    start: float
    duration: float
    pose: Pose
    v: float
    w: float

    def at(self, t: float) -> Pose:
        """The pose at time ``t`` s of the run, not before ``start``."""
        return along_arc(self.pose, self.v, self.w, min(t - self.start, self.duration))

    def motion(self, t: float) -> tuple[tuple[float, float], tuple[float, float], float]:
        """Position, velocity and the size of the acceleration (towards the arc's centre) at time ``t`` s of the run."""
        pose = self.at(t)
        if t > self.start + self.duration:
            return (pose.x, pose.y), (0.0, 0.0), 0.0
        velocity = self.v * math.cos(pose.heading), self.v * math.sin(pose.heading)
        return (pose.x, pose.y), velocity, abs(self.v * self.w)

    @property
    def end(self) -> Pose:
        return along_arc(self.pose, self.v, self.w, self.duration)


def arrival(leg: Leg, goal: Pose, tolerance: float) -> float | None:
    """When (s of the run) a leg first comes within ``tolerance`` of ``goal``; None if it does not."""
    speed = abs(leg.v)
    t = leg.start
    while t <= leg.start + leg.duration:
        away = leg.at(t).distance(goal) - tolerance
        if away <= TOUCH:
            return t
        if speed == 0:
            return None
        t += away / speed
    return None


def least_distance(a: Leg, b: Leg, lo: float, hi: float) -> tuple[float, float]:
    """The least distance of two centres over times [lo, hi], to ``RESOLUTION`` from above, and when.

    Branch and bound. Around the middle m of a piece, the offset between the two is ``p + q (t - m)`` with its velocity
    q there, to within ``bend (t - m)^2 / 2``: what either turns out of its line. So over the piece they are no nearer
    than that straight segment comes to the origin, less the bend.
    """
    stops = sorted({lo, hi} | {leg.start + leg.duration for leg in (a, b) if lo < leg.start + leg.duration < hi})
    pieces = [_Piece.over(a, b, s, t) for s, t in pairwise(stops)]
    best = min((a.at(t).distance(b.at(t)), t) for t in stops)
    heapq.heapify(pieces)
    while pieces:
        piece = heapq.heappop(pieces)
        best = min(best, (piece.at_middle, (piece.lo + piece.hi) / 2))
        if piece.bound >= best[0] - RESOLUTION:
            break
        middle = (piece.lo + piece.hi) / 2
        heapq.heappush(pieces, _Piece.over(a, b, piece.lo, middle))
        heapq.heappush(pieces, _Piece.over(a, b, middle, piece.hi))
    return best


@dataclass(frozen=True, slots=True, order=True)
class _Piece:
    bound: float
    lo: float
    hi: float
    at_middle: float

    @staticmethod
    def over(a: Leg, b: Leg, lo: float, hi: float) -> _Piece:
        middle, half = (lo + hi) / 2, (hi - lo) / 2
        (ax, ay), (avx, avy), a_bend = a.motion(middle)
        (bx, by), (bvx, bvy), b_bend = b.motion(middle)
        px, py, qx, qy = bx - ax, by - ay, bvx - avx, bvy - avy
        speed2 = qx * qx + qy * qy
        nearest = max(-half, min(half, -(px * qx + py * qy) / speed2)) if speed2 else 0.0
        straight = math.hypot(px + qx * nearest, py + qy * nearest)
        return _Piece(straight - (a_bend + b_bend) * half * half / 2, lo, hi, math.hypot(px, py))
