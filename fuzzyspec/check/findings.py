"""Collecting what is found while checking, so that one run reports every problem once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace

from fuzzyspec.check.damage import UNKNOWN_NAMES, Damage
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Severity, Span

Report = Callable[[Diagnostic], None]

_TOLD_ONCE = UNKNOWN_NAMES | {"FZ305", "FZ317"}
"""Codes of which many alike have one cause: an unknown name, a table too many, a header that fits no row."""


MOST = 500
"""Errors, and as many warnings, that are kept: nobody reads more, and each costs."""


class Findings:
    """Diagnostics, each counted once, without those that a syntax error may explain."""

    def __init__(self, damage: Damage) -> None:
        self._damage = damage
        self._found: list[Diagnostic] = []
        self._known: set[tuple[str, Span, str]] = set()
        self._counts: Counter[Severity] = Counter()

    def report(self, diagnostic: Diagnostic) -> None:
        """Take a diagnostic; the same one twice counts once."""
        if self._damage.explains(diagnostic):
            return
        key = (diagnostic.code, diagnostic.span, diagnostic.message)
        if key in self._known:
            return
        self._known.add(key)
        self._counts[diagnostic.severity] += 1
        if self._counts[diagnostic.severity] <= MOST:
            self._found.append(diagnostic)

    @property
    def errors(self) -> int:
        """How many errors were found so far."""
        return self._counts["error"]

    def sorted(self) -> tuple[Diagnostic, ...]:
        """All of them, in the order of the text; a name that is unknown in many places is told of once."""
        told: dict[tuple[str, str], list[Diagnostic]] = {}
        for d in sorted(self._found, key=lambda d: (d.span, d.code)):
            told.setdefault((d.code, d.message) if d.code in _TOLD_ONCE else (d.code, str(len(told))), []).append(d)
        kept = [_first(same) for same in told.values()]
        left_out = self._counts.total() - len(self._found)
        if left_out:
            note = f"{left_out} more problems like these are not listed: mend some first"
            kept[-1] = replace(kept[-1], notes=(*kept[-1].notes, note))
        return tuple(kept)


def _first(same: list[Diagnostic]) -> Diagnostic:
    first, more = same[0], len(same) - 1
    if not more:
        return first
    note = f"the same in {more} other place{'s' if more > 1 else ''}"
    return replace(first, notes=(*first.notes, note))
