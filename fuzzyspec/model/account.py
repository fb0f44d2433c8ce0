"""How the rules of a controller shared its cells: what the behaviors started, and what priorities left of it."""

from __future__ import annotations

from dataclasses import dataclass

from fuzzyspec.diagnostics.diagnostic import Span


@dataclass(frozen=True, slots=True)
class RuleAccount:
    """One written rule over cells: a sentence of a behavior, or a table's entry.

    ``owner`` is the code of its behavior, 0 in a controller without behaviors.
    """

    owner: int
    started: int
    executed: int
    span: Span


@dataclass(frozen=True, slots=True)
class BehaviorAccount:
    """Cells of one behavior, each counted once: ``started == executed + sum of lost``.

    ``lost`` names the winners by code, the highest priority first, with the cells that each took.
    """

    code: int
    started: int
    executed: int
    lost: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class Account:
    """The accounting of a controller's cells.

    ``sources[o][cell]`` is the index in ``rules`` of the rule that output ``o`` takes in a cell, -1 where it is left
    unset. ``behaviors`` follow the controller's; it is empty where there are none.
    """

    cells: int
    claimed: int
    rules: tuple[RuleAccount, ...]
    behaviors: tuple[BehaviorAccount, ...]
    sources: tuple[tuple[int, ...], ...]

    @property
    def unclaimed(self) -> int:
        return self.cells - self.claimed
