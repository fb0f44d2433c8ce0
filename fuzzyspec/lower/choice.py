"""The strategy of a controller: which ones it can be computed by, and which one a goal and a machine ask for.

Strategies are not known by name here: each is lowered, what it would cost is estimated (``fuzzyspec.estimate``), and
the cheapest is taken.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache, cached_property
from itertools import product
from math import prod
from typing import get_args

from fuzzyspec.estimate.model import flash, time
from fuzzyspec.estimate.profile import Profile, profile
from fuzzyspec.estimate.weights import Option, unseen
from fuzzyspec.fixed.build import RangeError
from fuzzyspec.fixed.program import Division, Function, Program
from fuzzyspec.lower.cells import applies as cells_apply
from fuzzyspec.lower.controller import ControllerNumbers, lower_controller
from fuzzyspec.lower.kinds import applies as kinds_apply
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
    """What is to be least: ``time ** for_time * flash ** for_flash``, a geometric mean over the compiler's options.

    With ``patience`` also what a program takes longer than so many times the fastest, as a factor.
    """

    for_time: float
    for_flash: float
    options: tuple[Option, ...]
    patience: float | None = None

    def of(self, times: Sequence[float], sizes: Sequence[float], fastest: float) -> float:
        """Of a program's times and flash, by option; ``fastest`` is the least of its rivals' times by the first."""
        late = 1.0 if self.patience is None else max(1.0, times[0] / (self.patience * fastest))
        cost = prod((t**self.for_time * f**self.for_flash for t, f in zip(times, sizes, strict=True)), start=late)
        return float(cost)


GOALS: Mapping[Goal, Weighing] = {
    "speed": Weighing(1, 1 / 8, ("O2",)),
    "balanced": Weighing(1, 1, ("O2", "Os")),
    "size": Weighing(0, 1, ("Os",), patience=1.5),
}
"""Twice the flash must buy 8 % of the time where speed is asked for; where size is, only flash counts up to 1.5 times
what the fastest takes, beyond that either is worth the other, as it is in between."""


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
    """The ways of firing that a controller's rules allow, loops first; blocks share code where they are many."""
    if multilinear_applies(controller):
        return ("loops",)
    cells: tuple[Rules, ...] = ("cells",) if cells_apply(controller) else ()
    kinds: tuple[Rules, ...] = ("kinds",) if not cells and kinds_apply(controller) else ()
    if not minors_apply(controller):
        return ("loops", *kinds)
    levels: tuple[Rules, ...] = () if levels_apply(controller) is None else ("levels",)
    return ("loops", "minors", *levels, *cells, *kinds)


def strategies(controller: Controller) -> tuple[Strategy, ...]:
    """All of a controller's strategies, each a program of its own with the same integers."""
    interpolations: tuple[Interpolation, ...] = ways(controller) if multilinear_applies(controller) else ("loops",)
    return tuple(Strategy(*s) for s in product(rules_of(controller), interpolations, get_args(Division)))


def choose(controller: Controller, goal: Goal, target: Target, precision: Precision = "full") -> Candidate:
    """The controller by the strategy that serves the goal.

    One field of the strategy after the other, in declared order, is set to what comes out cheapest with the others as
    they are; of equals the first stays. What does something that the model has never seen comes after what does not.
    With patience fields do touch each other: it is done from the fastest strategy too, and the better one taken.
    Raises RangeError where no strategy fits 32 bits, and TooManySets.
    """
    possible = strategies(controller)
    first = _first(controller, possible, target, precision)

    @cache
    def lowered(strategy: Strategy) -> Candidate | None:
        try:
            return first if strategy == first.strategy else candidate(controller, strategy, target, precision)
        except RangeError:
            return None

    def quickest(profile: Profile) -> float:
        return time(profile, target, GOALS[goal].options[0])

    if GOALS[goal].patience is None:
        return _descended(first, possible, lowered, lambda profile: weigh(profile, goal, target))
    quick = _descended(first, possible, lowered, quickest)
    fastest = quickest(quick.profile)

    def weighed(profile: Profile) -> float:
        return weigh(profile, goal, target, fastest)

    found = [_descended(start, possible, lowered, weighed) for start in (first, quick)]
    return min(found, key=lambda c: (unseen(c.profile.code), weighed(c.profile)))


def _descended(
    first: Candidate,
    possible: Sequence[Strategy],
    lowered: Callable[[Strategy], Candidate | None],
    weighed: Callable[[Profile], float],
) -> Candidate:
    """The cheapest that is found by changing one field after the other."""

    def cost(of: Candidate) -> tuple[int, float]:
        return unseen(of.profile.code), weighed(of.profile)

    best, least = first, cost(first)
    for field in fields(Strategy):
        anchor = best.strategy
        for strategy in possible:
            if strategy == anchor or replace(strategy, **{field.name: getattr(anchor, field.name)}) != anchor:
                continue
            tried = lowered(strategy)
            if tried is not None and cost(tried) < least:
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


def weigh(found: Profile, goal: Goal, target: Target, fastest: float = 0.0) -> float:
    """What the goal wants least; ``fastest`` is the least time of its rivals, where the goal has patience."""
    by = GOALS[goal]
    times = [time(found, target, option) for option in by.options]
    return by.of(times, [flash(found, target, option) for option in by.options], fastest)


def fastest_of(found: Iterable[Profile], goal: Goal, target: Target) -> float:
    """The least time of programs, as a goal with patience asks for it."""
    return min(time(profile, target, GOALS[goal].options[0]) for profile in found)
