"""The file in which a sweep over all inputs keeps how far it has come."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from fuzzyspec.diagnostics.refusal import Refusal

if TYPE_CHECKING:
    from fuzzyspec.verify import Swept

_EVERY = 2.0
"""Seconds between two writings."""
_KIND = "fuzzyc sweep"


class SweepFile:
    """Read once, then replaced as a whole every few seconds: what is cut short leaves the one before."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._key: Mapping[str, str] = {}
        self._written = 0.0

    def load(self, key: Mapping[str, str]) -> dict[str, Swept]:
        """What the file holds, nothing where there is none. Refusal where it is not a sweep of the same."""
        from fuzzyspec.verify import Swept

        self._key = key
        try:
            text = self._path.read_text(encoding="utf-8")
        except FileNotFoundError:
            return {}
        except UnicodeDecodeError as error:
            raise self._not_ours() from error
        try:
            data = json.loads(text)
            if data["kind"] != _KIND:
                raise self._not_ours()
            if data["key"] != dict(key):
                raise Refusal(
                    f"{self._path} is of another spec, C, compiler or fuzzyc", "delete it, or name another file"
                )
            return {str(name): Swept.from_data(one) for name, one in data["functions"].items()}
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise self._not_ours() from error

    def save(self, swept: Mapping[str, Swept], *, last: bool) -> None:
        """Write, unless it was written just now and this is not the last time. Raises OSError."""
        from fuzzyspec.emit import Plan, write

        now = time.monotonic()
        if last or now - self._written > _EVERY:
            data = {"kind": _KIND, "key": self._key, "functions": {k: s.as_data() for k, s in swept.items()}}
            content = f"{json.dumps(data, indent=1)}\n".encode()
            write(Plan({self._path.name: content}), self._path.parent)
            self._written = now

    def _not_ours(self) -> Refusal:
        return Refusal(f"{self._path} was not written by --exhaustive", "name another file")
