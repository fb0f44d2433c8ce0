"""What ``fuzzyc doctor`` finds, and what it says where nothing is found."""

import json
from pathlib import Path

import pytest

from fuzzyspec.cli.main import main


def test_finds_python_and_our_libraries(capsys: pytest.CaptureFixture[str]) -> None:
    """What this very run uses is reported as found, with versions."""
    main(["doctor", "--format", "json"])
    tools = {tool["tool"]: tool for tool in json.loads(capsys.readouterr().out)["tools"]}
    for name in ("python", "jinja2", "numpy", "cffi"):
        assert tools[name]["found"][0].isdigit()


def test_missing_compiler_is_2_and_says_how_to_get_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where CC names nothing, doctor ends with 2 and a way out."""
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("CC", "no-such-compiler")
    assert main(["doctor"]) == 2
    lines = capsys.readouterr().out.splitlines()
    (at,) = [i for i, line in enumerate(lines) if line.startswith("MISS C compiler")]
    assert "get it: unset CC" in lines[at + 1]


def test_broken_compiler_has_no_sanitizers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A compiler that links nothing is shown without sanitizers."""
    compiler = tmp_path / "broken"
    compiler.write_text('#!/bin/sh\n[ "$1" = --version ] && echo broken 1.0 && exit 0\nexit 1\n', encoding="utf-8")
    compiler.chmod(0o755)
    monkeypatch.setenv("CC", str(compiler))
    main(["doctor", "--format", "json"])
    tools = {tool["tool"]: tool["found"] for tool in json.loads(capsys.readouterr().out)["tools"]}
    assert tools["C compiler"] == "broken 1.0"
    assert tools["sanitizers"] is None
