"""The kinds of small edit that recovery tries, each with the diagnostic that tells of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Span
from fuzzyspec.syntax import habits, wording
from fuzzyspec.syntax.edit import SURE, Edit
from fuzzyspec.syntax.findings import unclosed, unexpected
from fuzzyspec.syntax.machine import CLOSERS, Cell, advance, below, made, opened, terminal, viable
from fuzzyspec.syntax.reading import (
    BEGINS,
    OPENERS,
    Reading,
    gap,
    keywords_as_names,
    lies_within,
    partner,
    place,
    stack_at,
)
from fuzzyspec.syntax.spelling import near
from fuzzyspec.syntax.table import Table
from fuzzyspec.syntax.tokens import END, Token

_MARKS = frozenset({"COMMA", "COLON", "EQUAL", "LBRACE", "LPAR", "LSQB", "SLASH", "DOTS"})
_INNER_WORDS = frozenset(
    {"AND", "IN", "IS", "THEN", "AT", "BY", "PRIORITY", "EACH", "ELSE", "INITIAL", "OTHERWISE", "FOR", "ON"}
)
_FIRST_WORDS = frozenset({"MODULE", "CONTROLLER", "SYSTEM", "IF", "LET", "TERM", "PARTITION"})
_REPLACEABLE = _MARKS | set(OPENERS) | {"COMPARE", "DOT", "AND", "IS", "IN", "FOR"}
_FUNCTIONS = frozenset({"min", "max", "clamp", "abs", "sum", "count"})
CAPITALS = "keywords are written in small letters"
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
    "ON": "a limit on one machine reads `flash <= 1 KiB on cortex-m4`",
    "OTHERWISE": "what holds where nothing passes: `max(o.x for o in LIST if TEST, otherwise 0)`",
    "DOTS": "counts have both ends: `raw uint16 0..4095`; a step is written `raw int16 step 0.01`",
}


def candidates(reading: Reading, index: int) -> Iterator[Edit]:
    """Every edit worth trying for the token at ``index``, which does not fit."""
    yield from _misspelt(reading, index)
    yield from habits.foreign_word(reading, index)
    yield from habits.decimal_comma(reading, index)
    yield from habits.brace_too_many(reading, index)
    yield from habits.set_without_braces(reading, index)
    yield from habits.undeclared(reading, index)
    yield from habits.unit_in_brackets(reading, index)
    yield from habits.at_most(reading, index)
    yield from habits.hyphen(reading, index)
    yield from _closed(reading, index)
    yield from _inserted(reading, index)
    yield from _replaced(reading, index)
    yield from _relabelled(reading, index)
    yield from _dropped(reading, index)
    yield from _rest_of_line(reading, index)
    yield from _emptied(reading, index)
    if index > 0:
        yield from _misspelt(reading, index - 1)
        yield from _misspelt_before(reading, index)
        yield from habits.misspelt_points(reading, index)
        yield from _unit_as_name(reading, index)
        yield from _unit_as_keyword(reading, index)
    for j in keywords_as_names(reading, index):
        tried = (_closed, _inserted, _dropped, _dropped_before, _rest_of_line)
        for edit in (e for kind in tried for e in kind(reading, j)):
            yield replace(edit, cost=edit.cost - 1)


def _misspelt(reading: Reading, at: int) -> Iterator[Edit]:
    token = reading.tokens[at]
    if token.kind != "WORD" or token.made:
        return
    cell = stack_at(reading, at)
    kinds = viable(reading.table, cell)
    message = f"expected {wording.wanted(reading.table, cell)}, found {wording.found(token, reading.table)}"
    if token.text not in reading.table.keywords:
        texts = [t for t, kind in reading.table.keywords.items() if kind in kinds]
        for text in near(token.text, texts):
            case = CAPITALS if text == token.text.lower() else None
            told = Diagnostic("FZ102", message, token.span, f"did you mean `{text}`?", help=case)
            yield Edit(at, told, SURE if case else 0.5, (token._replace(text=text),), 1)
    if "PLUS" in kinds or kinds & BEGINS or reading.table.keywords.get(token.text) in BEGINS - {"FOR", "IF"}:
        return
    for kind in sorted(kinds & (_INNER_WORDS - {"AND"} | {"IF"})):
        text = reading.table.texts[kind]
        told = Diagnostic(
            "FZ102", message, token.span, f"write `{text}`", help=_HINTS.get(kind) if kind != "IF" else None
        )
        yield Edit(at, told, 2.0, (token._replace(text=text),), 1)


def _misspelt_before(reading: Reading, at: int) -> Iterator[Edit]:
    """A keyword that was read as a name two or three tokens ago: ``B otherwsie hold initial 0``."""
    for j in range(max(1, at - 3), at - 1):
        token = reading.tokens[j]
        if token.kind == "WORD" and not token.made and token.text not in reading.table.keywords:
            kinds = viable(reading.table, stack_at(reading, j)) & BEGINS
            for text in near(token.text, [t for t, kind in reading.table.keywords.items() if kind in kinds]):
                message = f"expected {wording.listed(reading.table, kinds)}, found `{token.text}`"
                told = Diagnostic("FZ102", message, token.span, f"did you mean `{text}`?")
                yield Edit(j, told, 1.0, (token._replace(text=text),), 1)


def _closed(reading: Reading, at: int) -> Iterator[Edit]:
    """Brackets that were never closed, from the innermost outwards."""
    cell = stack_at(reading, at)
    token = reading.tokens[at]
    open_cells = opened(cell)
    if not open_cells:
        return
    start = reading.tokens[at - 1].end
    operand = made(reading.table, "NAME", start)
    balanced = 3 if _balanced(reading.tokens) else 0
    for first in ((), (operand,)):
        inserted: list[Token] = list(first)
        for count, bracket in enumerate(open_cells, start=1):
            inserted.append(made(reading.table, CLOSERS[bracket.symbol], start))
            cost = 1.0 + count / 2 + 2 * len(first) + balanced
            if lies_within(reading.source, token, bracket):
                cost += 4
            yield Edit(at, unclosed(reading, open_cells[:count], at), cost, tuple(inserted))


def _balanced(tokens: list[Token]) -> bool:
    """Whether each bracket of the file has its partner, so that one more would have none."""
    stack: list[str] = []
    for token in tokens:
        if token.kind in CLOSERS:
            stack.append(CLOSERS[token.kind])
        elif token.kind in OPENERS and (not stack or stack.pop() != token.kind):
            return False
    return not stack


def _inserted(reading: Reading, at: int) -> Iterator[Edit]:
    """A mark, a word or a name that was left out."""
    cell = stack_at(reading, at)
    token = reading.tokens[at]
    start = reading.tokens[at - 1].end if at else 0
    kinds = viable(reading.table, cell)
    arithmetic = "PLUS" in kinds
    name = made(reading.table, "NAME", start)
    for kind in sorted(kinds & (_MARKS | _INNER_WORDS | _FIRST_WORDS)):
        in_points = cell.below is not None and cell.below.symbol == "POINTS"
        arguments = kind == "LPAR" and token.kind == "LABEL"
        if kind in ("LPAR", "LSQB") and (in_points or not (arguments or _closes_ahead(reading, at, kind))):
            continue
        if kind == "AND" and token.first:
            continue
        if kind in ("CONTROLLER", "SYSTEM") and (kind == "SYSTEM") != _computes(reading.tokens, at):
            continue
        if (kind == "SLASH" and arithmetic) or (kind == "OTHERWISE" and cell.symbol != "COMMA"):
            continue
        text = reading.table.texts[kind]
        first = kind in _FIRST_WORDS
        row = " after the row's label" if kind == "COLON" else ""
        behind = kind == "COLON" or (kind == "COMMA" and token.first)
        where = token.span if first else gap(reading, at) if behind else place(reading, at)
        told = Diagnostic(
            "FZ109" if kind == "COLON" else "FZ103",
            f"expected `{text}`{row}, found {wording.found(token, reading.table)}",
            where,
            f"`{text}` is missing before this" if first else f"`{text}` is missing here",
            help="write `fires at 1/64`" if cell.symbol == "FIRES" else _HINTS.get(kind),
        )
        put = _token(reading.table, kind, start)
        yield Edit(at, told, 1.0 if kind in _MARKS else 1.5, (put,))
        if kind in _INNER_WORDS:
            yield Edit(at, told, 3.5, (put, name))
    for kind in ("NAME", "NUMBER"):
        if kind in kinds:
            yield Edit(at, unexpected(reading, at), 2.0, (made(reading.table, kind, start),))
            break
    if cell.symbol == "THEN":
        yield Edit(at, unexpected(reading, at), 2.0, (name, _token(reading.table, "IS", start), name))


def _computes(tokens: list[Token], at: int) -> bool:
    """Whether the block ahead looks like a system's: it has a word that no controller has."""
    brace = next((i for i in range(at, min(at + 3, len(tokens))) if tokens[i].kind == "LBRACE"), None)
    end = None if brace is None else partner(tokens, brace)
    return brace is not None and any(t.text in ("let", "param", "for") for t in tokens[brace:end])


