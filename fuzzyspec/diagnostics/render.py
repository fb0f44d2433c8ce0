"""Diagnostics as text in the manner of rustc, and as data."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Severity, Source, Span
from fuzzyspec.diagnostics.excerpt import Mark, Paint, excerpt

_COLORS: dict[Severity, str] = {"error": "1;31", "warning": "1;33", "note": "1;36"}
_ORDER: dict[Severity, int] = {"error": 0, "warning": 1, "note": 2}


def render(diagnostics: Iterable[Diagnostic], source: Source, color: bool = False) -> str:
    """Every diagnostic by position, with the lines it speaks of, and a line that counts them.

    Ends without a newline; empty where there is nothing to tell.
    """
    ordered = in_order(diagnostics)
    if not ordered:
        return ""
    blocks = [_block(d, source, _painter(color)) for d in ordered]
    return "\n\n".join([*blocks, summary(ordered)])


def in_order(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """By position, then by weight; what was found twice, once."""
    unique: list[Diagnostic] = []
    for d in sorted(diagnostics, key=lambda d: (d.span, _ORDER[d.severity], d.code, d.message)):
        if d not in unique[-8:]:
            unique.append(d)
    return unique


def summary(diagnostics: Iterable[Diagnostic]) -> str:
    """``3 errors, 1 warning; `fuzzyc explain FZ104` says more``."""
    listed = list(diagnostics)
    counts = []
    for severity in _ORDER:
        n = sum(d.severity == severity for d in listed)
        if n:
            counts.append(f"{n} {severity}{'s' if n > 1 else ''}")
    worst = min(listed, key=lambda d: _ORDER[d.severity])
    return f"{', '.join(counts)}; `fuzzyc explain {worst.code}` says more"


def as_json(diagnostics: Iterable[Diagnostic], source: Source) -> list[dict[str, Any]]:
    """The same as data: lines and columns count from 1, offsets (in characters) from 0, ends are exclusive."""
    return [
        {
            "code": d.code,
            "severity": d.severity,
            "message": d.message,
            "file": source.name,
            **_place(d.span, source),
            "label": d.label,
            "labels": [{**_place(each.span, source), "text": each.text} for each in d.labels],
            "help": d.help,
            "notes": list(d.notes),
            "point": dict(d.point) if d.point is not None else None,
        }
        for d in in_order(diagnostics)
    ]


def _place(span: Span, source: Source) -> dict[str, dict[str, int]]:
    def end(offset: int) -> dict[str, int]:
        line, column = source.position(offset)
        return {"line": line, "column": column, "offset": offset}

    return {"start": end(span.start), "end": end(span.end)}


def _painter(color: bool) -> Paint:
    def paint(style: str, text: str) -> str:
        return f"\x1b[{style}m{text}\x1b[0m" if color and text else text

    return paint


def _block(d: Diagnostic, source: Source, paint: Paint) -> str:
    line, column = source.position(d.span.start)
    style = _COLORS[d.severity]
    marks = [Mark(d.span, d.label, True), *(Mark(each.span, each.text, False) for each in d.labels)]
    width, lines = excerpt(source, marks, paint, style)
    head = paint(style, f"{d.severity}[{d.code}]") + paint("1", f": {d.message}")
    arrow = " " * width + paint("1;34", "-->") + f" {source.name}:{line}:{column}"
    remarks: list[tuple[str, str]] = []
    if d.point:
        remarks.append(("at", ", ".join(f"{name} = {value}" for name, value in d.point.items())))
    if d.help:
        remarks.append(("help", d.help))
    remarks += [("note", note) for note in d.notes]
    tail = [_remark(kind, text, width, paint) for kind, text in remarks]
    return "\n".join([head, arrow, *lines, *tail])


def _remark(kind: str, text: str, width: int, paint: Paint) -> str:
    """``= help: ..``, further lines set in under the first."""
    inset = " " * (width + len(f" = {kind}: "))
    return " " * (width + 1) + paint("1;34", "=") + f" {paint('1', kind)}: " + text.replace("\n", "\n" + inset)
