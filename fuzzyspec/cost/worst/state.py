"""What may be in the registers, the flags and the memory at one place of the code."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from math import log2
from typing import NamedTuple

from fuzzyspec.cost.worst.code import Condition
from fuzzyspec.cost.worst.values import Value, anything, between, constant, extent, join, unsigned

UNKNOWN_CARRY = Value(0, 1, 1)


class Difference(NamedTuple):
    """The flags are those of ``left - right``; the registers that still hold them, where they do."""

    left: Value
    right: Value
    bits: int
    left_in: int | None
    right_in: int | None


class Outcome(NamedTuple):
    """The flags for zero and sign are those of this value; the register that still holds it, where it does."""

    value: Value
    bits: int
    held_in: int | None


class Flags(NamedTuple):
    """``difference`` settles every condition, ``outcome`` those of zero and sign."""

    difference: Difference | None
    outcome: Outcome | None
    carry: Value


NO_FLAGS = Flags(None, None, UNKNOWN_CARRY)


class Cell(NamedTuple):
    """Bytes in memory whose value is followed; ``saved`` ones are a caller's registers, which no array overlaps."""

    size: int
    value: Value
    saved: bool


class Frame(NamedTuple):
    """A call: the stack pointer when it began, and which registers its caller had written."""

    pointer: int
    written: int


Words = Callable[[Value, int, bool], Value | None]
"""What constant memory holds at an address, in a size, of program memory or of data; None where it is not constant."""


_names = count(1)


def named(value: Value) -> Value:
    """A value that is not one word, with a name of its own where it has none."""
    return value._replace(base=(next(_names), 0)) if value.step and value.base is None else value


class State:
    """Registers of ``bits`` bits, flags, and the cells of memory that are followed; others may hold anything."""

    __slots__ = ("assumed", "bits", "cells", "constants", "flags", "frames", "registers", "written")

    def __init__(
        self,
        bits: int,
        registers: list[Value],
        cells: dict[int, Cell],
        flags: Flags,
        constants: Words,
        frames: tuple[Frame, ...],
    ) -> None:
        self.assumed: Condition | None = None
        """What is known of the flags as they are: the condition of a run of guarded instructions, or its contrary."""
        self.bits = bits
        self.registers = registers
        self.cells = cells
        self.flags = flags
        self.constants = constants
        self.frames = frames
        self.written = 0
        """The registers written since the call, a bit each."""
        """The calls under way, the one that is measured first."""

    def copy(self) -> State:
        copied = State(self.bits, self.registers[:], dict(self.cells), self.flags, self.constants, self.frames)
        copied.assumed, copied.written = self.assumed, self.written
        return copied

    def same(self, other: State) -> bool:
        """Whether the two stand for the same."""
        return self.registers == other.registers and self.cells == other.cells and self.flags == other.flags

    def set(self, register: int, value: Value) -> None:
        """A register is written: flags that were known to be of its old content are so no more."""
        self.registers[register] = named(value)
        self.written |= 1 << register
        difference, outcome, carry = self.flags
        if difference is not None and register in (difference.left_in, difference.right_in):
            left, right, bits, left_in, right_in = difference
            kept = [None if held == register else held for held in (left_in, right_in)]
            difference = Difference(left, right, bits, *kept)
        if outcome is not None and outcome.held_in == register:
            outcome = Outcome(outcome.value, outcome.bits, None)
        self.flags = Flags(difference, outcome, carry)

    def restrict(self, register: int, part: Value) -> None:
        """A register is found to hold one of these: so is whatever is known relative to the same."""
        base = self.registers[register].base
        self.registers[register] = part
        if base is None:
            return
        name, by = base
        for number, value in enumerate(self.registers):
            if value.base is not None and value.base[0] == name and number != register:
                self.registers[number] = _narrower(value, part, value.base[1] - by, self.bits)
        for at, (size, value, saved) in list(self.cells.items()):
            if value.base is not None and value.base[0] == name and 8 * size == self.bits:
                self.cells[at] = Cell(size, _narrower(value, part, value.base[1] - by, self.bits), saved)

    def load(self, address: Value, size: int, program: bool) -> Value:
        """What a load gives, without the extension of its sign."""
        bits = 8 * size
        constant_part = self.constants(address, size, program)
        if constant_part is not None:
            return constant_part
        if program:
            return anything(bits)
        if address.step == 0:
            return self._load_one(address.lo, size)
        if extent(address) > 64 * address.step:
            return anything(bits)
        found: Value | None = None
        for at in range(address.lo, address.hi + 1, address.step):
            one = self._load_one(at, size)
            found = one if found is None else join(found, one, bits)
        return anything(bits) if found is None else found

    def _load_one(self, address: int, size: int) -> Value:
        cell = self.cells.get(address)
        if cell is not None and cell.size == size:
            return cell.value
        for base in range(address - 3, address + 1):
            wide = self.cells.get(base)
            if wide is not None and wide.size >= address - base + size and wide.value.step == 0:
                return constant(wide.value.lo >> 8 * (address - base), 8 * size)
        value = named(anything(8 * size))
        if not any(at in self.cells for at in range(address - 3, address + size)):
            self.cells[address] = Cell(size, value, False)  # read again, it is the same
        return value

    def store(self, address: Value, size: int, value: Value, saved: bool) -> None:
        """A store; where it may go to several places, each may keep what it had.

        Generated C indexes arrays that are local to the function, nothing of its callers'.
        """
        if address.step == 0:
            self._drop(address.lo, size)
            self.cells[address.lo] = Cell(size, value, saved)
            return
        lo, hi = unsigned(address, 32)
        # A stack grows downwards: what a caller keeps lies above its pointer; where that points to a free byte (AVR),
        # right above.
        own = self.frames[-1].pointer + (self.bits == 8)
        for at, cell in list(self.cells.items()):
            if cell.saved or at + cell.size <= lo or at >= hi + size or at >= own:
                continue
            if cell.size == size and (at - lo) % address.step == 0:
                self.cells[at] = Cell(size, join(cell.value, value, 8 * size), False)
            elif address.step < size or _overlaps(at, cell.size, lo, address.step, size):
                del self.cells[at]

    def _drop(self, address: int, size: int) -> None:
        for at in range(address - 3, address + size):
            cell = self.cells.get(at)
            if cell is not None and at + cell.size > address:
                del self.cells[at]


