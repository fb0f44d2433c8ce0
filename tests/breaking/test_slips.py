"""Broken specs, each with what must be told of it, where, and by which code; none leaves a file."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from fuzzyspec.cli.main import main
from fuzzyspec.diagnostics.codes import REGISTRY
from tests.breaking.slips import SLIPS

FILES = sorted((Path(__file__).parents[1] / "fixtures" / "slips").glob("*.fz"))
EXPECTED = re.compile(r"(FZ\d{3}) at (\d+):(\d+)")

Told = list[tuple[str, int, int]]
"""Code, line and column of every diagnostic."""


def expected(text: str) -> Told:
    """What ``FZ301 at 7:12`` says, any number of times."""
    return [(code, int(line), int(column)) for code, line, column in EXPECTED.findall(text)]


def compiled(path: Path, capsys: pytest.CaptureFixture[str]) -> list[dict[str, Any]]:
    """The diagnostics of a spec that must not compile, nor leave a file."""
    folder = path.parent / "out"
    assert main(["compile", "--format", "json", str(path), "-o", str(folder)]) == 1
    out, err = capsys.readouterr()
    assert err == ""
    assert not folder.exists()
    told: list[dict[str, Any]] = json.loads(out)["diagnostics"]
    return told


def places(told: list[dict[str, Any]]) -> Told:
    """Where the carets begin."""
    return [(d["code"], d["start"]["line"], d["start"]["column"]) for d in told]


@pytest.mark.parametrize(
    ("base", "expect", "old", "new"),
    [pytest.param(base, *slip[1:], id=slip[0]) for base, slips in SLIPS.items() for slip in slips],
)
def test_a_slip_is_told_where_it_is(
    base: str, expect: str, old: str, new: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One edit of a sound spec gives exactly the diagnostics expected, each with a word on the place or a way out."""
    assert base.count(old) >= 1
    path = tmp_path / "slip.fz"
    path.write_text(base.replace(old, new, 1), encoding="utf-8")
    told = compiled(path, capsys)
    assert places(told) == expected(expect)
    for d in told:
        assert d["severity"] == REGISTRY[d["code"]].severity
        assert d["label"] or d["help"]


@pytest.mark.parametrize("base", SLIPS, ids=lambda text: text.split()[1])
def test_the_specs_that_slips_edit_are_sound(base: str, tmp_path: Path) -> None:
    """Without an edit, each of them compiles."""
    path = tmp_path / "sound.fz"
    path.write_text(base, encoding="utf-8")
    assert main(["compile", "--format", "json", str(path), "-o", str(tmp_path)]) == 0


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_broken_file_is_told_where_it_says(path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A fixture's `# expect:` lines are all that is told of it, the code in its name among them."""
    data = path.read_bytes()
    copy = tmp_path / path.name
    copy.write_bytes(data)
    told = places(compiled(copy, capsys))
    assert told == expected("".join(line for line in data.decode().splitlines() if line.startswith("# expect:")))
    assert path.name[:5].upper() in {code for code, _, _ in told}


@pytest.mark.parametrize("text", ["", "\n \n", "\ufeff", "\ufeff# a comment"], ids=["empty", "blank", "bom", "comment"])
def test_an_empty_file_is_told_at_its_beginning(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file with nothing in it is one diagnostic, at line 1, column 1."""
    path = tmp_path / "empty.fz"
    path.write_text(text, encoding="utf-8")
    assert places(compiled(path, capsys)) == [("FZ113", 1, 1)]
