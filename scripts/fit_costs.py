"""Measure the training set and fit the cost model to it: ``python -m scripts.fit_costs``, or ``make fit``.

Writes ``fuzzyspec/estimate/weights.json``. Non-negative least squares of the relative errors: a feature may cost
nothing, but no feature may pay. Every spec is held out of one of five fits; the errors on what was held out are what
the file states, the weights in the file are fitted to all.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import lsq_linear

from fuzzyspec.estimate import pressure
from fuzzyspec.estimate.features import Features
from fuzzyspec.estimate.profile import Profile, profile
from fuzzyspec.estimate.weights import dividers, divides
from scripts.cost_training import ROOT, items
from scripts.measure_costs import measure_all

WEIGHTS = ROOT / "fuzzyspec" / "estimate" / "weights.json"
PAGE = ROOT / "docs" / "cost.md"
START, END = "<!-- errors of the fit -->", "<!-- end of errors -->"
FITTED = {
    "cortex-m0plus": ("instructions", "cycles", "flash", "stack"),
    "cortex-m4": ("instructions", "flash", "stack"),
    "cortex-m7": ("instructions", "flash", "stack"),
    "rv32imc": ("instructions", "flash", "stack"),
    "avr": ("cycles", "flash", "stack"),
}
COLUMN = {"instructions": "instructions_mean", "cycles": "cycles_mean", "flash": "flash", "stack": "stack"}
LIKE = {"cortex-m7": "cortex-m4"}
"""Too few programs are measured on a Cortex-M7 to fit it alone: it is fitted with all that its sister was."""
LEAST = {"stack": 32.0}
"""Errors are relative to at least so much: leaves of few bytes would count for too much."""
SHRINK = 0.003
"""How strongly weights are drawn to 0 where the measurements do not say: a share of the rows, per weight."""
WORDS = ("words", *(f"crowded_{n}" for n in pressure.WORDS))
BYTES = ("bytes", *(f"crowded_bytes_{n}" for n in pressure.BYTES))
"""Registers as a machine of 32 bits and as AVR see them."""
ROUNDS, CLOSE = 30, 0.03
"""Least absolute errors, by reweighting: few programs that are unlike the others must not bend the weights for all."""
FOLDS = 5
"""Every spec is held out of one of so many fits, whose error on it is stated."""
MUCH = 2.5
"""A program with so much more to do than others of its cost is one of which the compiler found most to be dead: it is
left out, of the fit and of the errors."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Row:
    """One measured program: what it does, and what the emulator counted by target and option."""

    name: str
    widths: str
    found: Profile
    figures: Mapping[str, Mapping[str, float | None]]


def rows() -> Iterator[Row]:
    """All programs of the training set, measured now where they were not before."""
    wanted = list(items())
    data = measure_all(wanted)
    for item, record in zip(wanted, data["records"], strict=True):
        figures = {k: dict(zip(data["figures"], v, strict=True)) for k, v in record["rows"].items()}
        yield Row(item.name, item.widths, profile(item.program, item.function), figures)


def fold(name: str) -> int:
    """The fit that a spec is held out of."""
    return hashlib.sha256(name.encode()).digest()[0] % FOLDS


def features_of(found: Profile, target: str, figure: str) -> Features:
    """What a figure is a weighted sum of: registers as the machine has them, and nothing that divides."""
    given = found.frame if figure == "stack" else found.code if figure == "flash" else found.mean
    wide = target != "avr"
    kept: dict[str, float] = {}
    for name, count in given.items():
        if name not in (BYTES if wide else WORDS) and not divides(name):
            kept[name] = count
    return kept


def known(found: Profile, target: str, option: str, figure: str) -> float:
    """The part of a figure that is not fitted: tables, and what divides, measured alone."""
    alone = dividers(target, option, figure)
    features = found.code if figure == "flash" else found.mean
    return sum(alone.get(f, 0.0) * n for f, n in features.items()) + (found.tables if figure == "flash" else 0)


def fit(given: list[Features], wanted: Floats, size: Floats) -> dict[str, float]:
    """Weights by feature for ``features = wanted``, relative to the sizes."""
    names = sorted({name for features in given for name in features})
    matrix = np.array([[f.get(n, 0.0) for n in names] for f in given]) / size[:, None]
    scale = np.array([np.median(column[column > 0]) for column in matrix.T])
    target = wanted / size
    trust = np.ones(len(target))
    for _ in range(ROUNDS):
        rows = np.vstack([matrix / scale * trust[:, None], np.eye(len(names)) * np.sqrt(SHRINK)])
        found = lsq_linear(rows, np.concatenate([target * trust, np.zeros(len(names))]), (0, np.inf), method="bvls").x
        trust = 1 / np.sqrt(np.maximum(np.abs(matrix / scale @ found - target), CLOSE))
    return {n: round(float(w), 4) for n, w in zip(names, found / scale, strict=True) if w > 5e-5}