def _narrower(value: Value, part: Value, by: int, bits: int) -> Value:
    """``value`` is ``part`` moved by a number: the narrower way to say so."""
    moved = between(part.lo + by, part.hi + by, part.step, bits)
    if extent(moved) >= extent(value):
        return value
    return moved._replace(base=value.base) if moved.step else moved


def _overlaps(at: int, length: int, lo: int, step: int, size: int) -> bool:
    """Whether a store at ``lo + k step`` of ``size`` bytes may touch the bytes from ``at``."""
    return any((byte - lo) % step < size for byte in range(at, at + length))


def joined(a: State, b: State) -> State:
    """What holds in both. Values that differ by the same in either still do."""
    bits = a.bits
    names: dict[tuple[int, int, int], int] = {}
    registers = [
        x if x == y else _merged(x, y, bits, bits, names) for x, y in zip(a.registers, b.registers, strict=True)
    ]
    cells: dict[int, Cell] = {}
    others = b.cells
    for at, cell in a.cells.items():
        other = others.get(at)
        if other == cell:
            cells[at] = cell
        elif other is not None and other.size == cell.size:
            value = _merged(cell.value, other.value, 8 * cell.size, bits, names)
            cells[at] = Cell(cell.size, value, cell.saved and other.saved)
    flags = a.flags if a.flags == b.flags else _joined_flags(a.flags, b.flags)
    both = State(bits, registers, cells, flags, a.constants, a.frames)
    both.written = a.written | b.written
    return both


def _merged(x: Value, y: Value, bits: int, machine: int, names: dict[tuple[int, int, int], int]) -> Value:
    """One of two values: relative to a new name, the same for all pairs that lie equally far apart."""
    value = join(x, y, bits)
    (of_x, by_x), (of_y, by_y) = x.base or (0, x.lo), y.base or (0, y.lo)
    if (x.step and x.base is None) or (y.step and y.base is None) or value.step == 0:
        return value
    key = (of_x, of_y, (by_x - by_y) & ((1 << machine) - 1))
    name = names.get(key)
    if name is None:
        name = names[key] = next(_names)
    return value._replace(base=(name, by_x))


def _joined_flags(a: Flags, b: Flags) -> Flags:
    difference: Difference | None = None
    x, y = a.difference, b.difference
    if x is not None and y is not None and x.bits == y.bits:
        difference = Difference(
            join(x.left, y.left, x.bits),
            join(x.right, y.right, x.bits),
            x.bits,
            x.left_in if x.left_in == y.left_in else None,
            x.right_in if x.right_in == y.right_in else None,
        )
    outcome: Outcome | None = None
    s, t = a.outcome, b.outcome
    if s is not None and t is not None and s.bits == t.bits:
        held = s.held_in if s.held_in == t.held_in else None
        outcome = Outcome(join(s.value, t.value, s.bits), s.bits, held)
    return Flags(difference, outcome, join(a.carry, b.carry, 32))


def extended(value: Value, size: int, signed: bool, bits: int) -> Value:
    """A value of ``size`` bytes as a register holds it."""
    narrow = 8 * size
    if narrow >= bits:
        return value
    top, half = 1 << narrow, 1 << (narrow - 1)
    if not signed:
        return value if value.hi < top else between(0, top - 1, 1, bits)
    if value.hi < half:
        return value
    if value.lo >= half and value.hi < top:
        return between(value.lo - top, value.hi - top, value.step, bits)
    return between(-half, half - 1, 1, bits)


def loss(a: State, b: State) -> float:
    """How much is lost when two states are joined: bits of doubt, over registers and memory; most where two words that
    were known would not be."""
    lost = 0.0
    for x, y in zip(a.registers, b.registers, strict=True):
        if x != y:
            lost += 0 if x.step or y.step else 64
            lost += log2(1 + extent(join(x, y, a.bits))) - max(log2(1 + extent(x)), log2(1 + extent(y)))
    for at, cell in a.cells.items():
        other = b.cells.get(at)
        if other is None or other.size != cell.size:
            lost += 8 * cell.size
        elif other != cell:
            x, y = cell.value, other.value
            lost += log2(1 + extent(join(x, y, 8 * cell.size))) - max(log2(1 + extent(x)), log2(1 + extent(y)))
    return lost
