"""Every strategy, measured."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fuzzyspec.cli.main import main
from tests.cost.cost_specs import KEEPING, PLAIN, compiler_for

FEW = ["--pareto", "--inputs", "20", "--opt", "O2", "--target", "cortex-m0plus"]


def measured(text: str, folder: Path, capsys: pytest.CaptureFixture[str], *more: str) -> str:
    """What the command prints of a spec."""
    compiler_for("cortex-m0plus")
    path = folder / "spec.fz"
    path.write_text(text, encoding="utf-8")
    assert main(["cost", str(path), *FEW, *more]) == 0
    return capsys.readouterr().out


def test_every_strategy_is_measured_and_the_goals_are_marked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each goal's choice once, figures and estimates beside each other, the certified error by output."""
    data = json.loads(measured(PLAIN, tmp_path, capsys, "--format", "json"))
    choices = data["choices"]
    assert len({json.dumps(c["strategy"]) for c in choices}) == len(choices) >= 4
    assert sorted(g for c in choices for g in c["goals"]) == ["balanced", "size", "speed"]
    for c in choices:
        assert c["matches"] is True
        assert c["estimate"]["instructions"] > 0
        assert c["certified"]["z"] > 0


def test_what_nothing_beats_is_marked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The fastest and the leanest are never beaten in all; a row that another equals or betters everywhere is."""
    choices = json.loads(measured(PLAIN, tmp_path, capsys, "--format", "json"))["choices"]
    figures = [(c["instructions_mean"], c["flash"], c["stack"], c["certified"]["z"]) for c in choices]
    for own, choice in zip(figures, choices, strict=True):
        beaten = any(f != own and all(a <= b for a, b in zip(f, own, strict=True)) for f in figures)
        assert choice["optimal"] is not beaten
    assert any(c["optimal"] for c in choices)


def test_text_has_a_table_for_each_function(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Systems as the goals make them."""
    out = measured(KEEPING, tmp_path, capsys)
    assert "hold on cortex-m0plus -O2" in out
    assert "both on cortex-m0plus -O2" in out
    assert out.count("as chosen") == 3
    assert "nothing else is better" in out
