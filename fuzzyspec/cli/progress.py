"""How far a long command has come."""

from __future__ import annotations

import sys


class Bar:
    """One line on standard error, gone when it is done."""

    def __init__(self) -> None:
        self._shown = -1

    def show(self, done: int, total: int, name: str) -> None:
        percent = 100 if total <= 0 else min(100, 100 * done // total)
        if percent != self._shown:
            self._shown = percent
            print(f"\r[{'#' * (percent // 4):25}] {percent:3} % {name:20.20}", end="", file=sys.stderr, flush=True)

    def __enter__(self) -> Bar:
        return self

    def __exit__(self, *_: object) -> None:
        if self._shown >= 0:
            print(f"\r{'':60}\r", end="", file=sys.stderr, flush=True)
