"""What a function will cost on a machine, estimated from its program alone."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from fuzzyspec.estimate.profile import Profile, profile
from fuzzyspec.estimate.weights import MACHINES, Figure, Option, Weights, weights
from fuzzyspec.fixed.program import Program


@dataclass(frozen=True, slots=True)
class Estimate:
    """One call of a function on one machine.

    ``instructions`` and ``cycles``: means over the inputs that costs are measured with; ``_max``: along the longest
    path that its structure allows, taken or not. None where there is no honest figure. ``flash``: bytes with tables,
    callees and what the compiler's library adds; ``ram``: static data, which fuzzyc never makes; ``stack``: bytes.
    """

    instructions: float | None
    instructions_max: float | None
    cycles: float | None
    cycles_max: float | None
    flash: float
    ram: int
    stack: float


def estimate(program: Program, function_name: str, target: str, option: Option = "O2") -> Estimate:
    """The estimate of a function named as in the spec.

    ``target`` is a machine, or ``generic``: the geometric means over all machines, without cycles. Its instructions
    count AVR's cycles as if they were instructions, since only comparisons have a meaning there. Raises KeyError for an
    unknown machine.
    """
    return of_profile(profile(program, function_name), target, option)


def of_profile(found: Profile, target: str, option: Option = "O2") -> Estimate:
    """The same of a program that was profiled already."""

    def longest(by: Weights) -> float:
        return found.longest(by)

    def mean(by: Weights) -> float:
        return by.of(found.mean)

    def value(figure: Figure, how: Callable[[Weights], float]) -> float | None:
        by = weights(target, option, figure)
        return None if by is None else how(by)

    if target == "generic":
        return Estimate(
            time(found, target, option),
            _generic(lambda machine: how_long(found, machine, option, longest)),
            None,
            None,
            flash(found, target, option),
            0,
            _generic(lambda machine: stack(found, machine, option)),
        )
    return Estimate(
        value("instructions", mean),
        value("instructions", longest),
        value("cycles", mean),
        value("cycles", longest),
        flash(found, target, option),
        0,
        stack(found, target, option),
    )


def band(target: str, option: Option, figure: Figure) -> float | None:
    """The relative error that nine in ten of the specs held out of the fit stayed below: 0.2 is 20 %.

    Of ``generic`` the largest of the machines; None where there is no such figure.
    """
    machines = MACHINES if target == "generic" else (target,)
    found = [by.nine_in_ten for m in machines if (by := weights(m, option, figure)) is not None]
    return max(found, default=None)


def time(found: Profile, target: str, option: Option) -> float:
    """What is to be small for speed: mean instructions, on AVR mean cycles, over the machines where it is generic."""

    def mean(by: Weights) -> float:
        return by.of(found.mean)

    if target == "generic":
        return _generic(lambda machine: how_long(found, machine, option, mean))
    return how_long(found, target, option, mean)


def how_long(found: Profile, machine: str, option: Option, how: Callable[[Weights], float]) -> float:
    """Instructions, or cycles where instructions are not counted."""
    by = weights(machine, option, "instructions") or weights(machine, option, "cycles")
    assert by is not None
    return how(by)


def flash(found: Profile, target: str, option: Option) -> float:
    """Bytes of code and tables."""
    if target == "generic":
        return _generic(lambda machine: flash(found, machine, option))
    by = weights(target, option, "flash")
    assert by is not None
    return by.of(found.code) + found.tables


def stack(found: Profile, machine: str, option: Option) -> float:
    """Bytes below the caller's stack pointer."""
    by = weights(machine, option, "stack")
    assert by is not None
    return by.of(found.frame)


def _generic(of: Callable[[str], float]) -> float:
    """Over the machines a geometric mean, so that none outweighs another."""
    return math.exp(sum(math.log(max(of(m), 1.0)) for m in MACHINES) / len(MACHINES))
