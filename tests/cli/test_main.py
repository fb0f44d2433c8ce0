"""Exit statuses and what is said on the way out, whatever a command does."""

import argparse
import os
import subprocess
import sys
from pathlib import Path

import pytest

from fuzzyspec.cli import main as cli
from fuzzyspec.diagnostics.refusal import MissingTool, Refusal
from fuzzyspec.version import __version__

ROOT = Path(__file__).resolve().parents[2]


def run_raising(error: BaseException, monkeypatch: pytest.MonkeyPatch) -> int:
    """Exit status of a command that raises ``error``."""

    def run(arguments: argparse.Namespace) -> int:
        raise error

    parser = argparse.ArgumentParser()
    parser.set_defaults(run=run)
    monkeypatch.setattr(cli, "build_parser", lambda: parser)
    return cli.main([])


def fuzzyc(*words: str, **environ: str) -> subprocess.CompletedProcess[bytes]:
    """Run the command line as a user does."""
    command = [sys.executable, "-m", "fuzzyspec", *words]
    return subprocess.run(command, cwd=ROOT, env={**os.environ, **environ}, capture_output=True, check=False)


@pytest.mark.parametrize(
    ("error", "status", "said"),
    [
        (Refusal("nav.fz: no such file", "look again"), 2, "fuzzyc: nav.fz: no such file; look again\n"),
        (MissingTool("no C compiler", "install gcc"), 2, "fuzzyc: no C compiler; install gcc\n"),
        (PermissionError(13, "Permission denied", "out/nav.c"), 2, "fuzzyc: out/nav.c: Permission denied\n"),
        (KeyboardInterrupt(), 130, "fuzzyc: interrupted\n"),
    ],
)
def test_expected_ends_take_one_line(
    error: BaseException, status: int, said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Refusals, failing files and Ctrl-C give one line on standard error and their own exit status."""
    assert run_raising(error, monkeypatch) == status
    assert capsys.readouterr() == ("", said)


def test_bug_is_ours_and_says_so(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """An unexpected exception ends with 70 and a box that names it, without a traceback."""
    monkeypatch.delenv("FUZZYC_DEBUG", raising=False)
    assert run_raising(KeyError("lost"), monkeypatch) == 70
    said = capsys.readouterr().err
    assert "a bug in fuzzyc" in said
    assert "KeyError: 'lost'" in said
    assert "FUZZYC_DEBUG=1" in said
    assert "Traceback" not in said


def test_bug_shows_its_traceback_on_request(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Under FUZZYC_DEBUG the traceback comes first."""
    monkeypatch.setenv("FUZZYC_DEBUG", "1")
    assert run_raising(ZeroDivisionError("division by zero"), monkeypatch) == 70
    assert capsys.readouterr().err.startswith("Traceback")


def test_version() -> None:
    """--version prints one line and ends with 0."""
    done = fuzzyc("--version")
    assert (done.returncode, done.stdout, done.stderr) == (0, f"fuzzyc {__version__}\n".encode(), b"")


def test_help_lists_every_command() -> None:
    """--help names the commands and the exit statuses."""
    done = fuzzyc("--help")
    assert done.returncode == 0
    text = done.stdout.decode()
    for name in cli.COMMANDS:
        assert f"\n    {name} " in text
    assert "70" in text


@pytest.mark.parametrize("words", [(), ("no-such-command",), ("doctor", "--no-such-option")])
def test_wrong_usage_is_2(words: tuple[str, ...]) -> None:
    """A missing or unknown command and an unknown option are wrong usage."""
    done = fuzzyc(*words)
    assert done.returncode == 2
    assert done.stdout == b""
    assert b"usage: fuzzyc" in done.stderr


def test_reader_that_leaves_is_no_error() -> None:
    """A closed pipe ends the run quietly."""
    command = f'"{sys.executable}" -m fuzzyspec doctor | true'
    done = subprocess.run(["sh", "-c", command], cwd=ROOT, capture_output=True, check=False)
    assert done.stderr == b""


def test_output_is_utf8_in_any_locale() -> None:
    """The same bytes come out whatever the locale."""
    plain = fuzzyc("--help", LC_ALL="C", PYTHONUTF8="0", PYTHONCOERCECLOCALE="0")
    assert plain.returncode == 0
    assert plain.stdout == fuzzyc("--help", LC_ALL="C.UTF-8").stdout
