"""FZ3xx: terms, cells and rules."""

from __future__ import annotations

from fuzzyspec.diagnostics.code import Code

CODES: tuple[Code, ...] = ()
