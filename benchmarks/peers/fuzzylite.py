"""fuzzylite, C++, from Debian's libfuzzylite-dev: built here, timed here, its instructions counted by callgrind."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.peers.counted import instructions
from benchmarks.peers.fll import fll
from benchmarks.peers.task import PeerEntry, Skipped, Task

_SOURCE = Path(__file__).with_suffix(".cpp")
_COUNTED = 100
"""Evaluations under callgrind, which is some fifty times as slow."""


def measure(task: Task) -> PeerEntry:
    """All inputs of the task. Skipped where the library or a C++ compiler is missing."""
    with tempfile.TemporaryDirectory(prefix="fuzzyc-") as folder:
        path = Path(folder)
        _built(path)
        (path / "engine.fll").write_text(fll(task.controller), encoding="utf-8")
        _write_cases(path / "cases", task)
        printed = _run(["./fuzzylite", "engine.fll", "cases", "1"], path)
        names = [o.name for o in task.controller.outputs]
        values = np.array(printed[:-1], dtype=float).reshape(-1, len(names))
        error = task.error({name: values[:, k] for k, name in enumerate(names)})
        counted = _counted(path, task.first(_COUNTED))
        return PeerEntry(task.workload, "fuzzylite", _version(), error, len(values), float(printed[-1]), counted)


def _built(path: Path) -> None:
    compiler = next((c for c in ("g++", "clang++") if shutil.which(c)), None)
    if compiler is None:
        raise Skipped("no C++ compiler was found")
    command = [compiler, "-O2", "-std=c++17", "-w", "-o", "fuzzylite", str(_SOURCE), "-lfuzzylite"]
    done = subprocess.run(command, cwd=path, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Skipped("libfuzzylite-dev is not installed")


def _write_cases(path: Path, task: Task) -> None:
    path.write_text("\n".join(" ".join(repr(x) for x in row) for row in task.rows), encoding="utf-8")


def _counted(path: Path, task: Task) -> float | None:
    """Instructions of this machine an evaluation; None without valgrind."""
    _write_cases(path / "few", task)
    total = instructions(["./fuzzylite", "engine.fll", "few", "1"], "evaluate_rows", path)
    return None if total is None else total / len(task.rows)


def _run(command: list[str], path: Path) -> list[str]:
    return subprocess.run(command, cwd=path, capture_output=True, text=True, check=True).stdout.split()


@cache
def _version() -> str:
    """Debian's, where dpkg knows it."""
    if shutil.which("dpkg-query") is None:
        return ""
    command = ["dpkg-query", "-W", "-f=${Version}", "libfuzzylite-dev"]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()
