"""The paper's Figures 6 to 9, drawn from a run.

Needs matplotlib (the extra ``sim``). Figures are made without pyplot and from settings of their own, so that a run
gives the same picture whatever the user's configuration.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch
from matplotlib.ticker import MultipleLocator

from firmware_sim.motion import Pose
from firmware_sim.parameters import PERIOD
from firmware_sim.paths import Leg
from firmware_sim.report import episodes
from firmware_sim.run import Run, Track

INK, FAINT = "#33373d", "#d9dce1"
ROBOTS = ("#1f5fa8", "#2d7a4b", "#7a4fa3", "#a8431f")
BEHAVIORS = ("#e9f1fa", "#fad3ad", "#f6f0c9", "#e6efe0")
"""Shades by order of first appearance: the behavior that acts first is the palest."""

STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 10.0,
    "axes.titlesize": 11.0,
    "axes.titlelocation": "left",
    "axes.edgecolor": "#9aa0a8",
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": FAINT,
    "grid.linewidth": 0.6,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "lines.linewidth": 1.8,
    "lines.solid_capstyle": "round",
}


def draw(run: Run, ddc: Sequence[Sequence[float]], beside: Run | None, labels: tuple[str, str]) -> dict[str, bytes]:
    """File name to PNG. ``beside`` is drawn dashed where there is room; ``labels`` name the two runs."""
    return {
        "fig6_trajectories.png": _png(4.1, lambda f: _trajectories(f, run)),
        "fig7_danger_and_bearing.png": _png(4.8, lambda f: _danger(f, run, ddc)),
        "fig8_velocities.png": _png(4.8, lambda f: _velocities(f, run, beside, labels)),
        "fig9_displacement.png": _png(4.8, lambda f: _displacement(f, run, beside, labels)),
    }


def _png(height: float, paint: Callable[[Figure], None]) -> bytes:
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(STYLE)
        figure = Figure(figsize=(8.0, height), dpi=120, layout="constrained")
        paint(figure)
        content = io.BytesIO()
        # No software version, no date: equal runs are equal files.
        figure.savefig(content, format="png", metadata={"Software": None})
        return content.getvalue()


# --- Figure 6 --------------------------------------------------------------------------------


def _trajectories(figure: Figure, run: Run) -> None:
    axes = figure.add_subplot()
    shades = _shades(run)
    radius, tolerance = run.parameters.robot_radius, run.parameters.goal_tolerance
    for track, color in zip(run.tracks, ROBOTS, strict=False):
        poses = [track.at(t) for t in _fine(track)]
        axes.plot([p.x for p in poses], [p.y for p in poses], color=color, zorder=3)
        for sample in track.samples:
            _circle(axes, sample.pose, radius, 1, facecolor=shades[sample.command.acting], edgecolor=color, alpha=0.55)
        start, goal = Pose(*track.errand.start, 0.0), Pose(*track.errand.goal, 0.0)
        axes.plot(start.x, start.y, "o", color=color, markersize=6, zorder=4)
        _circle(axes, goal, tolerance, 4, fill=False, edgecolor=color, linestyle=":", linewidth=1.4)
        far = max(poses, key=lambda p: abs(p.y - start.y))
        off = math.copysign(radius + 0.12, far.y - start.y)
        axes.text(far.x, far.y + off, track.errand.robot, color=color, ha="center", va="center", weight="bold")
    if run.clearance is not None:
        a, b = (t.at(run.clearance.time) for t in run.tracks if t.errand.robot in run.clearance.robots)
        for pose in (a, b):
            _circle(axes, pose, radius, 5, fill=False, edgecolor=INK, linewidth=1.2)
        axes.plot([a.x, b.x], [a.y, b.y], color=INK, linewidth=1, linestyle="--", zorder=5)
        nearest = f"nearest at {run.clearance.time:.1f} s: {run.clearance.distance:.2f} m between them"
        axes.text(0.99, 0.04, nearest, transform=axes.transAxes, ha="right")
    axes.set_aspect("equal")
    axes.margins(0.02, 0.13)
    axes.xaxis.set_major_locator(MultipleLocator(0.5))
    axes.yaxis.set_major_locator(MultipleLocator(0.5))
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.set_title(f"{run.scenario.title}: where they are every {PERIOD:g} s, and how they went")
    marks = [
        Line2D([], [], color=INK, marker="o", linestyle="", label="start"),
        Line2D([], [], color=INK, marker="o", linestyle="", markersize=10, fillstyle="none", label="goal"),
    ]
    axes.legend(handles=[*_behavior_patches(shades), *marks], loc="upper left", ncols=2, fontsize=9)


def _circle(axes: Any, centre: Pose, radius: float, zorder: int, **style: Any) -> None:
    axes.add_patch(Circle((centre.x, centre.y), radius, zorder=zorder, **style))


# --- Figures 7 to 9: the first robot over time -----------------------------------------------


def _danger(figure: Figure, run: Run, ddc: Sequence[Sequence[float]]) -> None:
    track, color = run.tracks[0], ROBOTS[0]
    times = [s.time for s in track.samples]
    above, below = _over_time(figure, run, track, f"Danger and target of {track.errand.robot}")
    above.plot(times, ddc[0], color=color, marker=".")
    above.set_ylabel("DDC")
    above.set_ylim(-0.03, 1.03)
    below.plot(times, [s.readings.target_bearing for s in track.samples], color=color, marker=".")
    below.set_ylabel("target bearing [deg]\nleft < 0 < right")


def _velocities(figure: Figure, run: Run, beside: Run | None, labels: tuple[str, str]) -> None:
    track = run.tracks[0]
    above, below = _over_time(figure, run, track, f"Velocity and turn rate of {track.errand.robot}, as driven")
    panels: tuple[tuple[Any, str, Callable[[Leg], float]], ...] = (
        (above, "v [m/s]", lambda leg: leg.v),
        (below, "w [rad/s]\nleft < 0 < right", lambda leg: leg.w),
    )
    for axes, name, value in panels:
        for shown, label, style in _both(run, beside, labels):
            legs = shown.tracks[0].legs
            edges = [leg.start for leg in legs] + [legs[-1].start + legs[-1].duration]
            axes.stairs([value(leg) for leg in legs], edges, baseline=None, label=label, linewidth=1.8, **style)
        axes.set_ylabel(name)
    above.set_ylim(bottom=0)
    _run_legend(above, beside)


def _displacement(figure: Figure, run: Run, beside: Run | None, labels: tuple[str, str]) -> None:
    track = run.tracks[0]
    x0, y0 = track.errand.start
    above, below = _over_time(figure, run, track, f"Displacement of {track.errand.robot} from its start")
    for shown, label, style in _both(run, beside, labels):
        times = _fine(shown.tracks[0])
        poses = [shown.tracks[0].at(t) for t in times]
        above.plot(times, [math.hypot(p.x - x0, p.y - y0) for p in poses], label=label, **style)
        below.plot(times, [p.y - y0 for p in poses], label=label, **style)
    above.set_ylabel("distance from start [m]")
    below.set_ylabel("sideways, y [m]")
    _run_legend(above, beside)


def _over_time(figure: Figure, run: Run, track: Track, title: str) -> tuple[Any, Any]:
    """Two panels over one time axis, the acting behavior shaded behind both."""
    above, below = figure.subplots(2, 1, sharex=True)
    shades = _shades(run)
    for axes in (above, below):
        for episode in episodes(track):
            axes.axvspan(episode.start, episode.end, color=shades[episode.behavior], linewidth=0, zorder=0)
    above.set_title(title)
    below.set_xlabel("time [s]")
    below.set_xlim(0, track.legs[-1].start + track.legs[-1].duration)
    figure.legend(handles=_behavior_patches(shades), loc="outside upper right", ncols=len(shades), fontsize=9)
    return above, below


def _both(run: Run, beside: Run | None, labels: tuple[str, str]) -> Iterator[tuple[Run, str, dict[str, Any]]]:
    yield run, labels[0], {"color": ROBOTS[0]}
    if beside is not None:
        yield beside, labels[1], {"color": INK, "linestyle": (0, (2, 2))}


def _run_legend(axes: Any, beside: Run | None) -> None:
    if beside is not None:
        axes.legend(loc="lower right", ncols=2)


# --- what all share --------------------------------------------------------------------------


def _shades(run: Run) -> dict[str, str]:
    """A colour for each behavior that acted, by order of appearance."""
    seen = dict.fromkeys(s.command.acting for track in run.tracks for s in track.samples)
    return {name: BEHAVIORS[i % len(BEHAVIORS)] for i, name in enumerate(seen)}


def _behavior_patches(shades: dict[str, str]) -> list[Patch]:
    return [
        Patch(facecolor=shade, edgecolor="#9aa0a8", linewidth=0.6, label=f"{name} acts" if name else "nothing acts")
        for name, shade in shades.items()
    ]


def _fine(track: Track) -> list[float]:
    """Times close enough for arcs to look round."""
    last = track.legs[-1]
    return [float(t) for t in np.linspace(0.0, last.start + last.duration, 20 * len(track.legs) + 1)]
