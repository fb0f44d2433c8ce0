"""One small change to a file's tokens, and what would be told of it."""

from __future__ import annotations

from dataclasses import dataclass, field

from fuzzyspec.diagnostics.diagnostic import Diagnostic
from fuzzyspec.syntax.tokens import Token

SURE = -4.0
"""The cost of an edit that is right even where more is wrong behind it."""


@dataclass(frozen=True, slots=True)
class Edit:
    """``tokens[at : at + drop]`` becomes ``insert``; ``swaps`` replaces single tokens further on."""

    at: int
    diagnostic: Diagnostic
    cost: float
    insert: tuple[Token, ...] = ()
    drop: int = 0
    swaps: dict[int, Token] = field(default_factory=dict)
