"""FZ2xx: names, units and ranges."""

from __future__ import annotations

from fuzzyspec.diagnostics.code import Code

CODES: tuple[Code, ...] = ()
