"""How a quotient is divided: which kernel a node is computed by, and the numbers that the kernels rest on.

All kernels give the same integer (docs/numbers.md, "Division"). Where a divisor is too large for the way that was
asked for, the next best is taken.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from fuzzyspec.fixed.program import Division, Quotient

HARDWARE_BITS = 28
"""Divisors below two to this leave room to shift a remainder up by 4."""
RECIPROCAL_BITS = 27
"""The same where a remainder may exceed its divisor."""
COMMON_BITS = 23
"""Up to two to this a digit of 8 bits leaves a remainder that can be shifted up by 8 as it is."""
CELLS = 113
"""Reciprocals in the table: of a divisor that is scaled to 16 bits, 2**13 .. 2**16, by its topmost 7."""
TOP_BITS, CELL_BITS, FIRST_CELL = 16, 7, 16
MISSING: Mapping[Division, int] = {"newton": 0, "reciprocal": 2}
"""Bits that a divisor may be short of the largest where its reciprocal begins."""
REFLECTED = 2**22 - 2**8
"""What Newton's step subtracts ``top * near`` from: 2 in the table's scale, less a cell of what ``top`` leaves out."""
INVERSE_SHIFT = 10
LINE = 187 * 2**9
"""``LINE - top`` is near ``2**31 / top`` where no table is: 7 % off at most, a hundred-thousandth after two steps."""


@dataclass(frozen=True, slots=True, order=True)
class Kernel:
    """One function of the C. ``digit_bits``: of the quotient, taken before the remainder is shifted up.

    Of reciprocals: divisors are at most ``2**width``, and have at most ``missing`` bits less than that many.
    """

    by: Division
    digit_bits: int
    width: int = 0
    missing: int = 0

    @property
    def smallest_bits(self) -> int:
        """Of a reciprocal's divisors that exceed their numerator."""
        return self.width - self.missing

    @property
    def steps(self) -> tuple[int, ...]:
        """Shifts that leave every divisor at most ``MISSING`` bits short, each taken where the divisor has room for it.

        Each halves what may be missing.
        """
        enough = MISSING.get(self.by, self.missing)
        steps: list[int] = []
        missing = self.missing
        while missing > enough:
            steps.append((missing + 2) // 2)
            missing = max(steps[-1] - 1, missing - steps[-1])
        return tuple(steps)

    @property
    def settles(self) -> bool:
        """Whether the first digit is corrected at once, since its remainder would have no room to be larger."""
        return self.by in MISSING and self.width + self.digit_bits >= 32


def offered(division: Division, largest: int) -> Division:
    """The way to divide by at most ``largest`` that comes next to the one asked for."""
    room = {"hardware": 2**HARDWARE_BITS - 1} | dict.fromkeys(MISSING, 2**RECIPROCAL_BITS)
    return "rounds" if largest > room.get(division, largest) else division


def kernel_of(node: Quotient) -> Kernel:
    """The function that computes a node."""
    lo, hi = max(node.den.lo, 1), node.den.hi
    match node.by:
        case "loop" | "rounds" | "unrolled":
            return Kernel(node.by, 1)
        case "hardware":
            if hi < 2**24:
                return Kernel("hardware", 16 if hi < 2**16 else 8)
            return Kernel("hardware", 4)
        case "newton" | "reciprocal":
            return _reciprocal(node.by, max((hi - 1).bit_length(), TOP_BITS + 1), lo.bit_length())


def _reciprocal(by: Division, width: int, smallest_bits: int) -> Kernel:
    """As few functions as do no harm: many divisors share one, as long as none takes a step more."""
    level = _level(by, width - smallest_bits)
    if width < COMMON_BITS and _level(by, COMMON_BITS - smallest_bits) == level:
        width = COMMON_BITS
    return Kernel(by, 8 if width <= 24 else 4, width, min(level, width - 1))


def shared(kernels: Iterable[Kernel]) -> dict[Kernel, Kernel]:
    """By kernel the one that stands for it in a module: all of Newton's are one, since those are taken for size."""
    found = {kernel: kernel for kernel in sorted(kernels)}
    for bits in (4, 8):
        group = [k for k in found if k.by == "newton" and k.digit_bits == bits]
        if group:
            width = max(k.width for k in group)
            one = _reciprocal("newton", width, min(k.smallest_bits for k in group))
            found |= dict.fromkeys(group, one)
    return found


def _level(by: Division, missing: int) -> int:
    """The most that may be missing for as many steps."""
    level = MISSING[by]
    while level < missing:
        level = 2 * level + 1
    return level


def reciprocals() -> tuple[int, ...]:
    """Of every cell the integer nearest to ``2**21 / top`` at its middle."""
    width = 1 << (TOP_BITS - CELL_BITS)
    middles = (2 * cell * width + width for cell in range(FIRST_CELL, FIRST_CELL + CELLS))
    return tuple((2**23 + middle) // (2 * middle) for middle in middles)
