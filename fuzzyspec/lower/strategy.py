"""What a controller may be computed by. All strategies compute the same integers, and their C runs on every machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from fuzzyspec.fixed.program import Division

Goal = Literal["speed", "balanced", "size"]
"""What the strategies are chosen for."""
Target = Literal["generic", "cortex-m0plus", "cortex-m4", "cortex-m7", "rv32imc", "avr"]
"""The machine that they are chosen for."""
Rules = Literal["loops", "minors", "levels", "cells", "kinds"]
"""Firing: every active cell in loops (any rule base); cells written out, strongest first, by sorted minors; the same
with sets of terms as bits and one square a strength, where the outputs are even; for few cells, code of its own for
every block of cells between neighbouring peaks; or, for few kinds of blocks, for every kind, with any terms."""
Interpolation = Literal["loops", "written", "packed"]
"""Product and singletons over strong partitions: interpolations in loops over the corners, written out, or written out
with two outputs in the halves of a word."""
Precision = Literal["full", "short"]
"""Bits of areas and divisors: so many that they never dominate an error, or so few that narrow machines like them.
Unlike strategies, another precision is another program, with its own integers and certificate."""
Widths = Literal["words", "narrow"]
"""Locals of 32 bits, as registers are, or of the fewest bits that hold their values."""


@dataclass(frozen=True, slots=True)
class Strategy:
    """One choice for a whole controller. ``interpolation`` counts only where the controller is one."""

    rules: Rules = "loops"
    interpolation: Interpolation = "loops"
    division: Division = "loop"
