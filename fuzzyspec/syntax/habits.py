"""Edits for what comes from other languages, from elsewhere in this one, or from a hand that slipped on a brace."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Span
from fuzzyspec.syntax import wording
from fuzzyspec.syntax.edit import Edit
from fuzzyspec.syntax.findings import unexpected
from fuzzyspec.syntax.hints import number_with_comma
from fuzzyspec.syntax.machine import made, opened, viable
from fuzzyspec.syntax.reading import BEGINS, Reading, partner, stack_at
from fuzzyspec.syntax.spelling import near
from fuzzyspec.syntax.tokens import UNIT

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


def set_without_braces(reading: Reading, at: int) -> Iterator[Edit]:
    """``x in A, B`` for ``x in {A, B}``."""
    cell = stack_at(reading, at)
    if cell.symbol != "IN" or "LBRACE" not in viable(reading.table, cell):
        return
    end = at
    while [t.kind for t in reading.tokens[end : end + 3]] == ["WORD", "COMMA", "WORD"]:
        end += 2
    names = reading.tokens[at : end + 1]
    if names[-1].kind != "WORD" or any(t.made for t in names):
        return
    told = Diagnostic(
        "FZ103",
        f"expected {wording.wanted(reading.table, cell)}, found {wording.found(names[0], reading.table)}",
        Span(names[0].start, names[-1].end),
        f"write `{{{', '.join(t.text for t in names if t.kind == 'WORD')}}}`",
    )
    opening, closing = (made(reading.table, kind, names[0].start) for kind in ("LBRACE", "RBRACE"))
    yield Edit(at, told, 1.0, (opening, *names, closing), len(names))


def unit_in_brackets(reading: Reading, at: int) -> Iterator[Edit]:
    """``[0, 8] [m]`` or ``(m)`` for ``[0, 8] m``."""
    token = reading.tokens[at]
    if token.kind not in ("LSQB", "LPAR") or "UNIT" not in viable(reading.table, stack_at(reading, at)):
        return
    end = partner(reading.tokens, at)
    inside = "" if end is None else reading.source.text[token.end : reading.tokens[end].start].strip()
    if end is None or not UNIT.fullmatch(inside):
        return
    span = Span(token.start, reading.tokens[end].end)
    told = Diagnostic("FZ101", "a unit stands in brackets", span, f"write `{inside}`")
    yield Edit(at, told, 0.5, (token._replace(kind="UNIT", text=inside, end=span.end),), end - at + 1)


def at_most(reading: Reading, at: int) -> Iterator[Edit]:
    """``flash = 1 KiB``, ``flash: 1 KiB`` or ``flash 1 KiB`` for ``flash <= 1 KiB``."""
    token = reading.tokens[at]
    cell = stack_at(reading, at)
    if wording.block(opened(cell)) != "in a budget" or token.made:
        return
    kinds = viable(reading.table, cell)
    sign = made(reading.table, "COMPARE", token.start)._replace(text="<=", end=token.end, made=False)
    help_ = "a limit reads `flash <= 1 KiB`"
    if token.kind == "LABEL" and "NAME" in kinds and "PLUS" not in kinds:
        colon = Span(token.end - 1, token.end)
        told = Diagnostic("FZ101", "expected `<=`, found `:`", colon, "write `<=`", help=help_)
        yield Edit(at, told, 0.5, (token._replace(kind="WORD", end=token.start + len(token.text)), sign), 1)
    elif kinds == {"COMPARE"} and token.kind in ("EQUAL", "NUMBER"):
        message = f"expected `<=`, found {wording.found(token, reading.table)}"
        if token.kind == "EQUAL":
            yield Edit(at, Diagnostic("FZ101", message, token.span, "write `<=`", help=help_), 0.5, (sign,), 1)
        else:
            told = Diagnostic("FZ103", message, token.span, "`<=` is missing before this", help=help_)
            yield Edit(at, told, 0.5, (sign,))


def hyphen(reading: Reading, at: int) -> Iterator[Edit]:
    """``on cortex m4`` for ``on cortex-m4``."""
    token = reading.tokens[at]
    cell = stack_at(reading, at)
    behind_on = cell.symbol == "NAME" and cell.below is not None and cell.below.symbol == "ON"
    if token.kind != "WORD" or token.made or not behind_on:
        return
    message = f"expected `-`, found {wording.found(token, reading.table)}"
    told = Diagnostic("FZ103", message, token.span, "`-` is missing before this", help="write `cortex-m4`")
    yield Edit(at, told, 0.5, (made(reading.table, "MINUS", token.start),))


def undeclared(reading: Reading, at: int) -> Iterator[Edit]:
    """``x in [0, 1] { .. }`` without its ``input`` or ``output``."""
    cell = stack_at(reading, at)
    if reading.tokens[at].kind != "WORD" or "INPUT" not in viable(reading.table, cell):
        return
    end = at + 1
    while [t.kind for t in reading.tokens[end : end + 2]] == ["COMMA", "WORD"]:
        end += 2
    ahead = reading.tokens[end : end + 2]
    if len(ahead) < 2 or ahead[0].text != "in" or ahead[1].kind != "LSQB":
        return
    told = Diagnostic(
        "FZ103",
        f"expected `input` or `output`, found {wording.found(reading.tokens[at], reading.table)}",
        reading.tokens[at].span,
        "one of them is missing before this",
    )
    text = "output" if _looks_like_output(reading, end) else "input"
    keyword = made(reading.table, text.upper(), reading.tokens[at].start)._replace(kind="WORD", text=text)
    yield Edit(at, told, 0.8, (keyword,))


def _looks_like_output(reading: Reading, at: int) -> bool:
    """Whether the terms of a variable are such as only outputs have, or it has a value."""
    for i in range(at, len(reading.tokens)):
        token = reading.tokens[i]
        if token.kind in ("EQUAL", "LBRACE") or (token.first and token.text in ("input", "output", "let")):
            end = partner(reading.tokens, i) if token.kind == "LBRACE" else None
            inside = {t.text for t in reading.tokens[i:end]} if end is not None else set()
            return token.kind == "EQUAL" or bool(inside & {"otherwise", "full", "singletons", "singleton"})
    return False


def misspelt_points(reading: Reading, at: int) -> Iterator[Edit]:
    """``pionts((0, 0), (1, 1))``: of all shapes only `points` takes pairs, so its name has to be right."""
    brackets = opened(stack_at(reading, at))
    if [c.symbol for c in brackets[:2]] != ["LPAR", "LPAR"]:
        return
    near_by = range(max(1, at - 64), at)
    outer = next((i for i in near_by if reading.tokens[i].start == brackets[1].start), None)
    if outer is None or reading.tokens[outer - 1].kind != "WORD":
        return
    name = reading.tokens[outer - 1]
    if name.text != "points" and near(name.text, ["points"]):
        message = f"expected a shape that takes pairs, found `{name.text}`"
        told = Diagnostic("FZ102", message, name.span, "did you mean `points`?")
        yield Edit(outer - 1, told, 0.5, (name._replace(text="points"),), 1)
