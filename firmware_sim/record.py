"""A run as a table of numbers."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence

from firmware_sim.motion import wrapped_degrees
from firmware_sim.paths import Leg
from firmware_sim.run import Run, Sample, Track


def as_csv(run: Run, ddc: Sequence[Sequence[float]]) -> str:
    """One line a sample and robot, ordered by time. ``ddc`` holds the danger of each track's samples."""
    rows: list[tuple[float, int, dict[str, str]]] = []
    for number, (track, dangers) in enumerate(zip(run.tracks, ddc, strict=True)):
        for sample, leg, danger in zip(track.samples, track.legs, dangers, strict=True):
            rows.append((sample.time, number, {"robot": track.errand.robot, **_row(sample, leg, danger)}))
    rows.sort(key=lambda row: row[:2])
    # Who sees nobody has fewer columns; the fullest row names them all.
    columns = max((row for _, _, row in rows), key=len)
    text = io.StringIO()
    writer = csv.DictWriter(text, fieldnames=list(columns), lineterminator="\n")
    writer.writeheader()
    writer.writerows(row for _, _, row in rows)
    return text.getvalue()


def _row(sample: Sample, leg: Leg, danger: float) -> dict[str, str]:
    numbers = {
        "time_s": sample.time,
        "x_m": sample.pose.x,
        "y_m": sample.pose.y,
        "heading_deg": wrapped_degrees(sample.pose.heading),
        "ddc": danger,
        "v_command_mps": sample.command.v,
        "w_command_radps": sample.command.w,
        "v_mps": leg.v,
        "w_radps": leg.w,
        "target_bearing_deg": sample.readings.target_bearing,
    }
    for k, seen in enumerate(sample.readings.obstacles, start=1):
        numbers |= {
            f"obstacle{k}_distance_m": seen.distance,
            f"obstacle{k}_bearing_deg": seen.bearing,
            f"obstacle{k}_speed_mps": seen.speed,
            f"obstacle{k}_radius_m": seen.radius,
        }
    return {"acting": sample.command.acting} | {column: _number(x) for column, x in numbers.items()}


def _number(x: float) -> str:
    # Adding 0.0 turns the -0 that rounding left into 0. A spec without a layer "danger" has no DDC.
    return "" if math.isnan(x) else f"{round(x, 6) + 0.0:.6f}"


def as_recording(track: Track) -> str:
    """What one robot read, a line a period, as `fuzzyc verify --scenario` replays it: signals in declared units."""
    width = max(len(s.readings.obstacles) for s in track.samples)
    fields = ("distance", "bearing", "speed", "radius")
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time", "target_bearing", *(f"obstacles.{k}.{f}" for k in range(width) for f in fields)])
    for sample in track.samples:
        seen = [repr(getattr(o, f)) for o in sample.readings.obstacles for f in fields]
        blank = [""] * (width * len(fields) - len(seen))
        writer.writerow([f"{sample.time:g}", repr(sample.readings.target_bearing), *seen, *blank])
    return text.getvalue()
