"""What is known of the functions that divide: claims that the analyser takes over, and that are proved like any other.

They are those of ``docs/numbers.md``, "Division": how near a reciprocal is, and how much a digit leaves over.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.fixed.division import TOP_BITS, Kernel

NEAR = {"reciprocal": Fraction(11, 10_000), "newton": Fraction(11, 100_000)}
"""How much of 1 a reciprocal's product with its divisor may fall short of."""


@dataclass(frozen=True, slots=True)
class Hints:
    """``after``: by a local, what holds after each time that it is assigned in turn (empty: nothing to say).

    ``kept``: what holds at the start and at the end of each round of a loop, and after a choice that changes ``of``.
    """

    after: Mapping[str, tuple[str, ...]]
    of: str = ""
    kept: str = ""


def hints_of(kernel: Kernel) -> Hints:
    """What is known of a function that divides."""
    match kernel.by:
        case "loop" | "rounds" | "unrolled":
            return Hints({}, "rest", "rest < den")
        case "hardware" if kernel.digit_bits == 4:
            return Hints({"digit": ("digit <= 15",), "rest": ("", "rest < den")}, "rest", "rest < den")
        case "hardware":
            return Hints({})
        case "newton" | "reciprocal":
            return _reciprocal(kernel)


def _reciprocal(kernel: Kernel) -> Hints:
    short, scale = NEAR[kernel.by], 2 ** (kernel.width - TOP_BITS)
    whole = (2**32 if kernel.by == "reciprocal" else 2**31) * scale
    least = whole * (1 - short)
    digits: list[str] = []
    rests: list[str] = []
    for percent in _left_over(kernel, short):
        rest = f"(rest << {kernel.digit_bits}) - digit * divisor"
        digits.append(f"0 <= {rest} && 100 * ({rest}) <= {percent} * divisor")
        rests.append(f"100 * rest <= {percent} * divisor")
    after: dict[str, tuple[str, ...]] = {
        "inverse": ("",) * (2 if kernel.by == "newton" else 0)
        + (f"{-(-least.numerator // least.denominator)} <= inverse * divisor && inverse * divisor <= {whole}",),
        "digit": tuple(digits),
        "rest": ("",) * (1 + len(kernel.steps)) + tuple(rests),
    }
    return Hints(after)


def _left_over(kernel: Kernel, short: Fraction) -> list[int]:
    """The remainder after each digit, in percent of the divisor."""
    found: list[int] = []
    rho = Fraction(1)
    for _ in range(16 // kernel.digit_bits):
        rho = 1 + rho * 2**kernel.digit_bits * short + Fraction(2 ** (kernel.digit_bits), 2**12)
        found.append(int(100 * rho) + 1)
        rho = Fraction(found[-1], 100)
    return found
