"""A run in words."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

from firmware_sim.run import Run, Track


@dataclass(frozen=True, slots=True)
class Episode:
    """One behavior acting without a break, from ``start`` to ``end`` s; ``samples`` decisions."""

    behavior: str
    start: float
    end: float
    samples: int


def episodes(track: Track) -> tuple[Episode, ...]:
    """When each behavior acted, in order."""
    found: list[Episode] = []
    steps = zip(track.samples, track.legs, strict=True)
    for behavior, group in groupby(steps, key=lambda step: step[0].command.acting):
        members = list(group)
        last = members[-1][1]
        found.append(Episode(behavior, members[0][0].time, last.start + last.duration, len(members)))
    return tuple(found)


@dataclass(frozen=True, slots=True)
class Deviation:
    """How far two runs of one scenario are apart at most: positions (m), v (m/s) and w (rad/s) as commanded."""

    position: float
    v: float
    w: float


def deviation(a: Run, b: Run) -> Deviation:
    """Compare two runs sample by sample, over the samples that both have."""
    pairs = [
        (x, y)
        for track_a, track_b in zip(a.tracks, b.tracks, strict=True)
        for x, y in zip(track_a.samples, track_b.samples, strict=False)
    ]
    return Deviation(
        position=max(x.pose.distance(y.pose) for x, y in pairs),
        v=max(abs(x.command.v - y.command.v) for x, y in pairs),
        w=max(abs(x.command.w - y.command.w) for x, y in pairs),
    )


def describe(run: Run) -> Iterator[str]:
    """Lines: each robot's behaviors and arrival, then the smallest clearance."""
    for track in run.tracks:
        acted = ", ".join(f"{e.behavior or 'none'} {e.start:g} to {e.end:.4g} s" for e in episodes(track))
        outcome = "did not arrive" if track.arrived is None else f"arrived at {track.arrived:.1f} s"
        yield f"{track.errand.robot}: {acted}; {outcome}"
    if run.clearance is not None:
        touched = "" if run.clearance.distance > 0 else ": they touched"
        yield (
            f"smallest clearance: {run.clearance.distance:.3f} m at {run.clearance.time:.1f} s, "
            f"{' and '.join(run.clearance.robots)}{touched}"
        )