def _closes_ahead(reading: Reading, at: int, opener: str) -> bool:
    """Whether the rest of the line holds the partner of a bracket that may have been left out."""
    depth = 0
    for i in range(at, min(at + 64, len(reading.tokens))):
        token = reading.tokens[i]
        if (token.first and i > at) or (token.kind in OPENERS and i == at):
            return False
        depth += (token.kind in CLOSERS) - (token.kind in OPENERS)
        if depth < 0:
            return token.kind == CLOSERS[opener]
    return False


def _token(table: Table, kind: str, at: int) -> Token:
    """A mark or keyword put in; a keyword goes in as a word, which the machine then takes for what fits."""
    token = made(table, kind, at)
    return token._replace(kind="WORD") if token.text.isalpha() else token


def _replaced(reading: Reading, at: int) -> Iterator[Edit]:
    """One mark for another: ``=`` for ``:``, ``(`` for ``[`` with its partner."""
    token = reading.tokens[at]
    cell = stack_at(reading, at)
    kind = terminal(reading.table, cell, token)
    kinds = viable(reading.table, cell)
    if kind not in _REPLACEABLE or token.made:
        return
    for other in sorted(kinds & (_MARKS | set(OPENERS) | {"COMPARE", "IS", "THEN"}) - {kind}):
        if (kind in CLOSERS) != (other in CLOSERS) or (other in ("IS", "THEN") and kind not in ("COMPARE", "EQUAL")):
            continue
        if (other == "COMPARE" and kind != "EQUAL") or (other == "SLASH" and "PLUS" in kinds):
            continue
        if other in OPENERS and kind not in OPENERS:
            continue
        text = "==" if other == "COMPARE" else reading.table.texts[other]
        swaps: dict[int, Token] = {}
        end = partner(reading.tokens, at) if kind in CLOSERS else None
        if kind == "LBRACE" and end is not None and _is_block(reading.tokens, at, end):
            continue
        if end is not None:
            closer = CLOSERS[other]
            swaps[end] = reading.tokens[end]._replace(kind=closer, text=reading.table.texts[closer])
        told = Diagnostic(
            "FZ101",
            f"expected {wording.wanted(reading.table, cell)}, found {wording.found(token, reading.table)}",
            token.span,
            f"write `{text}`" if not swaps else f"write `{text}` .. `{reading.table.texts[CLOSERS[other]]}`",
            help=_reason(kind, other, cell),
        )
        new = token._replace(kind="WORD" if text.isalpha() else other, text=text)
        yield Edit(at, told, 1.0, (new,), 1, swaps)


