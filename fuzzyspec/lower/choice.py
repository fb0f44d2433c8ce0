"""The strategy of a controller: which ones it can be computed by, and which one a goal and a machine ask for.

Strategies are not known by name here: each is lowered, what it would cost is estimated (``fuzzyspec.estimate``), and
the cheapest is taken.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import product
from typing import get_args

from fuzzyspec.estimate.model import flash, time
from fuzzyspec.estimate.profile import Profile, profile
from fuzzyspec.estimate.weights import Option, unseen
from fuzzyspec.fixed.build import RangeError
from fuzzyspec.fixed.program import Division, Function, Program
from fuzzyspec.lower.cells import applies as cells_apply
from fuzzyspec.lower.controller import ControllerNumbers, lower_controller
from fuzzyspec.lower.levels import applies as levels_apply
from fuzzyspec.lower.minors import applies as minors_apply
from fuzzyspec.lower.multilinear import applies as multilinear_applies
from fuzzyspec.lower.multilinear import ways
from fuzzyspec.lower.strategy import Goal, Interpolation, Precision, Rules, Strategy, Target, Widths
from fuzzyspec.lower.widths import fit_widths
from fuzzyspec.model.controller import Controller

WIDTHS: Mapping[Target, Widths] = {t: "narrow" if t == "avr" else "words" for t in get_args(Target)}
"""On 8 bits every byte of a value costs; on 32 a narrow local costs, which is cut to its width at every step."""


@dataclass(frozen=True)
class Weighing:
    """What is to be least: ``time ** for_time * flash ** for_flash``, a geometric mean over the compiler's options."""

    for_time: float
    for_flash: float
    options: tuple[Option, ...]


GOALS: Mapping[Goal, Weighing] = {
    "speed": Weighing(1, 1 / 8, ("O2",)),
    "balanced": Weighing(1, 1, ("O2", "Os")),
    "size": Weighing(1 / 8, 1, ("Os",)),
}
"""Twice the flash must buy 8 % of the time where speed is asked for; twice the time must save 8 % of the flash where
size is; and either is worth the other in between."""


@dataclass(frozen=True)
class Candidate:
    """A controller lowered by one strategy."""

    strategy: Strategy
    function: Function
    numbers: ControllerNumbers
    target: Target

    @cached_property
    def profile(self) -> Profile:
        """What it does, in the widths of the target."""
        return profile(Program("choice", (fit_widths(self.function, WIDTHS[self.target]),)), self.function.name)


def rules_of(controller: Controller) -> tuple[Rules, ...]:
    """The ways of firing that a controller's rules allow, loops first."""
    if multilinear_applies(controller) or not minors_apply(controller):
        return ("loops",)
    levels: tuple[Rules, ...] = () if levels_apply(controller) is None else ("levels",)
    cells: tuple[Rules, ...] = ("cells",) if cells_apply(controller) else ()
    return ("loops", "minors", *levels, *cells)


def strategies(controller: Controller) -> tuple[Strategy, ...]:
    """All of a controller's strategies, each a program of its own with the same integers."""
    interpolations: tuple[Interpolation, ...] = ways(controller) if multilinear_applies(controller) else ("loops",)
    return tuple(Strategy(*s) for s in product(rules_of(controller), interpolations, get_args(Division)))


def choose(controller: Controller, goal: Goal, target: Target, precision: Precision = "full") -> Candidate:
    """The controller by the strategy that serves the goal.

    One field of the strategy after the other, in declared order, is set to what comes out cheapest with the others as
    they are; of equals the first stays. What does something that the model has never seen comes after what does not.
    Raises RangeError where no strategy fits 32 bits, and TooManySets.
    """

    def cost(of: Candidate) -> tuple[int, float]:
        return unseen(of.profile.code), weigh(of.profile, goal, target)

    possible = strategies(controller)
    best = _first(controller, possible, target, precision)
    least = cost(best)
    for field in fields(Strategy):
        anchor = best.strategy
        for strategy in possible:
            if strategy == anchor or replace(strategy, **{field.name: getattr(anchor, field.name)}) != anchor:
                continue
            try:
                tried = candidate(controller, strategy, target, precision)
            except RangeError:
                continue
            if cost(tried) < least:
                best, least = tried, cost(tried)
    return best


def candidate(controller: Controller, strategy: Strategy, target: Target, precision: Precision = "full") -> Candidate:
    """The controller by one strategy. Raises RangeError and TooManySets where its integers do not go into 32 bits."""
    return Candidate(strategy, *lower_controller(controller, strategy, precision), target)


def _first(controller: Controller, possible: tuple[Strategy, ...], target: Target, precision: Precision) -> Candidate:
    """The first strategy that fits 32 bits. Raises RangeError of the last where none does."""
    for strategy in possible[:-1]:
        try:
            return candidate(controller, strategy, target, precision)
        except RangeError:
            continue
    return candidate(controller, possible[-1], target, precision)


def weigh(found: Profile, goal: Goal, target: Target) -> float:
    """What the goal wants least."""
    by = GOALS[goal]
    cost = 1.0
    for option in by.options:
        cost *= time(found, target, option) ** by.for_time * flash(found, target, option) ** by.for_flash
    return cost
