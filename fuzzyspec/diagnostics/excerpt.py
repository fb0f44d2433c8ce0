"""Source lines with carets under what is spoken of."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

from fuzzyspec.diagnostics.diagnostic import Source, Span

_TAB = 4
_WINDOW = 140
"""Columns of a source line that are shown at most."""
_BEFORE = 50
"""Columns shown before the first mark of a line that is cut."""
_GUTTER = "1;34"

Paint = Callable[[str, str], str]
"""Puts a text in an ANSI style, or leaves it as it is."""


class Mark(NamedTuple):
    """A span to underline, and what to say there."""

    span: Span
    text: str
    primary: bool


class _Stroke(NamedTuple):
    """A mark within one line, in display columns; ``end`` is exclusive and beyond ``start``."""

    start: int
    end: int
    text: str
    primary: bool


def excerpt(source: Source, marks: list[Mark], paint: Paint, style: str) -> tuple[int, list[str]]:
    """Width of the line numbers, and the lines of the excerpt. ``style`` is that of the primary mark."""
    by_line: dict[int, list[_Stroke]] = {}
    for mark in marks:
        number, stroke = _stroke(source, mark)
        by_line.setdefault(number, []).append(stroke)
    width = len(str(max(by_line)))
    bar = paint(_GUTTER, f"{' ' * width} |")
    lines = [bar]
    before: int | None = None
    for number in sorted(by_line):
        if before is not None and number == before + 2:
            lines.append(_source_line(before + 1, width, _cut(display(source.line(before + 1)), 0), paint))
        elif before is not None and number > before + 2:
            lines.append(paint(_GUTTER, "..."))
        text = display(source.line(number))
        offset = _offset(text, by_line[number])
        lines.append(_source_line(number, width, _cut(text, offset), paint))
        strokes = [_moved(s, offset) for s in by_line[number]]
        lines += [f"{bar} {row}".rstrip() for row in _underlines(strokes, paint, style)]
        before = number
    return width, lines


_TURNS = frozenset({"LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI"})


def columns(char: str) -> int:
    """Columns that a character takes on a terminal."""
    if unicodedata.combining(char) or unicodedata.category(char) in ("Cf", "Mn", "Me"):
        return 0
    return 2 if unicodedata.east_asian_width(char) in "WF" else 1


@lru_cache(maxsize=4)
def display(line: str) -> str:
    """A line as it is shown: tabs as spaces, control characters by a stand-in of the same width.

    What would turn the direction of the text around is left out: carets could not stand under it.
    """
    shown: list[str] = []
    at = 0
    for char in line:
        if char == "\t":
            shown.append(" " * (_TAB - at % _TAB))
            at += _TAB - at % _TAB
        else:
            if unicodedata.bidirectional(char) in _TURNS:
                continue
            char = char if char.isprintable() or not columns(char) else "\N{REPLACEMENT CHARACTER}"
            shown.append(char)
            at += columns(char)
    return "".join(shown)


@lru_cache(maxsize=4)
def _starts(line: str) -> tuple[int, ...]:
    """The display column of each character of a source line, and of its end; kept, for many marks share a line."""
    starts = [0]
    for char in line:
        width = _TAB - starts[-1] % _TAB if char == "\t" else columns(char)
        starts.append(starts[-1] + width)
    return tuple(starts)


def _column(line: str, index: int) -> int:
    """The display column at which the character at ``index`` of a source line begins."""
    return _starts(line)[min(index, len(line))]


def _stroke(source: Source, mark: Mark) -> tuple[int, _Stroke]:
    """The line on which a mark begins, and what to draw under it; a longer span tells where it ends."""
    number, column = source.position(mark.span.start)
    last, last_column = source.position(mark.span.end)
    line = source.line(number)
    start = _column(line, column - 1)
    if last == number:
        end = _column(line, last_column - 1)
        return number, _Stroke(start, max(end, start + 1), mark.text, mark.primary)
    end = _column(line, len(line.split("#")[0].rstrip()) or len(line))
    to = f"(to line {last})"
    return number, _Stroke(start, max(end, start + 1), f"{mark.text} {to}" if mark.text else to, mark.primary)


def _offset(text: str, strokes: list[_Stroke]) -> int:
    """How many characters of a long line to leave out at its beginning."""
    if len(text) <= _WINDOW:
        return 0
    return max(0, min(s.start for s in strokes) - _BEFORE)


def _cut(text: str, offset: int) -> str:
    cut = text[offset : offset + _WINDOW]
    head = ".." if offset else ""
    return head + cut + (".." if len(text) > offset + _WINDOW else "")


def _moved(stroke: _Stroke, offset: int) -> _Stroke:
    """A stroke in the columns of a cut line."""
    if not offset and stroke.end <= _WINDOW:
        return stroke
    inset = 2 if offset else 0
    start = min(max(0, stroke.start - offset), _WINDOW) + inset
    end = min(max(0, stroke.end - offset), _WINDOW) + inset
    return stroke._replace(start=start, end=max(end, start + 1))


def _source_line(number: int, width: int, text: str, paint: Paint) -> str:
    return f"{paint(_GUTTER, f'{number:>{width}} |')} {text}".rstrip()


def _underlines(strokes: list[_Stroke], paint: Paint, style: str) -> list[str]:
    """Rows under a line: what overlaps stands in rows of its own."""
    rows: list[list[_Stroke]] = []
    for stroke in sorted(strokes, key=lambda s: (not s.primary, s.start)):
        for row in rows:
            if all(stroke.end < s.start or s.end < stroke.start for s in row):
                row.append(stroke)
                break
        else:
            rows.append([stroke])
    return [line for row in rows for line in _row(sorted(row), paint, style)]


def _row(strokes: list[_Stroke], paint: Paint, style: str) -> list[str]:
    """Carets and dashes; the last one's text beside it, the others' below, from right to left."""

    def styled(stroke: _Stroke, text: str) -> str:
        return paint(style if stroke.primary else _GUTTER, text)

    line, at = "", 0
    for s in strokes:
        line += " " * (s.start - at) + styled(s, ("^" if s.primary else "-") * (s.end - s.start))
        at = s.end
    last = strokes[-1]
    if last.text:
        line += " " + styled(last, last.text)
    lines = [line]
    hanging = [s for s in strokes[:-1] if s.text]
    while hanging:
        lowest = hanging.pop()
        for final in (styled(lowest, "|"), styled(lowest, lowest.text)):
            line, at = "", 0
            for s in hanging:
                line += " " * (s.start - at) + styled(s, "|")
                at = s.start + 1
            lines.append(line + " " * (lowest.start - at) + final)
    return lines
