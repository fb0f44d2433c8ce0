"""Lines of C: comments, wrapping and columns of numbers."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence

COLUMNS = 100
INDENT = "    "
_BREAKS = re.compile(r" (?=(?:\+|-|\*|/|<<|>>|<|<=|>|>=|==|!=|&&|\|\||\?|:|=) )|(?<=,) |(?<= =) ")


def quiet(text: str) -> str:
    """Text that may stand inside a C comment."""
    flat = " ".join(text.split())
    return flat.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?").rstrip("\\")


def comment(text: str, depth: int = 0) -> list[str]:
    """A comment as one line, or as a block where it is longer."""
    pad = INDENT * depth
    body = quiet(text)
    if len(pad) + len(body) + 6 <= COLUMNS:
        return [f"{pad}/* {body} */"]
    lines = textwrap.wrap(body, COLUMNS - len(pad) - 3, break_long_words=False, break_on_hyphens=False)
    return [f"{pad}/* {lines[0]}", *(f"{pad} * {line}" for line in lines[1:-1]), f"{pad} * {lines[-1]} */"]


def filled(lines: Sequence[str], room: int = COLUMNS - 3) -> list[str]:
    """Lines made safe for a comment and wrapped; what is continued is indented below its beginning."""
    out: list[str] = []
    for line in lines:
        indent = " " * (len(line) - len(line.lstrip()) + 2)
        start = line[: len(indent) - 2]
        out += textwrap.wrap(
            start + quiet(line), room, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
        ) or [""]
    return out


def block_comment(lines: Sequence[str]) -> list[str]:
    """Several lines as one comment."""
    body = filled(lines)
    if len(body) == 1:
        return comment(body[0])
    return [f"/* {body[0]}", *(f" * {line}".rstrip() for line in body[1:-1]), f" * {body[-1]}", " */"]


def code(text: str, depth: int) -> list[str]:
    """A statement, broken before operators that stand in the fewest parentheses where it is too long."""
    pad = INDENT * depth
    if len(pad) + len(text) <= COLUMNS:
        return [pad + text]
    head, *rest = _broken(text, COLUMNS - len(pad), COLUMNS - len(pad) - len(INDENT))
    return [pad + head, *(pad + INDENT + line for line in rest)]


def _broken(text: str, first: int, others: int) -> list[str]:
    out: list[str] = []
    limit = first
    while len(text) > limit:
        at = _best_break(text, limit)
        if at is None:
            break
        out.append(text[:at].rstrip())
        text = text[at:].lstrip()
        limit = others
    return [*out, text]


def _best_break(text: str, limit: int) -> int | None:
    depths = _depths(text)
    places = [m.start() for m in _BREAKS.finditer(text) if limit // 3 < m.start() <= limit]
    if not places:
        places = [m.start() for m in _BREAKS.finditer(text) if m.start() > 0][:1]
    return min(places, key=lambda i: (depths[i], -i), default=None)


def _depths(text: str) -> list[int]:
    out: list[int] = []
    depth = 0
    for ch in text:
        if ch in ")]}":
            depth -= 1
        out.append(depth)
        if ch in "([{":
            depth += 1
    return out


def rows(items: Sequence[str], depth: int = 1) -> list[str]:
    """Items of an initialiser, filled into lines."""
    pad = INDENT * depth
    return textwrap.wrap(", ".join(items), COLUMNS - len(pad), initial_indent=pad, subsequent_indent=pad)
