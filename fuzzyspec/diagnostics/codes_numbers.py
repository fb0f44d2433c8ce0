"""FZ4xx: numbers, raws and range analysis."""

from __future__ import annotations

from fuzzyspec.diagnostics.code import Code

CODES: tuple[Code, ...] = ()
