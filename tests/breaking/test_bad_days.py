"""The command line on a bad day: closed streams, odd names, folders that cannot be written, a hand on Ctrl-C."""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import pytest

from fuzzyspec.cli.main import main
from fuzzyspec.diagnostics.refusal import Refusal
from fuzzyspec.emit import plan
from fuzzyspec.native import toolchain

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


def in_small_folder(script: str, size: str, folder: Path) -> subprocess.CompletedProcess[bytes]:
    """Run lines of shell while ``folder`` is a disk of a few blocks."""
    if shutil.which("unshare") is None or subprocess.run(["unshare", "-rm", "true"], check=False).returncode:
        pytest.skip("this machine lets nobody make a small disk (unshare -rm)")
    folder.mkdir()
    lines = script.replace("$FUZZYC", f'"{sys.executable}" -m fuzzyspec')
    mounted = f'mount -t tmpfs -o size={size} tmpfs "{folder}"\n{lines}'
    return subprocess.run(["unshare", "-rm", "sh", "-c", mounted], cwd=ROOT, capture_output=True, check=False)


def test_a_full_disk_leaves_the_old_output_as_it_was(tmp_path: Path) -> None:
    """A compile that runs out of disk names the file, ends with 2, and neither changes nor adds a file."""
    disk = tmp_path / "disk"
    done = in_small_folder(
        f'$FUZZYC compile examples/tipper.fz -o "{disk}/c" > "{disk}/log" || exit 9\n'
        f'rm "{disk}/log"; (cd "{disk}/c" && sha256sum *) > "{tmp_path}/before"\n'
        f'dd if=/dev/zero of="{disk}/rest" bs=1k 2> /dev/null\n'
        f'sed "s/service/attendance/" examples/tipper.fz > "{tmp_path}/tipper.fz"\n'
        f'$FUZZYC compile "{tmp_path}/tipper.fz" -o "{disk}/c"; status=$?\n'
        f'(cd "{disk}/c" && sha256sum $(ls -A)) > "{tmp_path}/after"; exit $status\n',
        "96k",
        disk,
    )
    assert done.returncode == 2, done.stderr
    assert done.stderr.decode() == f"fuzzyc: {disk}/c/tipper.c: No space left on device\n"
    before = (tmp_path / "before").read_text(encoding="utf-8")
    assert len(before.splitlines()) == 3 and (tmp_path / "after").read_text(encoding="utf-8") == before


@pytest.mark.parametrize("size", ["20k", "80k"])
def test_no_room_for_temporary_files_is_no_verdict(size: str, tmp_path: Path) -> None:
    """Where the C or what the compiler makes of it finds no room, verify says so with 2: the C was not judged."""
    disk = tmp_path / "disk"
    done = in_small_folder(f'TMPDIR="{disk}" $FUZZYC verify examples/tipper.fz', size, disk)
    said = done.stderr.decode()
    assert done.returncode == 2, said
    assert "No space left on device" in said and said.count("\n") == 1


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("kill -9 $$", "was killed by signal 9"),
        ("echo 'cc: fatal error: Killed signal terminated program cc1' >&2; exit 1", "could not do its work"),
        ("exit 0", "reported success, yet made no file"),
    ],
)
def test_a_compiler_that_does_not_judge_is_no_verdict(script: str, said: str, tmp_path: Path) -> None:
    """A compiler killed, or that makes nothing, ends verify with 2 and one line, and is never taken for a wrong C."""
    compiler = tmp_path / "odd-cc"
    compiler.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    compiler.chmod(0o755)
    done = shell("$FUZZYC verify examples/tipper.fz", CC=str(compiler))
    assert done.returncode == 2
    assert said in done.stderr.decode() and done.stderr.count(b"\n") == 1


def test_a_compiler_that_hangs_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """After its time a compiler is given up, and said to be."""
    monkeypatch.setattr(toolchain, "MOST_SECONDS", 0.1)
    hanging = toolchain.Toolchain((sys.executable, "-c", "import time; time.sleep(60)"))
    with pytest.raises(Refusal, match="was stopped: it took more than"):
        hanging.build([], tmp_path / "made", ())


def test_two_compiles_into_one_folder_take_turns(tmp_path: Path) -> None:
    """While one holds the folder another waits, so that no folder is left with files of both."""
    with plan._alone_in(tmp_path):
        later = threading.Thread(target=plan.write, args=(plan.Plan({"a": b"later"}), tmp_path))
        later.start()
        later.join(0.2)
        assert later.is_alive() and not (tmp_path / "a").exists()
    later.join(60)
    assert (tmp_path / "a").read_bytes() == b"later"


def test_two_compiles_at_once_leave_the_files_of_one(tmp_path: Path) -> None:
    """Many compiles of two specs into one folder leave a set of files that `compile --check` takes for one of them."""
    specs = [tmp_path / "one" / "tipper.fz", tmp_path / "two" / "tipper.fz"]
    for spec, service in zip(specs, ("service", "attendance"), strict=True):
        spec.parent.mkdir()
        spec.write_text(TIPPER.read_text(encoding="utf-8").replace("service", service), encoding="utf-8")
    line = [*FUZZYC, "compile", "-o", str(tmp_path / "out")]
    running = [subprocess.Popen([*line, str(spec)], stdout=subprocess.DEVNULL) for spec in specs * 2]
    assert [r.wait(120) for r in running] == [0] * 4
    checked = [subprocess.run([*line, "--check", str(spec)], capture_output=True, check=False) for spec in specs]
    assert sorted(c.returncode for c in checked) == [0, 1]
    assert len(os.listdir(tmp_path / "out")) == 3


@pytest.mark.parametrize("kind", ["cells", "sentences"])
def test_twelve_inputs_of_nine_terms(kind: str, tmp_path: Path) -> None:
    """As cells they are refused in a diagnostic; as sentences they compile, in 2 GB."""
    inputs = "".join(f"    input x{i} in [0, 1] {{ partition A B C D E F G H I }}\n" for i in range(12))
    every = " and ".join(f"x{i} is not E" for i in range(12))
    body = {
        "cells": "    behavior GO priority 1 { if x0 is A then y is S }\n",
        "sentences": f"    rules {{ if {every} then y is S  if x0 is E then y is B }}\n",
    }[kind]
    path = tmp_path / "many.fz"
    path.write_text(
        f"module many\ncontroller c {{\n{inputs}    output y in [0, 1] {{ partition S B otherwise 0 }}\n{body}}}\n",
        encoding="utf-8",
    )
    done = shell(f'ulimit -v 2000000; $FUZZYC compile "{path}" -o "{tmp_path}/out"', OPENBLAS_NUM_THREADS="1")
    said = done.stderr.decode()
    assert done.returncode == (1 if kind == "cells" else 0), said
    assert ("FZ329" in said) == (kind == "cells") and (tmp_path / "out").exists() == (kind == "sentences")


def test_a_spec_of_ten_megabytes_is_refused(tmp_path: Path) -> None:
    """Ten megabytes of rules end in one diagnostic."""
    path = tmp_path / "huge.fz"
    path.write_text(TIPPER.read_text(encoding="utf-8") * 5_000 + "#" * 10_000_000, encoding="utf-8")
    done = shell(f'ulimit -v 2000000; $FUZZYC compile "{path}" -o "{tmp_path}/out"', OPENBLAS_NUM_THREADS="1")
    assert done.returncode == 1 and "FZ120" in done.stderr.decode() and not (tmp_path / "out").exists()
