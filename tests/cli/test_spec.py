"""What every command says of a file that is no spec, and of a spec with errors."""

import json
from pathlib import Path

import pytest

from fuzzyspec.cli.main import main

COMMANDS = ("compile", "check", "verify", "eval")
BROKEN = "module m\n\ncontroller c {\n"


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("missing.fz", "no such file"),
        ("folder.fz", "is a folder"),
        ("notes.txt", "is not a spec; specs are named *.fz"),
    ],
)
def test_no_spec_is_one_line_and_2(
    command: str, name: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A missing file, a folder and a file of another kind are wrong usage, told in one line."""
    (tmp_path / "folder.fz").mkdir()
    (tmp_path / "notes.txt").write_text(BROKEN, encoding="utf-8")
    assert main([command, str(tmp_path / name)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("fuzzyc: ")
    assert said in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("command", COMMANDS)
def test_broken_spec_is_1_and_shown_in_place(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Errors of a spec go to standard error with file, line and column; nothing is written."""
    monkeypatch.chdir(tmp_path)
    Path("broken.fz").write_text(BROKEN, encoding="utf-8")
    assert main([command, "broken.fz"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert "broken.fz:3:" in err
    assert [p.name for p in tmp_path.iterdir()] == ["broken.fz"]


@pytest.mark.parametrize("command", COMMANDS)
def test_broken_spec_as_data(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With --format json, standard output is JSON that says it is not ok, and standard error is empty."""
    (tmp_path / "broken.fz").write_text(BROKEN, encoding="utf-8")
    assert main([command, "--format", "json", str(tmp_path / "broken.fz")]) == 1
    out, err = capsys.readouterr()
    assert json.loads(out)["ok"] is False
    assert err == ""


def test_unreadable_spec_is_one_line_and_2(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A spec that the system will not let us read is told of in one line."""
    path = tmp_path / "locked.fz"
    path.write_text(BROKEN, encoding="utf-8")

    def refuse(self: Path) -> bytes:
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "read_bytes", refuse)
    assert main(["check", str(path)]) == 2
    assert capsys.readouterr().err == f"fuzzyc: {path}: Permission denied\n"