def alive(given: list[Features], size: Floats) -> npt.NDArray[np.bool_]:
    """Which programs do no more than ``MUCH`` of what is usual for their cost."""
    work = np.array([sum(f.values()) for f in given]) / size
    found: npt.NDArray[np.bool_] = work < MUCH * np.median(work)
    return found


def errors(weights: Mapping[str, float], given: list[Features], wanted: Floats, size: Floats) -> Floats:
    """Relative, signed."""
    estimated = np.array([sum(weights.get(n, 0.0) * c for n, c in f.items()) for f in given])
    return (estimated - wanted) / size


def fitted(all_rows: list[Row], target: str, option: str, figure: str) -> dict[str, Any]:
    """One figure of one machine: its weights and its errors."""
    chosen = [(r, f) for r in all_rows for t in (target, LIKE.get(target)) if (f := r.figures.get(f"{t} {option}"))]
    chosen = [(r, f) for r, f in chosen if f[COLUMN[figure]] is not None]
    own = np.array([f is r.figures.get(f"{target} {option}") for r, f in chosen])
    given = [features_of(r.found, target, figure) for r, _ in chosen]
    measured = np.array([f[COLUMN[figure]] for _, f in chosen], dtype=float)
    size = np.maximum(measured, LEAST.get(figure, 1.0))
    wanted = measured - [known(r.found, target, option, figure) for r, _ in chosen]
    kept = alive(given, size) if figure != "stack" else np.ones(len(given), dtype=bool)
    folds = np.array([fold(r.name) for r, _ in chosen])

    def part(mask: npt.NDArray[np.bool_]) -> tuple[list[Features], Floats, Floats]:
        return [g for g, m in zip(given, mask, strict=True) if m], wanted[mask], size[mask]

    unseen = [(kept & (folds != k), kept & (folds == k) & own) for k in range(FOLDS)]
    off = np.abs(np.concatenate([errors(fit(*part(seen)), *part(held)) for seen, held in unseen if held.any()]))
    told = {
        "median": round(float(np.median(off)), 4),
        "nine_in_ten": round(float(np.quantile(off, 0.9)), 4),
        "worst": round(float(off.max()), 4),
    }
    print(f"{target:14} -{option} {figure:13}", *(f"{k} {v:.3f}" for k, v in told.items()))
    return {
        **told,
        "fitted_to": int(kept.sum()),
        "left_out": int((~kept).sum()),
        "weights": fit(*part(kept)),
    }


def table(machines: Mapping[str, Any]) -> str:
    """The errors for docs/cost.md, in percent."""
    heads = ("target", "option", "instructions", "cycles", "flash", "stack")
    lines = [f"| {' | '.join(heads)} |", f"|---|---|{'--:|' * 4}"]
    for target, options in machines.items():
        for option, figures in options.items():
            cells = [_percent(figures[f]) if f in figures else "" for f in heads[2:]]
            lines.append(f"| {target} | -{option} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _percent(found: Mapping[str, Any]) -> str:
    return " / ".join(f"{100 * found[k]:.0f}" for k in ("median", "nine_in_ten", "worst"))


def tell(page: str, machines: Mapping[str, Any]) -> str:
    """The page with the table between its marks brought up to date."""
    head, _, rest = page.partition(START)
    return f"{head}{START}\n{table(machines)}{END}{rest.partition(END)[2]}"


def main() -> None:
    """Fit everything, write the weights, and state the errors."""
    all_rows = list(rows())
    machines = {
        target: {o: {f: fitted(all_rows, target, o, f) for f in figures} for o in ("O2", "Os")}
        for target, figures in FITTED.items()
    }
    note = (
        "Written by scripts/fit_costs.py from benchmarks/measured_costs.json. Errors are relative, on held-out specs."
    )
    seen = sorted({name for row in all_rows for name in row.found.code})
    PAGE.write_text(tell(PAGE.read_text(), machines), newline="\n")
    WEIGHTS.write_text(json.dumps({"note": note, "seen": seen, "machines": machines}, indent=1) + "\n", newline="\n")


if __name__ == "__main__":
    main()
