"""How far a verification has come."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field

Progress = Callable[[int, int, str], None]
"""Cases done, cases planned, and of what: a function's name, a machine's."""


@dataclass
class Steps:
    """Counts what is done, from any thread."""

    total: int
    tell: Progress | None
    done: int = 0
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def add(self, cases: int, name: str) -> None:
        """So many more."""
        if self.tell is not None:
            with self._lock:
                self.done += cases
                self.tell(self.done, self.total, name)
