"""Where no small edit helps: leave out the item that cannot be read and go on at the next keyword or brace."""

from __future__ import annotations

from fuzzyspec.diagnostics.diagnostic import Diagnostic
from fuzzyspec.syntax.findings import HOMES, unclosed, unexpected
from fuzzyspec.syntax.machine import Cell, advance, advance_as, made, opened, viable
from fuzzyspec.syntax.reading import BEGINS, Reading, keywords_as_names, lies_within, stack_at
from fuzzyspec.syntax.tokens import END, Token


def misfit(reading: Reading, index: int) -> Diagnostic:
    """What to say of a token that no small edit makes fit."""
    token = reading.tokens[index]
    brackets = opened(reading.cell)
    if token.kind == END and brackets:
        return unclosed(reading, brackets, index)
    for j in keywords_as_names(reading, index):
        return unexpected(reading, j)
    return unexpected(reading, index)


def to_next(reading: Reading, index: int) -> tuple[int, Cell]:
    """The next token at which some block on the stack can go on, and the stack cut down to that block."""
    cell = stack_at(reading, index)
    depth = 0
    start = index
    while True:
        token = reading.tokens[index]
        kind = _beginning(reading, token)
        if token.kind == END:
            return index, whole(reading)
        if token.kind == "LBRACE":
            depth += 1
        elif kind == "RBRACE" and depth:
            depth -= 1
        elif kind == "RBRACE":
            closed, cell = _close(reading, cell)
            if closed:
                return index, cell
        elif kind and (depth == 0 or token.first) and index > start - 1:
            resumed = _resume(reading, cell, token, kind)
            if resumed is not None and (index > start or resumed is not cell):
                return index, resumed
            if depth == 0 and token.first and index > start and kind in HOMES:
                return index, _at_items(reading, cell)
        index += 1


def _beginning(reading: Reading, token: Token) -> str:
    """The terminal by which a token begins an item, or empty."""
    kind = reading.table.keywords.get(token.text, "") if token.kind == "WORD" else token.kind
    return kind if kind in BEGINS or kind == "RBRACE" or (kind in ("LABEL", "LPAR") and token.first) else ""


def _resume(reading: Reading, cell: Cell, token: Token, kind: str) -> Cell | None:
    """The highest part of a stack on which a token can begin an item.

    A block is left only where it cannot end yet, and for a token that begins a line no deeper than the block's.
    """
    at: Cell | None = cell
    braces = {b for b in opened(cell) if b.symbol == "LBRACE"}
    ends = advance(reading.table, _at_items(reading, cell), made(reading.table, "RBRACE", cell.end)) is not None
    while at is not None:
        if at in braces and (ends or not token.first or lies_within(reading.source, token, at)):
            return at if advance_as(reading.table, at, token, kind) is not None else None
        if advance_as(reading.table, at, token, kind) is not None and (kind != "LPAR" or at.symbol in _ROWS):
            return at
        at = at.below
    return None


def _at_items(reading: Reading, cell: Cell) -> Cell:
    """The highest part of a stack on which some item can begin."""
    at = cell
    while at.below is not None and not viable(reading.table, at) & BEGINS:
        at = at.below
    return at


_ROWS = frozenset({"_rows", "columns"})


def _close(reading: Reading, cell: Cell) -> tuple[bool, Cell]:
    """For a closing brace: whether its block can end, and the stack cut to it, or to below a block given up."""
    at: Cell = cell
    while True:
        if advance(reading.table, at, made(reading.table, "RBRACE", at.end)) is not None:
            return True, at
        if at.below is None:
            return False, cell
        if at.symbol == "LBRACE":
            return False, at.below
        at = at.below


def whole(reading: Reading) -> Cell:
    """The stack cut and its blocks closed so that the file may end here."""
    at: Cell | None = reading.cell
    end = made(reading.table, END, reading.cell.end)
    while at is not None:
        closed: Cell | None = at
        while closed is not None:
            if advance(reading.table, closed, end) is not None:
                return closed
            closed = advance(reading.table, closed, made(reading.table, "RBRACE", at.end))
        at = at.below
    raise AssertionError("an empty file can always end")
