"""What syntax errors did to a tree: what cannot be concluded from it, and so is not reported.

While a file has syntax errors, parts of it are missing from its tree or stand in the wrong place. Problems elsewhere
are reported in the same run all the same; those that the missing parts may explain wait until the syntax is mended.
"""

from __future__ import annotations

import re

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source, Span
from fuzzyspec.syntax import tree
from fuzzyspec.syntax.tokens import MISSING

UNKNOWN_NAMES = frozenset({"FZ201", "FZ202", "FZ203", "FZ209", "FZ311", "FZ312", "FZ313"})
"""Codes about a name that is not declared; the span is the name."""

_MISPLACED = frozenset({"FZ210", "FZ212", "FZ214", "FZ241", "FZ244", "FZ250", "FZ328"})
"""Codes about what stands beside what, which tells little where a declaration is torn."""

_DECLARING = re.compile(
    r"\b(?:controller|system|module|unit|param|input|output|let|term|partition|singletons|behavior|each)\b"
)
_WORD = re.compile(r"\w+")
_PIECE = re.compile(r"\w+|[^\w\s]")
_PLACED = re.compile(r"\b(\w+)\s+at\b")
_RANGED = re.compile(r"\s+in\s*\[")


class Damage:
    """The syntax errors of a file, and what they may explain."""

    def __init__(self, module: tree.Module, source: Source, parse_diagnostics: tuple[Diagnostic, ...]) -> None:
        self._source = source
        self._spans = [d.span for d in parse_diagnostics if d.severity == "error"]
        self._lines = {line for span in self._spans for line in self._lines_of(span)}
        self._torn = [i.span for i in module.items if self.tears(i.span)]
        self._declared: set[str] | None = None

    def __bool__(self) -> bool:
        return bool(self._spans)

    def tears(self, span: Span) -> bool:
        """Whether a syntax error lies in (or right at) a piece of the text."""
        return any(span.start <= s.end and s.start <= span.end for s in self._spans)

    def explains(self, diagnostic: Diagnostic) -> bool:
        """Whether a syntax error may be all that is wrong."""
        if not self:
            return False
        span = diagnostic.span
        if span.start == span.end or f"`{MISSING}`" in f"{diagnostic.message} {diagnostic.help}":
            # What the parser put in for something missing.
            return True
        if any(self._lines & self._lines_of(s) for s in (span, *(at.span for at in diagnostic.labels))):
            return True
        if diagnostic.code in UNKNOWN_NAMES:
            return self._declares(self._source.text[span.start : span.end])
        return diagnostic.code in _MISPLACED and any(t.start <= span.start <= t.end for t in self._torn)

    def _lines_of(self, span: Span) -> set[int]:
        """The lines of a short piece of text; of a long one, the first."""
        first, last = self._source.position(span.start)[0], self._source.position(span.end)[0]
        return set(range(first, last + 1)) if last - first < 3 else {first}

    def _declares(self, name: str) -> bool:
        """Whether the text seems to declare a name, in a line that may not have made it into the tree."""
        if self._declared is None:
            self._declared = _declared(self._source.text).union(
                *(_WORD.findall(self._source.line(n)) for n in self._lines)
            )
        return name in self._declared


def _declared(text: str) -> set[str]:
    """Names behind a declaring keyword, before `in [` and before `at`."""
    found: set[str] = set()
    for line in text.splitlines():
        declaring = _DECLARING.search(line)
        if declaring:
            found.update(_WORD.findall(re.split("[#=]", line[declaring.end() :], maxsplit=1)[0]))
    found.update(_PLACED.findall(text))
    for ranged in _RANGED.finditer(text):
        found.update(_names_before(text, ranged.start()))
    return found


def _names_before(text: str, at: int) -> list[str]:
    """The list of names, with commas between, that ends at a place."""
    names: list[str] = []
    for piece in reversed(_PIECE.findall(text, max(0, at - 2_000), at)):
        if (piece == ",") != bool(len(names) % 2):
            break
        names.append(piece)
    return names
