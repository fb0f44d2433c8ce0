"""The command line on a bad day: closed streams, odd names, folders that cannot be written, a hand on Ctrl-C."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

from fuzzyspec.cli.main import main

ROOT = Path(__file__).resolve().parents[2]
TIPPER = ROOT / "examples" / "tipper.fz"
FUZZYC = [sys.executable, "-m", "fuzzyspec"]
ODD_NAME = "module m\ncontroller größe {\n    input x in [0, 1] { partition A B }\n}\n"


def shell(script: str, **environ: str) -> subprocess.CompletedProcess[bytes]:
    """Run a line of shell in which ``$FUZZYC`` is the command."""
    line = script.replace("$FUZZYC", f'"{sys.executable}" -m fuzzyspec')
    return subprocess.run(["sh", "-c", line], cwd=ROOT, env={**os.environ, **environ}, capture_output=True, check=False)


@pytest.mark.parametrize(
    ("streams", "status"),
    [(">&-", 0), ("2>&-", 0), (">&- 2>&-", 0), ("<&-", 0), ("> /dev/full", 2)],
)
def test_closed_and_full_streams_are_no_bug(streams: str, status: int) -> None:
    """With a stream closed the work is done all the same; a full disk is told of."""
    done = shell(f"$FUZZYC check examples/tipper.fz {streams}")
    assert done.returncode == status
    assert b"a bug in fuzzyc" not in done.stdout + done.stderr


@pytest.mark.parametrize("streams", [">&-", "2>&-", ">&- 2>&-", "2> /dev/null | true; exit 1"])
def test_a_broken_spec_stays_broken_where_nobody_reads(streams: str, tmp_path: Path) -> None:
    """The exit status does not depend on who listens."""
    path = tmp_path / "odd.fz"
    path.write_text(ODD_NAME, encoding="utf-8")
    done = shell(f'$FUZZYC check "{path}" {streams}')
    assert done.returncode == 1
    assert b"a bug in fuzzyc" not in done.stdout + done.stderr


def test_the_message_is_the_same_in_any_locale(tmp_path: Path) -> None:
    """Diagnostics with letters beyond ASCII come out whole under LC_ALL=C."""
    path = tmp_path / "größe.fz"
    path.write_text(ODD_NAME, encoding="utf-8")
    plain = shell(f'$FUZZYC check "{path}"', LC_ALL="C")
    rich = shell(f'$FUZZYC check "{path}"', LC_ALL="C.UTF-8")
    assert plain.returncode == 1 and plain.stderr == rich.stderr
    assert "größe.fz:2:12" in plain.stderr.decode()


def test_no_color_wins(tmp_path: Path) -> None:
    """NO_COLOR leaves no escape in the text, even where colour is forced."""
    path = tmp_path / "odd.fz"
    path.write_text(ODD_NAME, encoding="utf-8")
    assert b"\x1b[" in shell(f'$FUZZYC check "{path}"', FORCE_COLOR="1", NO_COLOR="").stderr
    assert b"\x1b[" not in shell(f'$FUZZYC check "{path}"', FORCE_COLOR="1", NO_COLOR="1").stderr


@pytest.mark.parametrize("command", ["check", "compile", "verify", "eval", "explain", "cost"])
def test_json_is_json_on_every_way_out(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A missing file and a broken spec both end in one JSON document that says so."""
    monkeypatch.chdir(tmp_path)
    Path("odd.fz").write_text(ODD_NAME, encoding="utf-8")
    for name, status, key in (("missing.fz", 2, "error"), ("odd.fz", 1, "diagnostics")):
        assert main([command, "--format", "json", name]) == status
        said = json.loads(capsys.readouterr().out)
        assert said["ok"] is False
        assert key in (said["files"][0] if "files" in said else said)
    assert os.listdir() == ["odd.fz"]


@pytest.mark.parametrize("target", ["file", "file/below", "readonly"])
def test_no_output_folder_is_one_line_and_leaves_nothing(
    target: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where the output cannot be written, one line names the place, and no file or folder is left behind."""
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("mine", encoding="utf-8")
    Path("readonly").mkdir()
    if target == "readonly":
        # The tests may run as root, whom no permission stops.
        def refuse(*args: object, **kwargs: object) -> None:
            raise PermissionError(13, "Permission denied")

        monkeypatch.setattr(tempfile, "mkstemp", refuse)
    assert main(["compile", str(TIPPER), "-o", target]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"fuzzyc: {target}") and err.count("\n") == 1
    assert sorted(str(p) for p in Path().rglob("*")) == ["file", "readonly"]
    assert Path("file").read_text(encoding="utf-8") == "mine"


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.parametrize("step", ["fuzzyc-*", "fuzzyc-*/*.bin"])
def test_ctrl_c_ends_in_one_line(step: str, tmp_path: Path) -> None:
    """A verification interrupted while it compiles, or while the C runs, says so in one line and leaves no files."""
    running = subprocess.Popen(
        [*FUZZYC, "verify", str(ROOT / "examples" / "nav.fz")],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
        env={**os.environ, "TMPDIR": str(tmp_path)},
    )
    while running.poll() is None and not list(tmp_path.glob(step)):
        time.sleep(0.02)
    os.killpg(running.pid, signal.SIGINT)
    _, said = running.communicate(timeout=60)
    assert running.returncode in (130, -signal.SIGINT)
    assert said.decode() == "fuzzyc: interrupted\n"
    assert list(tmp_path.iterdir()) == []
