"""What can stand at a place and what was found there, in a user's words."""

from __future__ import annotations

from fuzzyspec.syntax.machine import Cell, viable
from fuzzyspec.syntax.table import Table
from fuzzyspec.syntax.tokens import END, Token

_AFTER = {
    "MODULE": "the module's name",
    "CONTROLLER": "the controller's name",
    "SYSTEM": "the system's name",
    "INPUT": "the input's name",
    "OUTPUT": "the output's name",
    "TERM": "the term's name",
    "PARTITION": "the names of the terms",
    "SINGLETONS": "the names of the terms",
    "BEHAVIOR": "the behavior's name",
    "TABLE": "the output that the table sets",
    "BY": "the inputs of the table",
    "IS": "a term",
    "THEN": "an output and its term, as in `v is FAST`",
    "WITH": "a weight, as in `with 0.8`",
    "PRIORITY": "a number",
    "AT": "a number",
    "RAW": "a raw type: `uint16`, `int16`, `uint8` or `int8`",
    "STEP": "the size of one step",
    "EACH": "a name for the element",
    "LET": "a name",
    "PARAM": "the parameter's name",
    "UNIT_WORD": "the unit's name",
    "INITIAL": "the value to hold at first",
    "ON": "a machine, as in `on cortex-m0plus`",
    "DOT": "a name after the dot",
    "DOTS": "the count at the high end",
}
"""What follows a terminal wherever it stands."""

_WITHIN = {
    ("COMMA", "placed_term"): "the next term and its peak, as in `B at 2`",
    ("COMMA", "__placing_star_5"): "the next term and its peak, as in `B at 2`",
    ("COMMA", "names"): "another name",
    ("COMMA", "consequent"): "another output and its term, as in `w is SLOW`",
    ("COMMA", "_consequents"): "another output and its term, as in `w is SLOW`",
    ("COMMA", "limit"): "another limit, as in `stack <= 64 B`",
    ("LBRACE", "BUDGET"): "a limit, as in `flash <= 1 KiB`",
    ("EQUAL", "NAME"): "a value",
    ("EQUAL", "target"): "a value",
}
"""What follows a terminal after the symbol before it."""

_BLOCKS = {
    "CONTROLLER": "a controller",
    "SYSTEM": "a system",
    "TABLE": "a table",
    "BEHAVIOR": "a behavior",
    "RULES": "`rules`",
    "INFER": "`infer`",
    "BUDGET": "a budget",
    "EACH": "a `for each`",
    "INPUT": "the terms of a variable",
    "OUTPUT": "the terms of a variable",
    "LSQB": "a list's record",
}
"""Blocks by a symbol below their brace."""

_ONLY = {
    ("IN", "LSQB"): "a range, as in `[0, 1]`",
    ("IN", "LBRACE"): "terms in braces, as in `{A, B}`",
    ("IN", "NAME"): "the name of a list",
    ("NOT", "NAME"): "a term",
    ("NAME", "COMPARE"): "`<=`",
    ("LABEL", "NAME"): "a term",
    ("COLON", "NAME"): "a term",
}
"""What follows a terminal where only one thing can."""

_VALUE = frozenset({"NUMBER", "NAME", "LPAR", "MINUS"})
_OPERATORS = frozenset({"PLUS", "MINUS", "STAR", "SLASH", "COMPARE", "AND", "OR", "NOT", "IN", "IF", "OTHERWISE"})
_ARITHMETIC = frozenset({"PLUS", "STAR"})
_DECLARATIONS = frozenset({"CONTROLLER", "SYSTEM", "UNIT_WORD", "PARAM"})
_CONTROLLER = frozenset({"INPUT", "OUTPUT", "TABLE", "BEHAVIOR", "RULES", "INFER", "FIRES", "BUDGET"})
_SYSTEM = frozenset({"PARAM", "INPUT", "LET", "FOR", "OUTPUT", "BUDGET"})
_MEMBERS = frozenset({"PARTITION", "SINGLETONS", "TERM", "OTHERWISE"})

