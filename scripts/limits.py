"""Writes the tables of ``docs/limit.md``: the prices, and how far the builds for speed are from the counted limit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from fuzzyspec import load
from fuzzyspec.cost import TARGETS, find_compiler
from fuzzyspec.cost.limit import limit
from fuzzyspec.cost.measure import Conditions, measure
from fuzzyspec.cost.prices import CORES, STEPS
from fuzzyspec.lower import Options

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "limit.md"
SPECS = tuple(
    ROOT / "benchmarks" / f"{name}.fz"
    for name in (
        *("w1", "w2", "w3", "w3s", "odd/seven_singletons", "odd/seven_centroid", "odd/irregular", "odd/otherwise"),
        *("odd/three_of_five", "odd/uneven", "odd/small_raws"),
    )
)
"""The workloads, and what they have not: each file's first line tells."""
INPUTS = 200


def prices() -> str:
    """The table of prices."""
    rows = [[f"`{step}`", *(f"{p:g}" for p in found)] for step, found in STEPS.items()]
    return table(["step", "Cortex-M0+", "Cortex-M4, M7", "RV32IMC", "AVR, cycles"], rows)


def ratios(measured: Mapping[tuple[str, str], float]) -> str:
    """The table of means, limits and their ratios, by spec's stem and target."""
    rows = []
    for path in SPECS:
        cells = [_three(measured[path.stem, core], counted(path, core)) for core in CORES]
        rows.append([f"[{path.stem}](../{path.relative_to(ROOT).as_posix()})", *cells])
    return table(["", "Cortex-M0+", "Cortex-M4", "RV32IMC", "AVR, cycles"], rows)


def _three(mean: float, least: int) -> str:
    return f"{mean:,.0f} / {least:,} = {mean / least:.2f}"


def counted(path: Path, core: str) -> int:
    """The limit of the one controller of a spec."""
    (controller,) = load(path).controllers.values()
    return limit(controller, core)


def taken(path: Path, target: str, inputs: int = INPUTS) -> float:
    """The mean of a call of the build for speed. Raises MissingTool."""
    spec = load(path)
    chosen = Options(optimize="speed", target=target)  # type: ignore[arg-type]
    conditions = Conditions((find_compiler(TARGETS[target]),), ("O2",), inputs, worst=False)
    (record,) = measure(spec.lowered.program, lambda *_: spec.compile(chosen).files, conditions).records
    mean = record.cycles_mean if target == "avr" else record.instructions_mean
    assert mean is not None and record.matches, record
    return mean


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Markdown, numbers to the right."""
    ruler = ["---", *("--:" for _ in head[1:])]
    return "".join(f"| {' | '.join(row)} |\n" for row in (head, ruler, *rows))


def between(page: str, name: str, text: str) -> str:
    """A page with what stands between two marks replaced."""
    before, rest = page.split(f"<!-- {name} -->\n")
    _, after = rest.split(f"<!-- end of {name} -->\n")
    return f"{before}<!-- {name} -->\n{text}<!-- end of {name} -->\n{after}"


def main() -> None:
    """Measure, and write the page."""
    measured = {(path.stem, core): taken(path, core) for path in SPECS for core in CORES}
    page = PAGE.read_text(encoding="utf-8")
    page = between(between(page, "prices", prices()), "ratios", ratios(measured))
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
