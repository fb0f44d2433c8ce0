"""Collecting what is found while checking, so that one run reports every problem once."""

from __future__ import annotations

from collections.abc import Callable

from fuzzyspec.diagnostics.diagnostic import Diagnostic

Report = Callable[[Diagnostic], None]


class Findings:
    """Diagnostics in the order they were found; the same one twice counts once."""

    def __init__(self) -> None:
        self._found: list[Diagnostic] = []

    def report(self, diagnostic: Diagnostic) -> None:
        known = any(
            d.code == diagnostic.code and d.span == diagnostic.span and d.message == diagnostic.message
            for d in self._found
        )
        if not known:
            self._found.append(diagnostic)

    @property
    def errors(self) -> int:
        """How many errors were found so far."""
        return sum(d.severity == "error" for d in self._found)

    def sorted(self) -> tuple[Diagnostic, ...]:
        """All of them, in the order of the text."""
        return tuple(sorted(self._found, key=lambda d: (d.span, d.code)))