def _is_block(tokens: list[Token], start: int, end: int) -> bool:
    """Whether a pair of brackets spans lines."""
    return any(token.first for token in tokens[start + 1 : end + 1])


def _reason(kind: str, other: str, cell: Cell) -> str | None:
    match kind, other:
        case "AND", "COMMA" if wording.block(opened(cell)) == "in a budget":
            return "the limits of a budget are separated by commas"
        case "AND", "COMMA":
            return "the outputs that one rule sets are separated by commas"
        case "EQUAL", "COMPARE":
            return "`=` gives a name, `==` compares"
        case (("EQUAL" | "COMPARE"), "IS"):
            return "a condition reads `x is A`, `x is not A` or `x in {A, B}`"
        case "LPAR", "LSQB" if cell.symbol == "IN":
            return "a range stands in square brackets; both ends belong to it"
        case "LPAR", "LSQB":
            return "the bound of a list stands in square brackets: `obstacles[16]`"
        case (("LPAR" | "LSQB"), "LBRACE"):
            return "blocks and sets of terms stand in braces"
        case "DOTS", "COMMA":
            return "the ends of a range are separated by a comma: `[0, 1]`"
        case _:
            return None


def _relabelled(reading: Reading, at: int) -> Iterator[Edit]:
    """A colon too many or too few between a name and what follows."""
    token = reading.tokens[at]
    next_row = token.first and "TABLE" in (c.symbol for c in below(stack_at(reading, at)))
    if token.kind == "LABEL" and not token.made and not next_row:
        word = token._replace(kind="WORD", end=token.start + len(token.text))
        after = advance(reading.table, stack_at(reading, at), word)
        if after is not None:
            colon = Span(token.end - 1, token.end)
            message = f"expected {wording.wanted(reading.table, after)}, found `:`"
            for kind in ("EQUAL", "IS", "IN"):
                mark = _token(reading.table, kind, token.end)
                yield Edit(at, Diagnostic("FZ101", message, colon, f"write `{mark.text}`"), 1.0, (word, mark), 1)
            yield Edit(at, Diagnostic("FZ101", message, colon, "leave the colon out"), 1.2, (word,), 1)
    if at == 0 or reading.tokens[at - 1].kind != "WORD":
        return
    name = reading.tokens[at - 1]
    before = stack_at(reading, at - 1)
    if "LABEL" not in viable(reading.table, before) or _is_builtin(before):
        return
    in_row = "LPAR" not in {c.symbol for c in opened(before)}
    drop = 2 if token.kind == "EQUAL" else 1
    what = "the row's label" if in_row else "the argument's name"
    told = Diagnostic(
        "FZ109" if in_row else "FZ103",
        f"expected `:` after {what} `{name.text}`, found {wording.found(token, reading.table)}",
        token.span if drop == 2 else name.span,
        "write `:`" if drop == 2 else "needs a colon behind it",
        help="a row reads `LABEL: TERM ..`" if in_row else "an argument reads `NAME: VALUE`",
    )
    yield Edit(at - 1, told, 0.9, (name._replace(kind="LABEL"),), drop)


