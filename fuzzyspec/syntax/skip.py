"""Where no small edit helps: leave out the item that cannot be read and go on at the next keyword or brace."""

from __future__ import annotations

from dataclasses import replace

from fuzzyspec.diagnostics.diagnostic import Diagnostic
from fuzzyspec.syntax import wording
from fuzzyspec.syntax.machine import Cell, advance, advance_as, made, opened
from fuzzyspec.syntax.repair import Reading, stack_at, unclosed, unexpected
from fuzzyspec.syntax.tokens import END, Token

_BEGINS = frozenset(
    {
        "MODULE", "CONTROLLER", "SYSTEM", "UNIT_WORD", "PARAM", "INPUT", "OUTPUT", "TABLE", "BEHAVIOR", "RULES",
        "INFER", "FIRES", "LET", "FOR", "IF", "PARTITION", "SINGLETONS", "TERM", "OTHERWISE", "RBRACE",
    }
)  # fmt: skip
"""What an item begins with, and the brace that ends a block."""

_HOMES = {
    "MODULE": "`module NAME` stands once, at the top of the file",
    "CONTROLLER": "a controller stands at the top level, not within a block",
    "SYSTEM": "a system stands at the top level, not within a block",
    "UNIT_WORD": "units are declared at the top level: `unit tick = 0.012 rad`",
    "PARAM": "parameters stand at the top level or in a system: `param T = 2 s`",
    "INPUT": "inputs stand in a controller or a system",
    "OUTPUT": "outputs stand in a controller or a system",
    "TABLE": "tables stand in a controller",
    "BEHAVIOR": "behaviors stand in a controller",
    "RULES": "`rules { .. }` stands in a controller",
    "INFER": "`infer { .. }` stands in a controller",
    "FIRES": "`fires at` stands in a controller",
    "LET": "`let` stands in a system, or in its `for each`",
    "FOR": "`for each` stands in a system",
    "IF": "rules stand in `rules { .. }` or in a `behavior`; within an expression a choice reads `a if TEST else b`",
    "PARTITION": "terms stand in braces behind the range of a controller's input or output",
    "SINGLETONS": "terms stand in braces behind the range of a controller's output",
    "TERM": "terms stand in braces behind the range of a controller's input or output",
    "OTHERWISE": "`otherwise` stands in the braces of a controller's output, or behind a value",
}


def misfit(reading: Reading, index: int) -> Diagnostic:
    """What to say of a token that no small edit makes fit."""
    token = reading.tokens[index]
    brackets = opened(reading.cell)
    if token.kind == END and brackets:
        return unclosed(reading, brackets, index)
    plain = unexpected(reading, index)
    kind = reading.table.keywords.get(token.text, "")
    if token.kind == "WORD" and kind in _HOMES and advance(reading.table, reading.cell, token) is None:
        where = wording.wanted(reading.table, reading.cell)
        return replace(
            plain,
            code="FZ116",
            span=token.span,
            message=f"`{token.text}` does not belong here: expected {where}",
            label="",
            help=_HOMES[kind],
        )
    return plain


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
        index += 1


def _beginning(reading: Reading, token: Token) -> str:
    """The terminal by which a token begins an item, or empty."""
    kind = reading.table.keywords.get(token.text, "") if token.kind == "WORD" else token.kind
    return kind if kind in _BEGINS or (kind in ("LABEL", "LPAR") and token.first) else ""


def _resume(reading: Reading, cell: Cell, token: Token, kind: str) -> Cell | None:
    """The highest part of a stack on which a token can begin an item."""
    at: Cell | None = cell
    while at is not None:
        if advance_as(reading.table, at, token, kind) is not None and (kind != "LPAR" or at.symbol in _ROWS):
            return at
        at = at.below
    return None


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
