"""FZ1xx: what the parser finds."""

from __future__ import annotations

from fuzzyspec.diagnostics.code import Code

CODES: tuple[Code, ...] = ()
