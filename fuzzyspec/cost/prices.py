"""What each step of the counted limit takes on a core: the lengths of the sequences in ``docs/limit.md``.

Instructions; on AVR cycles. A test assembles those sequences and counts them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import get_args

from fuzzyspec.model.budget import Machine

CORES = ("cortex-m0plus", "cortex-m4", "rv32imc", "avr")
"""The cores that have sequences of their own, in the order of the rows below."""

STEPS: Mapping[str, tuple[float, float, float, float]] = {
    "call": (3, 3, 2, 7),
    "load": (1, 1, 1, 4),
    "load_signed": (2, 1, 1, 4),
    "load_byte": (1, 1, 1, 2),
    "load_signed_byte": (2, 1, 1, 2),
    "store": (1, 1, 1, 4),
    "store_byte": (1, 1, 1, 2),
    "threshold": (3, 3, 3, 4.5),
    "short_threshold": (2, 2, 2, 2.5),
    "test": (2, 2, 1, 3.5),
    "line": (5, 4, 6, 21),
    "line_byte": (5, 4, 6, 12),
    "shift_line": (2, 2, 2, 3),
    "split": (2, 2, 2, 1),
    "add": (1, 1, 1, 2),
    "sum": (1, 1, 1, 4),
    "scaled_sum": (2, 1, 2, 8),
    "square": (3, 2, 2, 14),
    "multiply": (2, 2, 2, 16),
    "cube": (3, 3, 3, 16),
    "quadratic": (7, 5, 9, 42),
    "cubic": (11, 8, 14, 62),
    "moment": (3, 2, 4, 22),
    "singleton": (4, 3, 5, 25),
    "minimum": (2.5, 2.5, 1.5, 4),
    "exchange": (3.5, 3.5, 2.5, 6.5),
    "prepare": (6.5, 5.5, 6.5, 3),
    "cell": (3, 3, 3, 6),
    "more": (2, 2, 2, 4),
    "update": (3.5, 3.5, 3.5, 11.5),
    "dispatch": (5, 2, 6, 11),
    "level": (5, 4, 4, 19),
    "weights": (15, 10, 15, 63),
    "inner": (7, 6, 6, 28),
    "corners": (11, 8, 11, 43),
    "wide_corners": (11, 8, 11, 104),
    "unpack": (2, 2, 2, 0),
    "lerp": (4, 3, 4, 39),
    "quotient": (26.5, 6, 7, 163),
    "round": (2, 2, 2, 4),
    "address": (1, 1, 2, 2),
    "frame": (2, 2, 2, 0),
    "spill": (2, 2, 2, 8),
}
"""A step's price on each of the cores."""

REGISTERS: Mapping[str, int] = {"cortex-m0plus": 8, "cortex-m4": 14, "rv32imc": 28, "avr": 7}
"""Registers that take part in arithmetic; on AVR pairs that need not be saved for the caller."""


def core_of(target: str) -> str:
    """The core whose sequences a target runs: the Cortex-M7 has the M4's instructions."""
    assert target in get_args(Machine)
    return "cortex-m4" if target == "cortex-m7" else target


def price(step: str, core: str) -> float:
    """What one step takes."""
    return STEPS[step][CORES.index(core)]


def fits(core: str, threshold: int, byte: bool) -> bool:
    """Whether a raw is compared with this threshold by a ``short_threshold``: the constant is part of the comparison,
    or on RISC-V made by one instruction."""
    if core == "cortex-m0plus":
        return 0 <= threshold < 2**8
    if core == "cortex-m4":
        return threshold == 0 or abs(threshold) // (threshold & -threshold) < 2**8
    if core == "rv32imc":
        return threshold % 2**12 == 0 or -(2**11) <= threshold < 2**11
    return byte or threshold % 2**8 == 0
