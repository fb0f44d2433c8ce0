"""How far a long command has come."""

from __future__ import annotations

import sys
import time

_SOON = 5.0
"""Seconds before how fast it goes is worth telling how long it will go on."""


class Bar:
    """One line on standard error, gone when it is done. Where it takes long it says how long, by how fast it went."""

    def __init__(self) -> None:
        self._shown = ""
        self._begun: tuple[float, int] | None = None

    def show(self, done: int, total: int, name: str) -> None:
        now = time.monotonic()
        if self._begun is None:
            self._begun = (now, done)
        percent = 100 if total <= 0 else min(100, 100 * done // total)
        since, first = now - self._begun[0], self._begun[1]
        left = f"{duration(since * (total - done) / (done - first))} left" if since > _SOON and done > first else ""
        line = f"[{'#' * (percent // 4):25}] {percent:3} % {name:20.20} {left:16}"
        if line != self._shown:
            self._shown = line
            print(f"\r{line}", end="", file=sys.stderr, flush=True)

    def __enter__(self) -> Bar:
        return self

    def __exit__(self, *_: object) -> None:
        if self._shown:
            print(f"\r{'':{len(self._shown)}}\r", end="", file=sys.stderr, flush=True)


def duration(seconds: float) -> str:
    """For people: of seconds, minutes or hours what is read best."""
    if seconds < 100:
        return f"{max(0, round(seconds))} s"
    return f"{round(seconds / 60)} min" if seconds < 100 * 60 else f"{seconds / 3600:.1f} h"
