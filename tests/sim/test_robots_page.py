"""docs/robots.md says what the code holds."""

from __future__ import annotations

from pathlib import Path

from firmware_sim.parameters import RULES, Parameters, table

PAGE = Path(__file__).parents[2] / "docs" / "robots.md"


def test_the_page_has_every_open_parameter() -> None:
    """Each row of the table, and each rule in words, stands in the page as it stands in the code."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    rows = [f"| `{r.name}` | {r.value:.4g} | {r.unit} | {r.why} |" for r in table(Parameters())]
    assert [line for line in lines if line.startswith("| `")] == rows
    assert [line for line in lines if line.startswith("* ")] == [f"* {rule}" for rule in RULES]
