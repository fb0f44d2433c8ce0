"""The parser's table, read from ``table.json`` (see ``generate``)."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files


@dataclass(frozen=True, slots=True)
class Production:
    """``origin`` takes the place of ``symbols``; ``keep[i]`` tells whether child i is handed to ``action``."""

    origin: str
    action: str
    symbols: tuple[str, ...]
    keep: tuple[bool, ...]


Action = tuple[int, Production | None]
"""(next state, None) shifts or goes to; (0, production) reduces."""


@dataclass(frozen=True)
class Table:
    """LALR(1) actions of each state by symbol, and the keywords and punctuation by their text."""

    states: tuple[dict[str, Action], ...]
    end: int
    fixed: dict[str, str]
    keywords: dict[str, str]
    texts: dict[str, str]
    """The text of each keyword or mark by its terminal."""


@cache
def load() -> Table:
    """The table; state 0 is the start."""
    data = json.loads(files("fuzzyspec.syntax").joinpath("table.json").read_text(encoding="utf-8"))
    productions = [_production(line) for line in data["rules"]]
    fixed = {text: name for name, text in data["terminals"].items()}
    return Table(
        states=tuple(_state(line, productions) for line in data["states"]),
        end=data["end"],
        fixed=fixed,
        texts=data["terminals"],
        keywords={text: name for text, name in fixed.items() if text.isalpha()},
    )


def _production(line: str) -> Production:
    origin, _, action, *symbols = line.split()
    return Production(
        origin,
        action,
        tuple(s.strip("()") for s in symbols),
        tuple(not s.startswith("(") for s in symbols),
    )


def _state(line: str, productions: list[Production]) -> dict[str, Action]:
    row: dict[str, Action] = {}
    for cell in line.split():
        symbol, shift, target = cell.partition(">")
        if shift:
            row[symbol] = (int(target), None)
        else:
            symbol, _, target = cell.partition("<")
            row[symbol] = (0, productions[int(target)])
    return row
