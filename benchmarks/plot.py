"""Cost against error, one point a workload and kind."""

from __future__ import annotations

import io
from typing import Any, Literal

from benchmarks.results import Results

_COLOURS = {"fuzzyc": "#1b7f4d", "lookup table": "#c05a1a", "float C": "#3b5fa8", "fuzzylite": "#7a7a7a"}
_SHAPES = {"W1": "o", "W2": "s", "W3": "^", "W3s": "D"}
_LABELS = {
    "fuzzyc": "fuzzyc, bar up to its certified error",
    "lookup table": "lookup table, 16 bits, interpolated",
    "float C": "float C, 101 samples (W3s: singletons)",
    "fuzzylite": "fuzzylite, instructions of the x86-64 host",
}


def drawn(results: Results, form: Literal["svg", "png"] = "svg") -> bytes:
    """The plot; the same bytes for the same results and matplotlib. Raises ImportError without matplotlib."""
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update({"svg.hashsalt": "fuzzyc", "svg.fonttype": "path", "font.size": 10.0})
        figure = Figure(figsize=(8.4, 5.2), layout="constrained")
        axes = figure.subplots()
        for workload, shape in _SHAPES.items():
            for kind in _COLOURS:
                _draw(axes, results, workload, kind, shape)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.margins(0.08)
        axes.xaxis.set_major_formatter("{x:,.0f}")
        axes.yaxis.set_major_formatter("{x:g} %")
        axes.set_xlabel("instructions a call, mean: Cortex-M0+, built for speed")
        axes.set_ylabel("largest error seen, of the output's range")
        axes.grid(True, which="major", color="#dddddd", linewidth=0.6)
        axes.set_axisbelow(True)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
        _legend(figure)
        written = io.BytesIO()
        if form == "svg":
            figure.savefig(written, format="svg", metadata={"Date": None, "Creator": None})
        else:
            figure.savefig(written, format="png", dpi=110)
    return written.getvalue()


def _draw(axes: Any, results: Results, workload: str, kind: str, shape: str) -> None:
    """One point, and a tick at fuzzyc's certified error."""
    point = _point(results, workload, kind)
    if point is None:
        return
    cost, error, certified = point
    colour = _COLOURS[kind]
    face = "white" if kind == "fuzzylite" else colour
    axes.plot([cost], [error], shape, color=colour, markerfacecolor=face, markersize=8, zorder=3)
    at, side = _label(results, workload, kind, cost)
    axes.annotate(workload, (cost, error), at, textcoords="offset points", ha=side, color=colour, fontsize=9)
    if certified is not None:
        axes.plot([cost, cost], [error, certified], "-", color=colour, linewidth=1.0, zorder=2)
        axes.plot([cost], [certified], "_", color=colour, markersize=11, zorder=2)


def _label(results: Results, workload: str, kind: str, cost: float) -> tuple[tuple[int, int], str]:
    """Offset and alignment: W1 and W2 lie close together, and so do the table's W3s and fuzzyc's."""
    if workload == "W3s":
        return ((0, -15), "center") if kind == "lookup table" else ((8, 5), "left")
    neighbour = _point(results, {"W1": "W2", "W2": "W1"}.get(workload, ""), kind)
    right = neighbour is None or cost > neighbour[0]
    return ((8, -4), "left") if right else ((-8, -4), "right")


def _point(results: Results, workload: str, kind: str) -> tuple[float, float, float | None] | None:
    """Instructions, largest error, certified error."""
    if kind == "fuzzylite":
        peer = next((p for p in results.peers if (p.workload, p.peer) == (workload, kind)), None)
        if peer is None or peer.instructions is None or peer.error is None:
            return None
        return peer.instructions, peer.error.largest, None
    entry = results.entry(workload, kind)
    record = None if entry is None else entry.record("cortex-m0plus", "O2")
    if entry is None or record is None or record.instructions_mean is None or entry.error is None:
        return None
    return record.instructions_mean, entry.error.largest, entry.certified


def _legend(figure: Any) -> None:
    from matplotlib.lines import Line2D

    marks = []
    for kind, colour in _COLOURS.items():
        face = "white" if kind == "fuzzylite" else colour
        marks.append(Line2D([], [], marker="o", linestyle="", color=colour, markerfacecolor=face, label=_LABELS[kind]))
    figure.legend(handles=marks, loc="outside upper center", ncols=2, frameon=False, fontsize=9)
