"""Small edits by which a file could have been meant, each with the diagnostic that tells of it.

At an error every candidate edit is tried by running the machine on over the tokens behind it. The one that carries
furthest for the least change is taken, so the rest of the file is still read, and told of in its own right.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Source, Span
from fuzzyspec.syntax import wording
from fuzzyspec.syntax.machine import CLOSERS, Cell, advance, made, opened, terminal, viable
from fuzzyspec.syntax.spelling import near
from fuzzyspec.syntax.table import Table
from fuzzyspec.syntax.tokens import END, Token

_REACH = 6
"""Tokens behind the error that are tried at most."""
_LEAST_REACH = 2
_BACK = 16
"""Tokens before the error among which the start of a line may be a keyword taken for a name."""

_MARKS = frozenset({"COMMA", "COLON", "EQUAL", "LBRACE", "LPAR", "LSQB", "RBRACE", "RPAR", "RSQB", "SLASH", "DOTS"})
_INSERTED_WORDS = frozenset(
    {"IN", "IS", "THEN", "AT", "BY", "PRIORITY", "EACH", "ELSE", "INITIAL", "IF", "LET", "TERM", "PARTITION", "FOR"}
)
_REPLACEABLE = _MARKS | {"COMPARE", "DOT", "AND", "IS", "IN", "FOR"}
_OPENERS = {closer: opener for opener, closer in CLOSERS.items()}
_HINTS = {
    "THEN": "a rule reads `if x is A then y is B`",
    "IS": "a rule reads `if x is A then y is B`",
    "PRIORITY": "a behavior begins `behavior NAME priority NUMBER {`",
    "LET": "a value gets its name by `let NAME = ..`",
    "EACH": "a loop reads `for each o in LIST { let o.x = .. }`",
    "BY": "a table begins `table OUTPUT by INPUT, INPUT {`",
    "ELSE": "a choice reads `a if TEST else b`",
    "INITIAL": "write `otherwise hold initial VALUE`",
    "IF": "a rule begins with `if`",
    "AT": "a partition is all even (`A B C`) or all placed (`A at 0, B at 2`)",
}


class Reading(Protocol):
    """What is known at an error: the stack before each token consumed so far, and the stack now."""

    source: Source
    table: Table
    tokens: list[Token]
    trail: list[Cell]
    cell: Cell


@dataclass(frozen=True, slots=True)
class Repair:
    """``tokens[at : at + drop]`` becomes ``insert``; ``swaps`` replaces single tokens further on."""

    at: int
    diagnostic: Diagnostic
    cost: float
    insert: tuple[Token, ...] = ()
    drop: int = 0
    swaps: dict[int, Token] = field(default_factory=dict)


def best(reading: Reading, index: int) -> Repair | None:
    """The edit that carries furthest for the least, or None where none carries far enough."""
    chosen: Repair | None = None
    chosen_score = 0.0
    for repair in _candidates(reading, index):
        reach = _reach(reading, repair, index)
        if reach < _LEAST_REACH:
            continue
        score = reach - repair.cost
        if chosen is None or score > chosen_score:
            chosen, chosen_score = repair, score
    return chosen


def stack_at(reading: Reading, index: int) -> Cell:
    """The stack before the token at ``index``."""
    return reading.trail[index] if index < len(reading.trail) else reading.cell


def _reach(reading: Reading, repair: Repair, index: int) -> int:
    """How many tokens from ``index`` on could be read after the edit; the end of the file counts as the furthest."""
    cell: Cell | None = stack_at(reading, repair.at)
    for token in repair.insert:
        assert cell is not None
        cell = advance(reading.table, cell, token)
        if cell is None:
            return 0
    assert cell is not None
    for i in range(repair.at + repair.drop, min(index + _REACH, len(reading.tokens))):
        token = repair.swaps.get(i, reading.tokens[i])
        cell = advance(reading.table, cell, token)
        if cell is None:
            return i - index
        if token.kind == END:
            return _REACH
    return _REACH


def _candidates(reading: Reading, index: int) -> Iterator[Repair]:
    yield from _misspelt(reading, index)
    yield from _closed(reading, index)
    yield from _inserted(reading, index)
    yield from _replaced(reading, index)
    yield from _relabelled(reading, index)
    yield from _dropped(reading, index)
    if index > 0:
        yield from _misspelt(reading, index - 1)
    for j in _keywords_as_names(reading, index):
        yield from _closed(reading, j)
        yield from _inserted(reading, j)


def _keywords_as_names(reading: Reading, index: int) -> list[int]:
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


# --- the kinds of edit -----------------------------------------------------------------------


def _misspelt(reading: Reading, at: int) -> Iterator[Repair]:
    token = reading.tokens[at]
    if token.kind != "WORD" or token.text in reading.table.keywords or token.made:
        return
    cell = stack_at(reading, at)
    texts = [t for t, kind in reading.table.keywords.items() if kind in viable(reading.table, cell)]
    for text in near(token.text, texts):
        diagnostic = Diagnostic(
            "FZ102",
            f"expected {wording.wanted(reading.table, cell)}, found `{_short(token.text)}`",
            token.span,
            f"did you mean `{text}`?",
            help="keywords are written in small letters" if text == token.text.lower() else None,
        )
        yield Repair(at, diagnostic, 0.5, (token._replace(text=text),), 1)


def _closed(reading: Reading, at: int) -> Iterator[Repair]:
    """Brackets that were never closed, from the innermost outwards."""
    cell = stack_at(reading, at)
    token = reading.tokens[at]
    open_cells = opened(cell)
    if not open_cells:
        return
    start = reading.tokens[at - 1].end
    operand = made(reading.table, "NAME", start)
    for first in ((), (operand,)):
        inserted: list[Token] = list(first)
        for count, bracket in enumerate(open_cells, start=1):
            inserted.append(made(reading.table, CLOSERS[bracket.symbol], start))
            cost = 1.0 + count / 2 + 2 * len(first)
            if _lies_within(reading.source, token, bracket):
                cost += 4
            yield Repair(at, unclosed(reading, open_cells[:count], at), cost, tuple(inserted))


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
    return Diagnostic(
        code,
        f"this `{text}` is never closed",
        Span(innermost.start, innermost.end),
        f"needs a `{closer}`",
        labels=(Label(_gap(reading, at), f"expected `{closer}` before {wording.found(token, reading.table)}"), *labels),
    )


def _inserted(reading: Reading, at: int) -> Iterator[Repair]:
    """A mark or a word that was left out."""
    cell = stack_at(reading, at)
    start = reading.tokens[at - 1].end if at else 0
    kinds = viable(reading.table, cell)
    for kind in sorted(kinds & (_MARKS | _INSERTED_WORDS)):
        text = reading.table.texts[kind]
        # A word is a name wherever it can be one, so that it cannot be put in as a keyword there.
        if kind in _OPENERS:
            continue
        code = "FZ109" if kind == "COLON" else "FZ103"
        diagnostic = Diagnostic(
            code,
            f"expected `{text}`{_row(kind)}, found {wording.found(reading.tokens[at], reading.table)}",
            _place(reading, at),
            f"`{text}` is missing here",
            help=_HINTS.get(kind),
        )
        token = _token(reading.table, kind, start)
        yield Repair(at, diagnostic, 1.0 if kind in _MARKS else 1.5, (token,))
    for kind in ("NAME", "NUMBER"):
        if kind in kinds:
            diagnostic = unexpected(reading, at)
            yield Repair(at, diagnostic, 2.0, (made(reading.table, kind, start),))
            break


def _token(table: Table, kind: str, at: int) -> Token:
    """A mark or keyword put in; a keyword goes in as a word, which the machine then takes for what fits."""
    token = made(table, kind, at)
    return token._replace(kind="WORD") if token.text.isalpha() else token


def _row(kind: str) -> str:
    return " after the row's label" if kind == "COLON" else ""


def _replaced(reading: Reading, at: int) -> Iterator[Repair]:
    """One mark for another: ``=`` for ``:``, ``(`` for ``[`` with its partner."""
    token = reading.tokens[at]
    cell = stack_at(reading, at)
    kind = terminal(reading.table, cell, token)
    if kind not in _REPLACEABLE or token.made:
        return
    for other in sorted(viable(reading.table, cell) & (_MARKS | {"COMPARE", "IS", "THEN"}) - {kind}):
        if (kind in CLOSERS) != (other in CLOSERS) or (other in ("IS", "THEN") and kind not in ("COMPARE", "EQUAL")):
            continue
        text = "==" if other == "COMPARE" else reading.table.texts[other]
        if other == "COMPARE" and kind != "EQUAL":
            continue
        swaps: dict[int, Token] = {}
        if kind in CLOSERS and (partner := _partner(reading.tokens, at)) is not None:
            closer = CLOSERS[other]
            swaps[partner] = reading.tokens[partner]._replace(kind=closer, text=reading.table.texts[closer])
        diagnostic = Diagnostic(
            "FZ101",
            f"expected {wording.wanted(reading.table, cell)}, found {wording.found(token, reading.table)}",
            token.span,
            f"write `{text}`" if not swaps else f"write `{text}` .. `{reading.table.texts[CLOSERS[other]]}`",
            help=_reason(kind, other),
        )
        new = token._replace(kind="WORD" if text.isalpha() else other, text=text)
        yield Repair(at, diagnostic, 1.0, (new,), 1, swaps)


def _reason(kind: str, other: str) -> str | None:
    match kind, other:
        case "AND", "COMMA":
            return "the outputs that one rule sets are separated by commas"
        case "EQUAL", "COMPARE":
            return "`=` gives a name, `==` compares"
        case (("EQUAL" | "COMPARE"), "IS"):
            return "a condition reads `x is A`, `x is not A` or `x in {A, B}`"
        case "LPAR", "LSQB":
            return "a range stands in square brackets; both ends belong to it"
        case (("LPAR" | "LSQB"), "LBRACE"):
            return "a set of terms stands in braces"
        case _:
            return None


def _partner(tokens: list[Token], at: int) -> int | None:
    """Where the bracket that opens at ``at`` is closed, if it is closed by its own kind."""
    depth = 0
    opener = tokens[at].kind
    for i in range(at, min(at + 64, len(tokens))):
        if tokens[i].kind == opener:
            depth += 1
        elif tokens[i].kind == CLOSERS[opener]:
            depth -= 1
            if depth == 0:
                return i
    return None


def _relabelled(reading: Reading, at: int) -> Iterator[Repair]:
    """A colon too many or too few between a name and what follows."""
    token = reading.tokens[at]
    if token.kind == "LABEL" and not token.made:
        cell = stack_at(reading, at)
        word = token._replace(kind="WORD", end=token.start + len(token.text))
        after = advance(reading.table, cell, word)
        if after is not None:
            colon = Span(token.end - 1, token.end)
            for kind in ("EQUAL", "IS", "IN"):
                text = reading.table.texts[kind]
                mark = _token(reading.table, kind, token.end)
                message = f"expected {wording.wanted(reading.table, after)}, found `:`"
                yield Repair(at, Diagnostic("FZ101", message, colon, f"write `{text}`"), 1.0, (word, mark), 1)
            message = f"expected {wording.wanted(reading.table, after)}, found `:`"
            yield Repair(at, Diagnostic("FZ101", message, colon, "leave the colon out"), 1.2, (word,), 1)
    if at == 0 or reading.tokens[at - 1].kind != "WORD":
        return
    name = reading.tokens[at - 1]
    label = name._replace(kind="LABEL")
    if "LABEL" not in viable(reading.table, reading.trail[at - 1]):
        return
    in_row = "LPAR" not in {c.symbol for c in opened(reading.trail[at - 1])}
    drop = 2 if token.kind == "EQUAL" else 1
    what = "the row's label" if in_row else "the argument's name"
    diagnostic = Diagnostic(
        "FZ109" if in_row else "FZ103",
        f"expected `:` after {what} `{_short(name.text)}`, found {wording.found(token, reading.table)}",
        token.span if drop == 2 else name.span,
        "write `:`" if drop == 2 else "needs a colon behind it",
        help=None if in_row else "an argument reads `NAME: VALUE`",
    )
    yield Repair(at - 1, diagnostic, 1.0, (label,), drop)


def _dropped(reading: Reading, at: int) -> Iterator[Repair]:
    token = reading.tokens[at]
    if token.kind == END:
        return
    if token.kind in _OPENERS and not any(CLOSERS[c.symbol] == token.kind for c in opened(stack_at(reading, at))):
        opener = reading.table.texts[_OPENERS[token.kind]]
        diagnostic = Diagnostic(
            "FZ106", f"this `{token.text}` closes nothing", token.span, f"no `{opener}` is open here"
        )
        yield Repair(at, diagnostic, 1.5, (), 1)
        return
    yield Repair(at, unexpected(reading, at), 2.5, (), 1)


# --- what they tell --------------------------------------------------------------------------


def unexpected(reading: Reading, at: int) -> Diagnostic:
    """The plain finding: what could stand here, and what does."""
    token = reading.tokens[at]
    cell = stack_at(reading, at)
    return Diagnostic(
        "FZ101",
        f"expected {wording.wanted(reading.table, cell)}, found {wording.found(token, reading.table)}",
        _place(reading, at),
        "not expected here" if _place(reading, at) == token.span and token.kind != END else "something is missing here",
        help=_decimal_comma(reading.tokens, at),
    )


def _decimal_comma(tokens: list[Token], at: int) -> str | None:
    """Three tokens ``1,5`` without a space are likely a number with a comma."""
    for i in range(max(0, at - 2), at + 1):
        three = tokens[i : i + 3]
        if [t.kind for t in three] == ["NUMBER", "COMMA", "NUMBER"] and three[0].end + 1 == three[2].start:
            return f"a decimal point is a dot: `{three[0].text}.{three[2].text}`"
    return None


def _place(reading: Reading, at: int) -> Span:
    """Where to point for a token that does not fit: at it, or behind the last word if it stands on a later line."""
    token = reading.tokens[at]
    if at and (token.first or token.kind == END):
        return _gap(reading, at)
    return token.span


def _gap(reading: Reading, at: int) -> Span:
    end = reading.tokens[at - 1].end if at else 0
    return Span(end, end)


def _lies_within(source: Source, token: Token, bracket: Cell) -> bool:
    """Whether a token that begins a line is indented deeper than the line that opens a bracket."""
    if not token.first or token.kind == END:
        return False
    return _indent(source, token.start) > _indent(source, bracket.start)


def _indent(source: Source, offset: int) -> int:
    line = source.line(source.position(offset)[0]).expandtabs(4)
    return len(line) - len(line.lstrip())


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
            if token.first and _indent(source, opener.start) != _indent(source, token.start):
                return opener, token
    return None


def _short(text: str) -> str:
    return text if len(text) <= 32 else text[:30] + ".."
