"""FZ9xx: what went wrong on our side."""

from __future__ import annotations

from fuzzyspec.diagnostics.code import Code

CODES: tuple[Code, ...] = ()
