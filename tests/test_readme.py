"""What the README shows is what the tool prints."""

import re
from pathlib import Path
from typing import Any

import pytest

from fuzzyspec import load
from fuzzyspec.cli.main import main
from fuzzyspec.lower import Options

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def block(language: str) -> str:
    """The first fenced block of a language."""
    found = re.search(rf"^```{language}\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)
    assert found is not None
    return found[1]


@pytest.fixture
def near(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The README's spec, in a folder of its own that is the current one."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "near.fz").write_text(block("fz"), encoding="utf-8")
    return tmp_path


def test_compiling_prints_what_the_readme_says(near: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The files, the certified errors and the shown part of the header are as printed there."""
    assert main(["compile", "near.fz"]) == 0
    printed = capsys.readouterr().out
    for name in ("near.h", "near.c", "near_selftest.c"):
        assert f"wrote {name}\n" in printed
    errors = re.search(r"^```\n(output .*?)^```$", README, re.MULTILINE | re.DOTALL)
    assert errors is not None
    assert printed.endswith(errors[1])
    header = (near / "near.h").read_text(encoding="utf-8")
    for shown in block("c").strip().split("\n\n"):
        assert shown in header


def test_library_example_runs(near: Path) -> None:
    """The Python lines of the README run as they stand."""
    names: dict[str, Any] = {}
    exec(block("python"), names)
    assert names["spec"].name == "near"


@pytest.mark.parametrize("workload", ["w1", "w2", "w3", "w3s"])
def test_certified_errors_of_the_workloads(workload: str) -> None:
    """The table's percentage is the largest certified error of the workload, and no smaller."""
    row = re.search(rf"\[{workload}\].*\| ([\d.]+) % \|$", README, re.MULTILINE)
    assert row is not None
    lowered = load(ROOT / "benchmarks" / f"{workload}.fz").lower(Options())
    found = [o.percent_of_range for c in lowered.certificates.values() for o in c.outputs]
    largest = max(float(p) for p in found if p is not None)
    digits = len(row[1].split(".")[1])
    assert largest <= float(row[1]) < largest + 10**-digits


def test_links_lead_somewhere() -> None:
    """Every relative link of the README and of the docs names a file."""
    dead = [
        f"{page.relative_to(ROOT)}: {target}"
        for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
        for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
        if not (page.parent / target).exists()
    ]
    assert dead == []


def test_costs_are_those_of_the_benchmarks() -> None:
    """Every figure beside the lookup table is the one that `make bench` wrote last."""
    page = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (w[23]): (.+?) \| (.+) \|$", README, re.MULTILINE)
    assert len(rows) == 6
    for workload, what, figures in rows:
        m0, m4, avr, flash, error, certified = figures.split(" | ")
        shown = re.escape(f"| {workload.upper()} | {what} | {m0} | {m4} | ") + ".*? " + re.escape(f"| {avr} | ")
        shown += ".*? " + re.escape(f"| {flash.removesuffix(' B')} | {error} | {certified} |")
        assert re.search(f"^{shown}$", page, re.MULTILINE), (workload, what)
