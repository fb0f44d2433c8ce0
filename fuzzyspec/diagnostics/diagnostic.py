"""A diagnostic is data: a code, a message, the spans it speaks of, and a way out."""

from __future__ import annotations

import bisect
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Severity = Literal["error", "warning", "note"]


@dataclass(frozen=True, slots=True, order=True)
class Span:
    """Half-open range of character offsets in one source text."""

    start: int
    end: int

    def to(self, other: Span) -> Span:
        """The smallest span that holds both."""
        return Span(min(self.start, other.start), max(self.end, other.end))


@dataclass(frozen=True)
class Source:
    """A spec's text and the name it is reported under (never an absolute path)."""

    name: str
    text: str
    _starts: tuple[int, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        starts = [0] + [i + 1 for i, ch in enumerate(self.text) if ch == "\n"]
        object.__setattr__(self, "_starts", tuple(starts))

    @property
    def sha256(self) -> str:
        """Hash of the text with its lines ended by LF, so that it does not depend on how a checkout ends them."""
        return hashlib.sha256(self.text.replace("\r\n", "\n").replace("\r", "\n").encode()).hexdigest()

    def position(self, offset: int) -> tuple[int, int]:
        """Line and column of an offset, both counted from 1."""
        line = bisect.bisect_right(self._starts, offset)
        return line, offset - self._starts[line - 1] + 1

    def line(self, number: int) -> str:
        """Text of one line (counted from 1), without its end."""
        start = self._starts[number - 1]
        end = self._starts[number] - 1 if number < len(self._starts) else len(self.text)
        return self.text[start:end].rstrip("\r")


@dataclass(frozen=True)
class Label:
    """A secondary span with its caption."""

    span: Span
    text: str


@dataclass(frozen=True)
class Diagnostic:
    """One finding. ``code`` is a key of the registry in ``codes``."""

    code: str
    message: str
    span: Span
    label: str = ""
    labels: tuple[Label, ...] = ()
    help: str | None = None
    notes: tuple[str, ...] = ()
    severity: Severity = "error"
    point: Mapping[str, str] | None = None
    """A concrete input that shows the problem: input name to a printed value with its unit."""


class SpecError(Exception):
    """A spec has errors; ``diagnostics`` holds every one found in one run."""

    def __init__(self, source: Source, diagnostics: tuple[Diagnostic, ...]) -> None:
        self.source = source
        self.diagnostics = diagnostics
        first = next(d for d in diagnostics if d.severity == "error")
        line, column = source.position(first.span.start)
        super().__init__(f"{source.name}:{line}:{column}: [{first.code}] {first.message}")
