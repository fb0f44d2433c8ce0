"""What an instruction does, the same words for every machine. Whatever is left unsaid is a value that may be anything.

Registers are numbered by the decoders; a word has the machine's width (32 bits, 8 on AVR), an address is a word or, on
AVR, a pair of registers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from fuzzyspec.cost.worst.values import Operator

Condition = Literal["eq", "ne", "hs", "lo", "hi", "ls", "ge", "lt", "gt", "le", "mi", "pl", "some", "other"]
"""As after a comparison of left with right; ``some`` and its contrary ``other`` say nothing of any register."""

CONTRARY: dict[Condition, Condition] = {
    "eq": "ne",
    "ne": "eq",
    "hs": "lo",
    "lo": "hs",
    "hi": "ls",
    "ls": "hi",
    "ge": "lt",
    "lt": "ge",
    "gt": "le",
    "le": "gt",
    "mi": "pl",
    "pl": "mi",
    "some": "other",
    "other": "some",
}


class NotModelled(Exception):
    """An instruction whose effect on what is followed is not known; the message names it."""


# --- expressions -----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Reg:
    number: int


@dataclass(frozen=True, slots=True)
class Imm:
    word: int


@dataclass(frozen=True, slots=True)
class Pair:
    """Two neighbouring registers of 8 bits as 16, the low one named."""

    low: int


@dataclass(frozen=True, slots=True)
class Apply:
    operator: Operator
    left: Expr
    right: Expr
    bits: int = 32


@dataclass(frozen=True, slots=True)
class Carry:
    """0 or 1: what the last addition carried, or the last subtraction borrowed."""


@dataclass(frozen=True, slots=True)
class Narrow:
    """The low ``bits`` of a word, extended by zeros or by the sign."""

    value: Expr
    bits: int
    signed: bool


@dataclass(frozen=True, slots=True)
class Load:
    """``size`` bytes of data, or of program memory where that is apart."""

    address: Expr
    size: int
    signed: bool = False
    program: bool = False


Expr = Reg | Imm | Pair | Apply | Carry | Narrow | Load

UNKNOWN = Apply("?", Imm(0), Imm(0))

# --- effects ---------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Set:
    register: int
    value: Expr


@dataclass(frozen=True, slots=True)
class SetPair:
    """A 16-bit value into two registers of 8 bits."""

    low: int
    value: Expr


@dataclass(frozen=True, slots=True)
class Put:
    """Store ``size`` bytes.

    ``saved``: what the function keeps for its caller, in room that no array shares: ``always``, or where the register
    stored was not written since the call.
    """

    address: Expr
    size: int
    value: Expr
    saved: Literal["always", "unless written"] | None = None


@dataclass(frozen=True, slots=True)
class Compare:
    """Set the flags as ``left - right`` does; ``extends``: it goes on from the comparison of the bytes below."""

    left: Expr
    right: Expr
    bits: int = 32
    extends: bool = False


@dataclass(frozen=True, slots=True)
class Subtract:
    """``register = left - right``, and the flags by it; with ``extends`` less the borrow, as in Compare."""

    register: int
    left: Expr
    right: Expr
    bits: int = 32
    extends: bool = False


@dataclass(frozen=True, slots=True)
class Add:
    """``register = left + right + carry``, and the flags by it."""

    register: int
    left: Expr
    right: Expr
    carry: Expr
    bits: int = 32


@dataclass(frozen=True, slots=True)
class ShiftRight:
    """A register by one place, the carry going in where ``rotates``; the bit that falls out is the carry."""

    register: int
    operator: Literal[">>", "asr"]
    rotates: bool
    bits: int


@dataclass(frozen=True, slots=True)
class Judge:
    """Set the flags for zero and sign by a register that was just set (its pair, where ``bits`` says so).

    The carry is kept, told by ``carry``, or unknown.
    """

    register: int
    bits: int = 32
    carry: Expr | Literal["kept"] | None = None


@dataclass(frozen=True, slots=True)
class Forget:
    """Flags of which nothing is known."""


Effect = Set | SetPair | Put | Compare | Subtract | Add | ShiftRight | Judge | Forget

# --- where it goes ---------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Jump:
    target: int


@dataclass(frozen=True, slots=True)
class Branch:
    """To ``target`` where the condition holds, of the flags or of the two values named."""

    condition: Condition
    target: int
    compared: tuple[Expr, Expr] | None = None
    bits: int = 32


@dataclass(frozen=True, slots=True)
class Call:
    """The effects store where it returns to."""

    target: int


@dataclass(frozen=True, slots=True)
class Leave:
    """To an address that was computed: of a return, the caller's."""

    target: Expr


Flow = Jump | Branch | Call | Leave


@dataclass(frozen=True, slots=True)
class Instruction:
    """``cycles`` is None where there is no model; ``taken`` is what a taken branch costs on top.

    ``guard``: its effects and its flow come about only where this holds; it costs the same. ``guards`` are the
    conditions of the instructions that follow it.
    """

    address: int
    size: int
    effects: tuple[Effect, ...]
    flow: Flow | None = None
    cycles: int | None = None
    taken: int = 0
    guard: Condition | None = None
    guards: tuple[Condition, ...] = ()

    @property
    def after(self) -> int:
        return self.address + self.size


Decode = Callable[[int], Instruction]
"""The instruction at an address. Raises NotModelled."""
