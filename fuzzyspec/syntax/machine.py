"""The stack machine that runs the parser's table.

Stacks are linked and never changed, so that a try costs nothing to take back: recovery looks ahead by running the
machine itself. Reductions are pure.
"""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.syntax import build_crisp, build_fuzzy
from fuzzyspec.syntax.builders import Node
from fuzzyspec.syntax.table import Production, Table
from fuzzyspec.syntax.tokens import END, MISSING, Token

_BUILDERS = build_fuzzy.BUILDERS | build_crisp.BUILDERS


class Cell:
    """Top of a stack: a state, the symbol that led to it, its value, and what lies below.

    ``viable`` is what can stand next, once that was asked (``viable``): it hangs on nothing but the stack.
    """

    __slots__ = ("below", "depth", "end", "start", "state", "symbol", "value", "viable")

    def __init__(self, state: int, symbol: str, value: Node, start: int, end: int, below: Cell | None) -> None:
        self.state = state
        self.symbol = symbol
        self.value = value
        self.start = start
        self.end = end
        self.below = below
        self.depth: int = 0 if below is None else below.depth + 1
        self.viable: frozenset[str] | None = None


class Joined:
    """Children that join the list of the rule above: kept as a chain until that rule takes them."""

    __slots__ = ("parts",)

    def __init__(self, parts: list[Node]) -> None:
        self.parts = parts


def bottom() -> Cell:
    """The empty stack, in the start state."""
    return Cell(0, "", None, 0, 0, None)


def terminal(table: Table, cell: Cell, token: Token) -> str:
    """What a token is in this state: a word is a keyword where that can stand, else a name."""
    if token.kind != "WORD":
        return token.kind
    keyword = table.keywords.get(token.text)
    actions = table.states[cell.state]
    if keyword is not None and (keyword in actions or "NAME" not in actions):
        return keyword
    return "NAME"


def advance(table: Table, cell: Cell, token: Token) -> Cell | None:
    """The stack after a token, or None where it cannot stand."""
    return advance_as(table, cell, token, terminal(table, cell, token))


def advance_as(table: Table, cell: Cell, token: Token, kind: str) -> Cell | None:
    """The stack after a token that is taken for the terminal ``kind``."""
    while True:
        if kind == END and cell.state == table.end:
            return Cell(cell.state, END, token, token.start, token.end, cell)
        action = table.states[cell.state].get(kind)
        if action is None:
            return None
        target, production = action
        if production is None:
            return Cell(target, kind, token, token.start, token.end, cell)
        cell = _reduce(table, cell, production)


def viable(table: Table, cell: Cell) -> frozenset[str]:
    """The terminals that can truly stand next (a table entry alone may be a reduction that leads nowhere)."""
    if cell.viable is None:
        kinds = (*(kind for kind in table.states[cell.state] if kind[0].isupper()), END)
        cell.viable = frozenset(kind for kind in kinds if _stands(table, cell, kind))
    return cell.viable


def _stands(table: Table, cell: Cell, kind: str) -> bool:
    """Whether ``advance_as`` would find a stack: the same steps over states alone, without the values."""
    pushed: list[int] = []
    under: Cell | None = cell
    while True:
        assert under is not None
        state = pushed[-1] if pushed else under.state
        if kind == END and state == table.end:
            return True
        action = table.states[state].get(kind)
        if action is None:
            return False
        _, production = action
        if production is None:
            return True
        for _ in production.symbols:
            if pushed:
                pushed.pop()
            else:
                assert under is not None
                under = under.below
        assert under is not None
        target, _ = table.states[pushed[-1] if pushed else under.state][production.origin]
        pushed.append(target)


def made(table: Table, kind: str, at: int) -> Token:
    """A token that nobody wrote, for a terminal: recovery's placeholder."""
    return Token("WORD" if kind == "NAME" else kind, _TEXTS.get(kind) or table.texts.get(kind, ""), at, at, False, True)


_TEXTS = {"NAME": MISSING, "NUMBER": "1", "LABEL": MISSING, "UNIT": "", "COMPARE": "<", END: ""}


def below(cell: Cell) -> Iterator[Cell]:
    """A stack from its top downwards."""
    at: Cell | None = cell
    while at is not None:
        yield at
        at = at.below


def opened(cell: Cell) -> list[Cell]:
    """The brackets that are open on a stack, innermost first; a pair may lie there whole, until its rule is reduced."""
    found: list[Cell] = []
    closed = 0
    for at in below(cell):
        if at.symbol in CLOSERS.values():
            closed += 1
        elif at.symbol in CLOSERS and closed:
            closed -= 1
        elif at.symbol in CLOSERS:
            found.append(at)
    return found


CLOSERS = {"LBRACE": "RBRACE", "LPAR": "RPAR", "LSQB": "RSQB"}


def _reduce(table: Table, cell: Cell, production: Production) -> Cell:
    count = len(production.symbols)
    values: list[Node] = []
    start, end = cell.end, cell.end
    for i in range(count - 1, -1, -1):
        if production.keep[i]:
            values.append(cell.value)
        start = cell.start
        assert cell.below is not None
        cell = cell.below
    values.reverse()
    value: Node
    if production.action == "*":
        value = Joined(values)
    elif production.action == "^":
        value = values[0]
    else:
        value = _BUILDERS[production.action](_flat(values), Span(start, end))
    target, _ = table.states[cell.state][production.origin]
    return Cell(target, production.origin, value, start, end, cell)


def _flat(values: list[Node]) -> list[Node]:
    """Children with joined lists laid out, without recursion: a list of n items is a chain n deep."""
    flat: list[Node] = []
    stack = values[::-1]
    while stack:
        value = stack.pop()
        if isinstance(value, Joined):
            stack.extend(reversed(value.parts))
        else:
            flat.append(value)
    return flat
