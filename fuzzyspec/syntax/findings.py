"""Diagnostics of a token that does not fit."""

from __future__ import annotations

from collections.abc import Sequence

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Source, Span
from fuzzyspec.syntax import wording
from fuzzyspec.syntax.hints import hint
from fuzzyspec.syntax.machine import CLOSERS, Cell, advance, opened, viable
from fuzzyspec.syntax.reading import BEGINS, OPENERS, Reading, gap, indent, place, stack_at
from fuzzyspec.syntax.tokens import END, Token

HOMES = {
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
    "BUDGET": "`budget { .. }` stands in a controller or a system",
    "LET": "`let` stands in a system, or in its `for each`",
    "FOR": "`for each` stands in a system",
    "IF": "rules stand in `rules { .. }` or in a `behavior`; within an expression a choice reads `a if TEST else b`",
    "PARTITION": "terms stand in braces behind the range of a controller's input or output",
    "SINGLETONS": "terms stand in braces behind the range of a controller's output",
    "TERM": "terms stand in braces behind the range of a controller's input or output",
    "OTHERWISE": "`otherwise` stands in the braces of a controller's output, or behind a value",
}
"""Where items stand."""


def unexpected(reading: Reading, at: int) -> Diagnostic:
    """The plain finding: what could stand here, and what does."""
    token = reading.tokens[at]
    cell = stack_at(reading, at)
    kind = reading.table.keywords.get(token.text, "") if token.kind == "WORD" else ""
    if kind in HOMES and viable(reading.table, cell) & BEGINS and advance(reading.table, cell, token) is None:
        return _misplaced(reading, at)
    if token.kind in OPENERS and OPENERS[token.kind] not in [c.symbol for c in opened(cell)]:
        opener = reading.table.texts[OPENERS[token.kind]]
        return Diagnostic("FZ106", f"this `{token.text}` closes nothing", token.span, f"no `{opener}` is open here")
    where = place(reading, at)
    return Diagnostic(
        "FZ101",
        f"expected {wording.wanted(reading.table, cell)}, found {wording.found(token, reading.table)}",
        where,
        "not expected here" if where == token.span and token.kind != END else "something is missing here",
        help=hint(reading, at),
    )


def _misplaced(reading: Reading, at: int) -> Diagnostic:
    """An item that belongs into another kind of block; at the top level, a block may have ended too early."""
    token = reading.tokens[at]
    cell = stack_at(reading, at)
    brackets = opened(cell)
    labels: tuple[Label, ...] = ()
    if not brackets and at and reading.tokens[at - 1].kind == "RBRACE":
        labels = (Label(reading.tokens[at - 1].span, "the block above ends here: is this brace one too many?"),)
    return Diagnostic(
        "FZ116",
        f"`{token.text}` does not belong {wording.block(brackets)}",
        token.span,
        f"expected {wording.wanted(reading.table, cell)}",
        labels=labels,
        help=HOMES[reading.table.keywords[token.text]],
    )


def unclosed(reading: Reading, brackets: Sequence[Cell], at: int) -> Diagnostic:
    """Tells of brackets (innermost first) that were still open at a token."""
    token = reading.tokens[at]
    innermost = brackets[0]
    text = reading.table.texts[innermost.symbol]
    closer = reading.table.texts[CLOSERS[innermost.symbol]]
    code = "FZ104" if innermost.symbol == "LBRACE" else "FZ105"
    labels = [Label(Span(b.start, b.end), "this one is still open, too") for b in brackets[1:]]
    suspect = _suspect(reading.source, reading.tokens, at, innermost) if code == "FZ104" else None
    if suspect is not None:
        labels.append(Label(suspect[0].span, "this one is closed at another indent,"))
        labels.append(Label(suspect[1].span, "here: the missing `}` may belong before it"))
    before = Label(gap(reading, at), f"expected `{closer}` before {wording.found(token, reading.table)}")
    return Diagnostic(
        code,
        f"this `{text}` is never closed",
        Span(innermost.start, innermost.end),
        f"needs a `{closer}`",
        labels=(before, *labels),
    )


def _suspect(source: Source, tokens: list[Token], at: int, bracket: Cell) -> tuple[Token, Token] | None:
    """Within an open block: a brace whose partner, first on its line, stands at another indent."""
    stack: list[Token] = []
    for token in tokens[:at]:
        if token.start <= bracket.start or token.made:
            continue
        if token.kind == "LBRACE":
            stack.append(token)
        elif token.kind == "RBRACE" and stack:
            opener = stack.pop()
            if token.first and indent(source, opener.start) != indent(source, token.start):
                return opener, token
    return None
