"""What a Thumb instruction takes on a Cortex-M0+, by the table in its technical reference manual (DDI 0484, 3.3).

The table holds for memory without wait states and the multiplier that takes one cycle. Loads and stores take 2: none
goes to the single-cycle I/O port.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Block:
    """A straight run of instructions. ``cycles`` is None where one is not in the table.

    ``conditional``: the last one is a conditional branch, which takes one cycle more where it is taken.
    """

    instructions: int
    cycles: int | None
    conditional: bool


def decode_thumb(code: bytes) -> Block:
    """The instructions of a block, of any Thumb core; the cycles are a Cortex-M0+'s."""
    count = 0
    cycles: int | None = 0
    conditional = False
    at = 0
    while at + 2 <= len(code):
        first = int.from_bytes(code[at : at + 2], "little")
        wide = first >> 11 in (0b11101, 0b11110, 0b11111)
        second = int.from_bytes(code[at + 2 : at + 4], "little") if wide else 0
        took = _wide_cycles(first, second) if wide else _cycles(first)
        cycles = None if took is None or cycles is None else cycles + took
        conditional = first >> 12 == 0b1101 and (first >> 8) & 15 < 14
        count += 1
        at += 4 if wide else 2
    return Block(count, cycles, conditional)


def _cycles(code: int) -> int | None:
    """Of a 16-bit instruction; a conditional branch as if it were not taken."""
    match code >> 12:
        case 0b0000 | 0b0001 | 0b0010 | 0b0011:  # shifts, add, subtract, move and compare with immediates
            return 1
        case 0b0100:
            return _of_registers(code)
        case 0b0101 | 0b0110 | 0b0111 | 0b1000 | 0b1001:  # load and store
            return 2
        case 0b1010:  # address from PC or SP
            return 1
        case 0b1011:
            return _miscellaneous(code)
        case 0b1100:  # load and store multiple
            return 1 + (code & 0xFF).bit_count()
        case 0b1101:
            return 1 if (code >> 8) & 15 < 14 else None
        case 0b1110:
            return 2 if not code & 0x0800 else None
        case _:
            return None


def _of_registers(code: int) -> int | None:
    if code >> 11 == 0b01001:  # load from the literal pool
        return 2
    if code >> 10 == 0b010000:  # data processing, the multiplication among it
        return 1
    if code & 0x0300 == 0x0300:  # BX, BLX
        return 2
    writes_pc = (code & 7 | (code >> 4) & 8) == 15 and code & 0x0300 != 0x0100
    return 2 if writes_pc else 1


def _miscellaneous(code: int) -> int | None:
    listed = (code & 0xFF).bit_count()
    match (code >> 8) & 15:
        case 0b0000 | 0b0010 | 0b1010:  # ADD and SUB SP, extensions, byte reversals
            return 1
        case 0b0100:
            return 1 + listed
        case 0b0101:  # PUSH with LR
            return 2 + listed
        case 0b1100:
            return 1 + listed
        case 0b1101:  # POP with PC
            return 3 + listed
        case 0b1111:
            return 1 if code == 0xBF00 else None
        case _:
            return None


def _wide_cycles(first: int, second: int) -> int | None:
    """Of a 32-bit instruction; compiled C has BL alone on this core."""
    return 3 if first >> 11 == 0b11110 and second & 0xD000 == 0xD000 else None
