"""What the strategies know of the machine that the C is compiled for. The C runs bit-exact on every other one too."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

Target = Literal["generic", "cortex-m0plus", "cortex-m4", "cortex-m7", "rv32imc", "avr"]


@dataclass(frozen=True, slots=True)
class Machine:
    """``divides``: whether 32-bit division is an instruction, not a call of a library. ``roomy``: whether a dozen
    values
    stay in registers."""

    divides: bool
    roomy: bool


MACHINES: Mapping[Target, Machine] = {
    "generic": Machine(divides=False, roomy=False),
    "cortex-m0plus": Machine(divides=False, roomy=False),
    "cortex-m4": Machine(divides=True, roomy=True),
    "cortex-m7": Machine(divides=True, roomy=True),
    "rv32imc": Machine(divides=True, roomy=True),
    "avr": Machine(divides=False, roomy=False),
}
