"""``fuzzyc compile`` as its user meets it: bytes, exit statuses, and what is left on disk."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

SPEC = """\
module lamp
controller dimmer {
    input  dusk in [0, 3] { partition LIGHT DIM DARK }
    output glow in [0, 100] % { partition OFF HALF FULL full }
    table glow by dusk { LIGHT: OFF  DIM: HALF  DARK: FULL }
}
"""
FILES = ["lamp.c", "lamp.h", "lamp_selftest.c"]


def fuzzyc(*words: str, cwd: Path, **environ: str) -> subprocess.CompletedProcess[str]:
    """Run the command line in a folder."""
    root = Path(__file__).resolve().parents[2]
    environment = {**os.environ, "PYTHONPATH": str(root), **environ}
    line = [sys.executable, "-m", "fuzzyspec", *words]
    return subprocess.run(line, cwd=cwd, env=environment, capture_output=True, text=True, check=False)


def _content(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir()}


@pytest.fixture
def lamp(tmp_path: Path) -> Path:
    """A folder with a good spec in it."""
    (tmp_path / "lamp.fz").write_text(SPEC)
    return tmp_path


def test_the_same_spec_gives_the_same_bytes_anywhere(lamp: Path) -> None:
    """Neither folder, path, locale, hash seed nor line ends and byte order mark of the spec change a byte."""
    elsewhere = lamp / "another place"
    elsewhere.mkdir()
    (elsewhere / "lamp.fz").write_bytes(b"\xef\xbb\xbf" + SPEC.replace("\n", "\r\n").encode())
    one = fuzzyc("compile", "lamp.fz", "-o", "one", cwd=lamp, PYTHONHASHSEED="1", LC_ALL="C")
    two = fuzzyc("compile", str(lamp / "lamp.fz"), "-o", "two", cwd=elsewhere, PYTHONHASHSEED="2", LC_ALL="de_DE.UTF-8")
    three = fuzzyc("compile", "lamp.fz", "-o", "three", cwd=elsewhere, PYTHONHASHSEED="3", TZ="Asia/Tokyo")
    for done in (one, two, three):
        assert done.returncode == 0 and done.stderr == "", done.stderr
    first = _content(lamp / "one")
    assert sorted(first) == FILES
    assert _content(elsewhere / "two") == first
    assert _content(elsewhere / "three") == first


def test_what_was_written_is_told(lamp: Path) -> None:
    """The files and, for each output, its certified error are printed; JSON holds the same."""
    done = fuzzyc("compile", "lamp.fz", cwd=lamp)
    assert [line.split()[1] for line in done.stdout.splitlines() if line.startswith("wrote")] == FILES
    assert "dimmer.glow" in done.stdout and "% of range" in done.stdout
    data = json.loads(fuzzyc("compile", "lamp.fz", "--format", "json", cwd=lamp).stdout)
    assert data["ok"] and data["files"] == FILES and data["stale"] == []
    assert data["certified"]["dimmer"][0]["output"] == "glow"


def test_check_names_what_is_stale(lamp: Path) -> None:
    """``--check`` is quiet over fresh files, and writes nothing over missing, edited or outdated ones."""
    missing = fuzzyc("compile", "lamp.fz", "--check", "-o", "out", cwd=lamp)
    assert missing.returncode == 1 and missing.stderr.count("is stale") == 3 and not (lamp / "out").exists()
    fuzzyc("compile", "lamp.fz", "-o", "out", cwd=lamp)
    fresh = fuzzyc("compile", "lamp.fz", "--check", "-o", "out", cwd=lamp)
    assert (fresh.returncode, fresh.stdout, fresh.stderr) == (0, "", "")
    (lamp / "out" / "lamp.c").write_bytes((lamp / "out" / "lamp.c").read_bytes() + b"\n")
    edited = fuzzyc("compile", "lamp.fz", "--check", "-o", "out", cwd=lamp)
    assert edited.returncode == 1 and "lamp.c is stale" in edited.stderr and "lamp.h" not in edited.stderr
    assert (lamp / "out" / "lamp.c").read_bytes().endswith(b"\n\n")
    data = json.loads(fuzzyc("compile", "lamp.fz", "--check", "-o", "out", "--format", "json", cwd=lamp).stdout)
    assert not data["ok"] and data["stale"] == ["lamp.c"]


def test_a_wrong_spec_writes_nothing(lamp: Path) -> None:
    """Exit status 1 with diagnostics on standard error, as data with ``--format json``, and no file or folder."""
    (lamp / "lamp.fz").write_text(SPEC.replace("DARK: FULL", "DARK: FUL"))
    done = fuzzyc("compile", "lamp.fz", "-o", "out", cwd=lamp)
    assert done.returncode == 1 and done.stdout == "" and "FUL" in done.stderr
    data = json.loads(fuzzyc("compile", "lamp.fz", "-o", "out", "--format", "json", cwd=lamp).stdout)
    assert not data["ok"] and data["diagnostics"]
    assert sorted(p.name for p in lamp.iterdir()) == ["lamp.fz"]


def test_a_place_that_cannot_be_written_is_one_line(lamp: Path) -> None:
    """A file in the folder's place and a spec that is not there end in exit status 2 and a line that names them."""
    (lamp / "out").write_text("")
    for words, named in ((("lamp.fz", "-o", "out"), "out"), (("none.fz",), "none.fz")):
        done = fuzzyc("compile", *words, cwd=lamp)
        assert done.returncode == 2 and done.stdout == ""
        assert done.stderr.count("\n") == 1 and named in done.stderr
