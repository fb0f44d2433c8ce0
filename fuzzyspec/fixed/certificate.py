"""What the compiler can promise about |C - exact|, as data."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction


@dataclass(frozen=True, slots=True)
class Band:
    """A decision on a computed value: both meanings agree where its operands differ by more than ``width``.

    ``width`` is in coherent units for comparisons and 0/0, in degrees [0, 1] for ``fires`` and ``acting``.
    """

    key: str
    what: str
    width: Fraction


@dataclass(frozen=True, slots=True)
class Dominant:
    """What a bound is as large as it is for: ``where`` the inputs then lie, and which ``kernel`` adds most of it.

    Both are for people, in the words of the spec. ``percent`` is the kernel's share of the bound there.
    """

    where: str
    kernel: str
    percent: int


@dataclass(frozen=True, slots=True)
class OutputBound:
    """``|C - exact along C's decisions| <= error`` for every input, in the output's unit.

    ``error`` is None where no bound could be had; ``reason`` then says why, and otherwise which parts it has.
    """

    output: str
    error: Fraction | None
    percent_of_range: Fraction | None
    reason: str
    dominant: Dominant | None = None


@dataclass(frozen=True, slots=True)
class Certificate:
    """Of one function; ``method`` names the derivation (``quick`` or ``thorough``)."""

    function: str
    method: str
    outputs: tuple[OutputBound, ...]
    bands: tuple[Band, ...]

    def output(self, name: str) -> OutputBound:
        return next(o for o in self.outputs if o.output == name)