_GROUPS = (
    (
        _CONTROLLER,
        "an item of the controller (`input`, `output`, `table`, `behavior`, `rules`, `infer`, `fires at`, `budget`)",
    ),
    (_SYSTEM, "an item of the system (`param`, `input`, `for each`, `let`, `output`, `budget`)"),
    (_DECLARATIONS, "`controller`, `system`, `param` or `unit`"),
    (_MEMBERS, "terms (`partition`, `term`, `singletons`) or `otherwise`"),
)


_NAMED = {
    "NAME": "a name",
    "LABEL": "a row's label with its colon",
    "NUMBER": "a number",
    "UNIT": "a unit",
    "COMPARE": "a comparison",
    END: "the end of the file",
}


def wanted(table: Table, cell: Cell) -> str:
    """What can stand after a stack: ``a term``, ``` `,` or `]` ```."""
    if cell.symbol in _AFTER:
        return _AFTER[cell.symbol]
    below = cell.below.symbol if cell.below else ""
    if (cell.symbol, below) in _WITHIN:
        return _WITHIN[cell.symbol, below]
    if cell.below is None:
        return "`module` and a name"
    kinds = viable(table, cell)
    if len(kinds) == 1 and (phrase := _ONLY.get((cell.symbol, next(iter(kinds))))):
        return phrase
    return listed(table, kinds)


def listed(table: Table, kinds: frozenset[str]) -> str:
    """A set of terminals as a phrase, what belongs together under one name."""
    rest = set(kinds)
    phrases: list[str] = []
    if rest >= _VALUE | {"NOT"} or rest >= _VALUE:
        phrases.append("a value")
        rest -= _VALUE | {"NOT", "LABEL"}
    elif rest >= {"NAME", "LPAR", "NOT"}:
        phrases.append("a condition, as in `x is LOW`")
        rest -= {"NAME", "LPAR", "NOT"}
    if rest >= _MEMBERS | {"NAME"}:
        phrases.append("another term")
        rest -= {"NAME"}
    for group, phrase in _GROUPS:
        if rest >= group:
            phrases.append(phrase)
            rest -= group
    operators = rest >= _ARITHMETIC
    if operators:
        rest -= _OPERATORS | {"DOT", "LPAR", "UNIT", "NAME"}
        if phrases:
            phrases = ["an operator", "another item"]
            operators = False
    order = sorted(rest, key=lambda k: (k not in _NAMED, k.isalpha() and len(table.texts.get(k, "")) > 1, k))
    phrases += [_NAMED.get(k) or f"`{table.texts[k]}`" for k in order]
    if END in kinds and len(phrases) > 1:
        phrases.remove(_NAMED[END])
    if operators and (len(phrases) > 3 or not phrases):
        phrases.append("an operator")
    return joined(phrases[:6])


def joined(phrases: list[str]) -> str:
    """``a``, ``a or b``, ``a, b or c``."""
    if len(phrases) < 2:
        return "".join(phrases)
    return f"{', '.join(phrases[:-1])} or {phrases[-1]}"


def block(brackets: list[Cell]) -> str:
    """Where something stands, by the innermost open block: ``in a controller``."""
    at: Cell | None = next((b for b in brackets if b.symbol == "LBRACE"), None)
    while at is not None:
        if at.symbol in _BLOCKS:
            return f"in {_BLOCKS[at.symbol]}"
        at = at.below
    return "at the top level"


def found(token: Token, table: Table) -> str:
    """A token as a user would call it."""
    match token.kind:
        case "$END":
            return "the end of the file"
        case "NUMBER":
            return f"the number `{token.text}`"
        case "UNIT":
            return f"the unit `{token.text}`"
        case "LABEL":
            return f"`{token.text}:`"
        case "WORD" if token.text in table.keywords:
            return f"the keyword `{token.text}`"
        case _:
            return f"`{token.text}`"
