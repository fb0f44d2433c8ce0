"""What was probably meant, where that can be guessed from a few words: the help of a token that does not fit."""

from __future__ import annotations

from fuzzyspec.syntax import wording
from fuzzyspec.syntax.machine import Cell, opened, viable
from fuzzyspec.syntax.reading import Reading, stack_at
from fuzzyspec.syntax.tokens import Token

_CHOICE = "a choice reads `a if TEST else b`"
_TERMS = "the terms of a controller's input or output stand in braces: `{ partition LOW MID HIGH }`"
_CELLS = "each cell of a table names a term; cells that are to stay open are left to the rules of a `behavior`"


def hint(reading: Reading, at: int) -> str | None:
    """The likeliest way out, or None."""
    token = reading.tokens[at]
    cell = stack_at(reading, at)
    before = reading.tokens[at - 1] if at else None
    block = wording.block(opened(cell))
    computes = block in ("in a system", "in a `for each`")
    kinds = viable(reading.table, cell)
    if before is None and token.kind != "$END":
        return "a spec begins with `module NAME`, then has at least one `controller`"
    match cell.symbol, token.kind, token.text:
        case _, "NUMBER" | "COMMA", _ if (first := number_with_comma(reading.tokens, at)) is not None:
            return f"a decimal point is a dot: `{reading.tokens[first].text}.{reading.tokens[first + 2].text}`"
        case _, _, "where":
            return "a condition in a fold begins with `if`"
        case _, "WORD", "if" | "then" | "else" if computes:
            return _CHOICE
        case _, _, "+":
            return "numbers have no plus sign"
        case "IN", "NUMBER" | "MINUS", _:
            return "a range has both ends in square brackets: `[0, 1]`"
        case _, "COMMA", _ if block == "in a table":
            return "several labels stand in parentheses, `(S, S):`; an entry's outputs are separated by `/`"
        case _, _, "=" if block == "in a table":
            return "a row reads `LABEL: TERM`"
        case _, "NUMBER" | "MINUS", _ if block == "in a table":
            return _CELLS
        case _, "RBRACE", _ if block == "in a table":
            return "a table has at least one row: a label with its colon, then the terms"
        case _, "SLASH" | "STAR", _ if before is not None and before.kind == "UNIT":
            return "a unit is written without spaces: `m/s`"
        case "LPAR", _, _ if cell.below is not None and cell.below.symbol == "POINTS":
            return "the points are pairs: `points((0, 0), (5, 1), (10, 0))`"
        case _, "COMMA", _ if _in_pair(cell) and block == "in the terms of a variable":
            return "only `points` takes pairs: `points((0, 0), (5, 1))`"
        case _, "COMMA", _ if block == "in the terms of a variable" and "FULL" in kinds:
            return "the terms of an even partition have no commas between them; placed ones have: `A at 0, B at 2`"
        case "COMMA", "RBRACE" | "RPAR" | "RSQB", _:
            return "there is no comma behind the last item"
        case "COMMA", "WORD", "in" | "by":
            return "there is no comma behind the last name"
        case _, "WORD", "else" if "THEN" in kinds or "WITH" in kinds:
            return "a rule has no `else`: write a second rule with the opposite condition"
        case _, "COMPARE", _ if "IS" in kinds:
            return "a condition asks for a term: `x is A`, `x is not A` or `x in {A, B}`"
        case _, "RSQB", _ if _in_range(cell):
            return "a range has both ends: `[0, 1]`"
        case _, "COMMA", _ if _in_range(cell):
            return "a range has two ends: `[0, 1]`"
        case "LSQB", "RSQB", _:
            return "a list has a bound on its length: `obstacles[16]`"
        case _ if block == "in a list's record" and cell.symbol in ("LBRACE", "COMMA"):
            return "a field reads `distance in [0, 8] m`, and commas stand between fields"
        case _, "LBRACE", _ if computes and "RAW" in kinds:
            return "inputs and outputs of a system have no terms: those belong to the controllers that it calls"
        case _ if "LBRACE" in kinds and "RAW" in kinds:
            return _TERMS
        case _ if computes and {"EQUAL", "RAW"} <= kinds:
            return "an output gets its value by `output NAME = VALUE`"
        case _, "LABEL" | "NUMBER", _ if "IF" in kinds:
            return "rules have no names or numbers: each begins with `if`"
        case _, "LABEL", _ if "IS" in kinds or cell.symbol == "IS":
            return "a rule reads `if x is A then y is B`"
        case _, "LSQB" | "LPAR", _ if "WITH" in kinds:
            return "a weight is written `with 0.8`"
        case _, "WORD", _ if cell.symbol == "NAME" and "THEN" in kinds:
            return "a condition names one term; there are no hedges such as `very`"
        case "IN", "WORD", _ if computes:
            return "a fold reads `max(o.x for o in LIST, otherwise 0)`"
        case _, "WORD" | "EQUAL" | "COLON", _ if {"COMMA", "IN"} <= kinds and "IS" not in kinds:
            return "an input or output has its range behind `in`: `x in [0, 8] m`"
        case _, "MINUS" | "DOT", _ if {"COMMA", "IN"} <= kinds:
            return "a name has letters, digits and `_`"
        case _ if "DOTS" in kinds:
            return "counts have both ends: `raw uint16 0..4095`; a step is written `raw int16 step 0.01`"
        case symbol, "NUMBER", _ if symbol in _NAMES:
            return "a name begins with a letter"
        case _, "DOT", _ if computes:
            return "a name has one dot at most: give the part a name by `let`"
        case _:
            return None


def _in_range(cell: Cell) -> bool:
    """Whether the innermost bracket is that of a range."""
    innermost = next(iter(opened(cell)), None)
    return innermost is not None and innermost.below is not None and innermost.below.symbol == "IN"


def _in_pair(cell: Cell) -> bool:
    """Whether the innermost two brackets are parentheses within parentheses."""
    return [c.symbol for c in opened(cell)[:2]] == ["LPAR", "LPAR"]


_NAMES = frozenset(
    {
        "MODULE",
        "CONTROLLER",
        "SYSTEM",
        "INPUT",
        "OUTPUT",
        "TERM",
        "PARTITION",
        "BEHAVIOR",
        "TABLE",
        "PARAM",
        "LET",
        "IS",
    }
)


def number_with_comma(tokens: list[Token], at: int) -> int | None:
    """Where, near an error, three tokens ``1,5`` stand without a space: likely one number."""
    for first in range(max(0, at - 3), at + 1):
        three = tokens[first : first + 3]
        if [t.kind for t in three] != ["NUMBER", "COMMA", "NUMBER"] or "." in three[0].text + three[2].text:
            continue
        if three[0].end == three[1].start and three[1].end == three[2].start:
            return first
    return None
