"""What is known of a file when a token does not fit."""

from __future__ import annotations

from typing import Protocol

from fuzzyspec.diagnostics.diagnostic import Source, Span
from fuzzyspec.syntax.machine import CLOSERS, Cell, terminal, viable
from fuzzyspec.syntax.table import Table
from fuzzyspec.syntax.tokens import END, Token

OPENERS = {closer: opener for opener, closer in CLOSERS.items()}
BEGINS = frozenset(
    {
        "CONTROLLER", "SYSTEM", "UNIT_WORD", "PARAM", "INPUT", "OUTPUT", "TABLE", "BEHAVIOR", "RULES", "INFER", "FIRES",
        "BUDGET", "LET", "FOR", "IF", "PARTITION", "SINGLETONS", "TERM", "OTHERWISE",
    }
)  # fmt: skip
"""Keywords that an item begins with."""
_BACK = 16
"""Tokens before an error among which the first of a line may be a keyword taken for a name."""


class Reading(Protocol):
    """The tokens, the stack before each one read so far (``trail``), and the stack now."""

    source: Source
    table: Table
    tokens: list[Token]
    trail: list[Cell]
    cell: Cell


def stack_at(reading: Reading, index: int) -> Cell:
    """The stack before the token at ``index``."""
    return reading.trail[index] if index < len(reading.trail) else reading.cell


def keywords_as_names(reading: Reading, index: int) -> list[int]:
    """Tokens before an error that were read as names and look like keywords: next to it, or first on their line."""
    found: list[int] = []
    for j in range(index - 1, max(-1, index - _BACK), -1):
        token = reading.tokens[j]
        could_be = token.kind == "WORD" and token.text in reading.table.keywords and (j == index - 1 or token.first)
        if could_be and terminal(reading.table, reading.trail[j], token) == "NAME":
            found.append(j)
        if token.first:
            break
    return found


def place(reading: Reading, at: int) -> Span:
    """Where to point for a token that does not fit: at it, or behind the last word if it stands on a later line.

    Nothing is missing behind the last word where an item could begin or end: there it is the token that is odd.
    """
    token = reading.tokens[at]
    if token.kind == END or (token.first and not _at_item(reading, at)):
        return gap(reading, at)
    return token.span


def _at_item(reading: Reading, at: int) -> bool:
    """Whether what stands before a token is whole, or a block has just begun."""
    cell = stack_at(reading, at)
    just_begun = cell.symbol == "LBRACE" and reading.tokens[at].kind not in OPENERS
    return at == 0 or just_begun or bool(viable(reading.table, cell) & (BEGINS | {"RBRACE"}))


def gap(reading: Reading, at: int) -> Span:
    """The place behind the token before ``at``."""
    end = reading.tokens[at - 1].end if at else 0
    return Span(end, end)


def lies_within(source: Source, token: Token, bracket: Cell) -> bool:
    """Whether a token that begins a line is indented deeper than the line that opens a bracket."""
    if not token.first or token.kind == END:
        return False
    return indent(source, token.start) > indent(source, bracket.start)


def indent(source: Source, offset: int) -> int:
    """Columns that the line of an offset is set in by."""
    line = source.line(source.position(offset)[0]).expandtabs(4)
    return len(line) - len(line.lstrip())


def partner(tokens: list[Token], at: int) -> int | None:
    """Where the bracket that opens at ``at`` is closed by its own kind, the brackets between being paired."""
    stack: list[str] = []
    for i in range(at, len(tokens)):
        kind = tokens[i].kind
        if kind in CLOSERS:
            stack.append(CLOSERS[kind])
        elif kind in OPENERS:
            if stack.pop() != kind:
                return None
            if not stack:
                return i
    return None