def _is_builtin(cell: Cell) -> bool:
    """Whether the innermost bracket holds the arguments of a function, which have no names."""
    callee = next((c.below for c in opened(cell)), None)
    return callee is not None and isinstance(callee.value, Token) and callee.value.text in _FUNCTIONS


def _unit_as_name(reading: Reading, at: int) -> Iterator[Edit]:
    """A name behind a number that was read as its unit: ``A at 0 B at 1``."""
    unit = reading.tokens[at - 1]
    if unit.kind != "UNIT" or not unit.text.isidentifier() or unit.made:
        return
    word = unit._replace(kind="WORD")
    comma = made(reading.table, "COMMA", unit.start)
    told = Diagnostic("FZ103", f"expected `,` before `{unit.text}`", unit.span, "`,` is missing before this")
    yield Edit(at - 1, told, 1.0, (comma, word), 1)


def _unit_as_keyword(reading: Reading, at: int) -> Iterator[Edit]:
    """A misspelt keyword that was read as a number's unit: ``let a = b / 2``, ``ouput c = a``; ``[0, 1] arw int8``."""
    unit = reading.tokens[at - 1]
    if unit.kind != "UNIT" or unit.made:
        return
    wanted = BEGINS if unit.first else frozenset({"RAW", "STEP", "ON"})
    kinds = viable(reading.table, stack_at(reading, at - 1)) & wanted
    for text in near(unit.text, [t for t, kind in reading.table.keywords.items() if kind in kinds]):
        case = CAPITALS if text == unit.text.lower() else None
        message = f"expected {'an item' if unit.first else f'`{text}`'}, found `{unit.text}`"
        told = Diagnostic("FZ102", message, unit.span, f"did you mean `{text}`?", help=case)
        yield Edit(at - 1, told, SURE if case else 0.5, (unit._replace(kind="WORD", text=text),), 1)


