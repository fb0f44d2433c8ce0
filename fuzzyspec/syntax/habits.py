"""Edits for what comes from other languages, from elsewhere in this one, or from a hand that slipped on a brace."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label
from fuzzyspec.syntax import wording
from fuzzyspec.syntax.edit import Edit
from fuzzyspec.syntax.findings import unexpected
from fuzzyspec.syntax.hints import number_with_comma
from fuzzyspec.syntax.machine import opened, viable
from fuzzyspec.syntax.reading import BEGINS, Reading, stack_at

_MEANT = {
    "when": ("if",), "foreach": ("for", "each"), "default": ("otherwise",), "else": ("otherwise",),
    "var": ("let",), "val": ("let",), "set": ("let",), "def": ("let",), "const": ("param",), "constant": ("param",),
    "weight": ("with",), "import": ("module",), "package": ("module",), "class": ("controller",),
    "ruleblock": ("rules",), "inference": ("infer",), "mode": ("behavior",), "mf": ("term",), "membership": ("term",),
}  # fmt: skip
"""Words of other languages, and the keywords that stand for them here."""


def foreign_word(reading: Reading, at: int) -> Iterator[Edit]:
    """``when`` for ``if``, ``foreach`` for ``for each``."""
    token = reading.tokens[at]
    words = _MEANT.get(token.text.lower()) if token.kind == "WORD" else None
    cell = stack_at(reading, at)
    if not words or token.made or reading.table.keywords.get(words[0]) not in viable(reading.table, cell):
        return
    told = Diagnostic(
        "FZ102",
        f"expected {wording.wanted(reading.table, cell)}, found {wording.found(token, reading.table)}",
        token.span,
        f"write `{' '.join(words)}`",
    )
    yield Edit(at, told, 0.6, tuple(token._replace(text=word) for word in words), 1)


def decimal_comma(reading: Reading, at: int) -> Iterator[Edit]:
    """``0,2`` for ``0.2``."""
    first = number_with_comma(reading.tokens, at)
    if first is not None:
        whole, _, part = reading.tokens[first : first + 3]
        number = whole._replace(text=f"{whole.text}.{part.text}", end=part.end)
        yield Edit(first, unexpected(reading, at), 0.8, (number,), 3)


def brace_too_many(reading: Reading, at: int) -> Iterator[Edit]:
    """A brace that closed a block whose items go on behind it, in a file with more closing braces than opening ones."""
    token, brace = reading.tokens[at], reading.tokens[at - 1]
    kind = reading.table.keywords.get(token.text) if token.kind == "WORD" else None
    if at == 0 or brace.kind != "RBRACE" or brace.made or kind not in BEGINS or opened(stack_at(reading, at)):
        return
    if sum((t.kind == "RBRACE") - (t.kind == "LBRACE") for t in reading.tokens) <= 0:
        return
    told = Diagnostic(
        "FZ106",
        "this `}` closes its block too early",
        brace.span,
        "one too many, or a `{` is missing above",
        labels=(Label(token.span, f"so this stands {wording.block([])}"),),
        help="take it out, if this and what follows belong to the block",
    )
    yield Edit(at - 1, told, 0.5, (), 1)
