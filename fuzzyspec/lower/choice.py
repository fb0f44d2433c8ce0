"""The strategy of a controller: which ones it can be computed by, and which one a goal and a machine ask for."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import get_args

from fuzzyspec.fixed.program import Division
from fuzzyspec.lower.cells import applies as cells_apply
from fuzzyspec.lower.levels import applies as levels_apply
from fuzzyspec.lower.minors import applies as minors_apply
from fuzzyspec.lower.multilinear import applies as multilinear_applies
from fuzzyspec.lower.multilinear import corners_of, ways
from fuzzyspec.lower.strategy import Goal, Interpolation, Rules, Strategy, Target, Widths
from fuzzyspec.model.controller import Controller

DIVIDES: frozenset[Target] = frozenset({"cortex-m4", "cortex-m7", "rv32imc"})
"""Machines on which 32-bit division is an instruction, not a call of a library."""
WIDTHS: Mapping[Target, Widths] = {t: "narrow" if t == "avr" else "words" for t in get_args(Target)}
"""On 8 bits every byte of a value costs; on 32 a narrow local costs, which is cut to its width at every step."""
FEW_CORNERS = 2
"""Sums of corners that take less room one by one than in a loop."""


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


def choose(controller: Controller, goal: Goal, target: Target) -> Strategy:
    """One of a controller's strategies."""
    division = division_of(goal, target)
    interpolation = _interpolation(controller, goal, target)
    if goal == "size":
        return Strategy("loops", interpolation, division)
    possible = rules_of(controller)
    rules: Rules = possible[-1]
    return Strategy(rules, interpolation, division)


def division_of(goal: Goal, target: Target) -> Division:
    """How a machine divides. A table and two multiplications a digit pay where the multiplier takes whole words."""
    if target in DIVIDES:
        return "hardware"
    if target == "avr":
        return "unrolled" if goal == "speed" else "loop"
    return "newton" if goal == "size" else "reciprocal"


def _interpolation(controller: Controller, goal: Goal, target: Target) -> Interpolation:
    """A machine of 8 bits gains nothing by filling words; few corners take less room without a loop."""
    if not multilinear_applies(controller) or (goal == "size" and corners_of(controller) > FEW_CORNERS):
        return "loops"
    packs = goal != "size" and target != "avr" and "packed" in ways(controller)
    return "packed" if packs else "written"