def _dropped(reading: Reading, at: int) -> Iterator[Edit]:
    token = reading.tokens[at]
    if token.kind == END:
        return
    open_kinds = [c.symbol for c in opened(stack_at(reading, at))]
    if token.kind in OPENERS and OPENERS[token.kind] not in open_kinds:
        yield Edit(at, unexpected(reading, at), 1.5, (), 1)
        return
    told = unexpected(reading, at)
    yield Edit(at, told, 5.0 if token.kind in OPENERS or token.kind in CLOSERS else 2.5, (), 1)
    if token.kind in ("SLASH", "STAR", "DOT") and reading.tokens[at + 1].kind != END:
        yield Edit(at, told, 3.0, (), 2)


def _dropped_before(reading: Reading, at: int) -> Iterator[Edit]:
    """What led up to a keyword that was read as a name: ``and`` in ``x is A and then``."""
    if at > 0 and reading.tokens[at - 1].kind in ("WORD", "COMMA"):
        yield Edit(at - 1, unexpected(reading, at), 2.5, (), 1)


def _rest_of_line(reading: Reading, at: int) -> Iterator[Edit]:
    """What stands from here to the end of the line or of the bracket around it, or a name in its place."""
    depth = 0
    end = at
    while reading.tokens[end].kind != END and (end == at or not reading.tokens[end].first):
        kind = reading.tokens[end].kind
        if kind in OPENERS and depth == 0:
            break
        depth += (kind in CLOSERS) - (kind in OPENERS)
        end += 1
    if depth or end == at:
        return
    told = unexpected(reading, at)
    start = reading.tokens[at].start
    number = made(reading.table, "NUMBER", start)
    pair = [made(reading.table, kind, start) for kind in ("LPAR", "COMMA", "RPAR")]
    for insert in ((), (made(reading.table, "NAME", start),), (pair[0], number, pair[1], number, pair[2])):
        yield Edit(at, told, 4.5 + len(insert) / 5, insert, end - at)


def _emptied(reading: Reading, at: int) -> Iterator[Edit]:
    """All that stands in the parentheses or brackets around the error, with a number in its place."""
    near_by = range(max(0, at - 64), at)
    starts = {reading.tokens[i].start: i for i in near_by if reading.tokens[i].kind in CLOSERS}
    for count, bracket in enumerate(opened(stack_at(reading, at))):
        first = starts.get(bracket.start)
        if bracket.symbol == "LBRACE" or first is None:
            return
        end = partner(reading.tokens, first)
        if end is None:
            continue
        number = made(reading.table, "NUMBER", bracket.end)
        told = unexpected(reading, at)
        opens, comma, closes = (made(reading.table, kind, bracket.end) for kind in ("LPAR", "COMMA", "RPAR"))
        for insert in ((number,), (number, comma, number), (opens, number, comma, number, closes)):
            yield Edit(first + 1, told, 4.0 + count / 2, insert, end - first - 1)
