"""The small edit by which a file was most likely meant.

At an error every candidate is tried by running the machine on over the tokens behind it. The one that carries
furthest for the least change is taken, so the rest of the file is still read, and told of in its own right.
"""

from __future__ import annotations

from fuzzyspec.syntax.edit import SURE, Edit
from fuzzyspec.syntax.edits import candidates
from fuzzyspec.syntax.machine import Cell, advance, terminal
from fuzzyspec.syntax.reading import BEGINS, Reading, stack_at
from fuzzyspec.syntax.tokens import END, Token

_REACH = 6
"""Tokens behind an edit that are tried at most."""
_LEAST_REACH = 2
"""Tokens that have to fit behind an edit for it to be taken."""


def best(reading: Reading, index: int) -> Edit | None:
    """The edit that carries furthest for the least, or None where none carries far enough."""
    chosen: Edit | None = None
    chosen_score = 0.0
    for edit in candidates(reading, index):
        reach = _reach(reading, edit, index)
        if reach >= (0 if edit.cost == SURE else _LEAST_REACH) and reach - edit.cost > chosen_score:
            chosen, chosen_score = edit, reach - edit.cost
    return chosen


def _begins_item(reading: Reading, cell: Cell, token: Token) -> bool:
    """Whether a keyword that begins a line would be read as a name."""
    kind = reading.table.keywords.get(token.text) if token.kind == "WORD" else None
    return kind in BEGINS and terminal(reading.table, cell, token) == "NAME"


def _reach(reading: Reading, edit: Edit, index: int) -> int:
    """How many tokens behind the edit, and not before the error, can be read; the end of the file is the furthest."""
    cell: Cell | None = stack_at(reading, edit.at)
    for token in edit.insert:
        assert cell is not None
        cell = advance(reading.table, cell, token)
        if cell is None:
            return 0
    resumed = edit.at + edit.drop
    goal = max(index, resumed)
    for i in range(resumed, min(goal + _REACH, len(reading.tokens))):
        token = edit.swaps.get(i, reading.tokens[i])
        assert cell is not None
        if token.first and i > goal and _begins_item(reading, cell, token):
            return i - goal
        cell = advance(reading.table, cell, token)
        if cell is None:
            return i - goal + (token.first and i > goal)
        if token.kind == END:
            return _REACH
    return _REACH
