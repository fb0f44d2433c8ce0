"""The derived worst case of a function of an image."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, replace

from fuzzyspec.cost.worst.avr import SP as AVR_SP
from fuzzyspec.cost.worst.avr import decode_avr, words
from fuzzyspec.cost.worst.code import Call, Decode, Expr, Instruction, Jump, Pair, Reg
from fuzzyspec.cost.worst.longest import Cost, NoBound, Search
from fuzzyspec.cost.worst.riscv import decode_riscv
from fuzzyspec.cost.worst.state import NO_FLAGS, Cell, Frame, State
from fuzzyspec.cost.worst.thumb import thumb_decoder
from fuzzyspec.cost.worst.values import Value, anything, between, constant, join
from fuzzyspec.fixed.program import ListPort, Loop, Program
from fuzzyspec.fixed.prune import statements
from fuzzyspec.machines.elf import Binary
from fuzzyspec.machines.harness import pointer_symbol
from fuzzyspec.machines.image import Image

_STACK = {"thumb": 0x28010000, "riscv32": 0x28010000, "avr": 0x2000}
"""Where the caller's stack ends: nothing else lies there, and no path depends on the place."""
_END = {"thumb": 0x0FFFFFE0, "riscv32": 0x0FFFFFE0, "avr": 0x7FFE}
_POINTERS: dict[str, Expr] = {"thumb": Reg(13), "riscv32": Reg(2), "avr": Pair(AVR_SP)}


@dataclass(frozen=True, slots=True)
class Bound:
    """Instructions and cycles that no call exceeds; None where none could be derived, for the reason given."""

    instructions: int | None
    cycles: int | None
    reason: str | None
    rounds: dict[str, int]


def derive(image: Image, function: str) -> Bound:
    """The worst case of the function named as in the spec. Raises MissingTool, BuildError."""
    binary = image.probed()
    code = Code(binary, image.compiler.target.machine)
    search = Search(code.decode, code.name_of, code.width_of, _POINTERS[code.machine], _most_rounds(image.program))
    symbols = image.names.functions[function]
    entry = binary.symbols[symbols.function] & ~1
    try:
        cost = search.longest(entry, _END[code.machine], code.start(image, function))
    except NoBound as error:
        return Bound(None, None, str(error), {})
    rounds = {code.name_of(a): n for a, n in search.rounds.items()}
    return _told(cost, image, rounds)


def _most_rounds(program: Program) -> int:
    """More rounds than any loop of the program takes, or of arithmetic that goes bit by bit."""
    counts = [64]
    for function in program.functions:
        counts += [port.capacity for port in function.inputs if isinstance(port, ListPort)]
        counts += [s.count for s in statements(function.body) if isinstance(s, Loop)]
    return 2 + max(counts)


def _told(cost: Cost, image: Image, rounds: dict[str, int]) -> Bound:
    """What is honest to say of the target."""
    target = image.compiler.target
    if target.machine == "avr":
        return Bound(None, cost.cycles, None, rounds)
    cycles = cost.cycles if target.name == "cortex-m0plus" else None
    return Bound(cost.instructions, cycles, None, rounds)


class Code:
    """What a linked file says: instructions, constants, names."""

    def __init__(self, binary: Binary, machine: str) -> None:
        self.machine = machine
        self._binary = binary
        self._text = {s.address: s.data for s in binary.sections if s.data is not None}
        self._starts = sorted(self._text)
        # A constant may have lost its name; what has none among our own code may be one.
        unnamed = [o for o in binary.unnamed if o.name == ".own"]
        self._objects = sorted((o.address, o.size) for o in (*binary.objects, *unnamed) if o.size)
        self._entries = {a & ~1 for a in binary.functions.values()}
        self._library = binary.span(".library")
        self._known: dict[int, Instruction] = {}
        self._of_machine = self._decoder()

    def decode(self, address: int) -> Instruction:
        """The instruction at an address, decoded once."""
        found = self._known.get(address)
        if found is None:
            found = self._of_machine(address)
            if isinstance(found.flow, Call) and found.flow.target not in self._entries:
                # Where a branch does not reach, Thumb code of one function jumps by the instruction that calls.
                found = replace(found, flow=Jump(found.flow.target))
            self._known[address] = found
        return found

    def _decoder(self) -> Decode:
        if self.machine == "thumb":
            return thumb_decoder(self._bytes)
        if self.machine == "riscv32":
            return lambda address: decode_riscv(self._bytes(address), address, self._bytes(address - 4))
        return lambda address: decode_avr(self._bytes(address), address, self._words)

    def _words(self, address: int) -> int:
        return words(int.from_bytes(self._bytes(address)[:2], "little"))

    def _bytes(self, address: int, size: int = 4) -> bytes:
        """Up to ``size`` bytes of a section; fewer at its end."""
        at = bisect_right(self._starts, address) - 1
        if at < 0:
            return b""
        data = self._text[self._starts[at]]
        offset = address - self._starts[at]
        return (data or b"")[offset : offset + size]

    def name_of(self, address: int) -> str:
        """An address as the function's symbol and an offset."""
        named = [(a & ~1, n) for n, a in self._binary.functions.items() if a & ~1 <= address]
        if not named:
            return f"{address:#x}"
        start, name = max(named)
        return f"{name}+{address - start:#x}" if address > start else name

    def width_of(self, address: int) -> int:
        """How many states are told apart: more in the library, whose divisions keep marks in their operands."""
        return 8 if address in self._library else 2

    def start(self, image: Image, function: str) -> State:
        """The state at a call: its arguments point to the probe's objects, of which only pointers are known."""
        index = [f.name for f in image.program.functions].index(function)
        bits = 8 if self.machine == "avr" else 32
        registers = [anything(bits)] * (34 if self.machine == "avr" else 32)
        cells: dict[int, Cell] = {}
        arguments, pointers = self._probe(index)
        stack, end = _STACK[self.machine], _END[self.machine]
        if self.machine == "avr":
            for low, value in zip((24, 22, 20), arguments, strict=False):
                registers[low : low + 2] = [constant(value, 8), constant(value >> 8 & 255, 8)]
            registers[1] = constant(0, 8)
            registers[AVR_SP : AVR_SP + 2] = [constant(stack - 2, 8), constant(stack - 2 >> 8, 8)]
            cells[stack] = Cell(1, constant(end // 2, 8), True)
            cells[stack - 1] = Cell(1, constant(end // 2 >> 8, 8), True)
            for at, value in pointers:
                cells[at] = Cell(1, constant(value, 8), True)
                cells[at + 1] = Cell(1, constant(value >> 8, 8), True)
        else:
            first, sp, link = (0, 13, 14) if self.machine == "thumb" else (10, 2, 1)
            for offset, value in enumerate(arguments):
                registers[first + offset] = constant(value, 32)
            registers[sp] = constant(stack, 32)
            registers[link] = constant(end | (self.machine == "thumb"), 32)
            if self.machine == "riscv32":
                registers[0] = constant(0, 32)
            for at, value in pointers:
                cells[at] = Cell(4, constant(value, 32), True)
        return State(bits, registers, cells, NO_FLAGS, self.constants, (Frame(stack - 2 * (bits == 8), 0),))

    def _probe(self, index: int) -> tuple[list[int], list[tuple[int, int]]]:
        """The arguments of a function, and (where, what) of the pointers in its input."""
        mask = 0xFFFF if self.machine == "avr" else 0xFFFFFFFF
        width = 2 if self.machine == "avr" else 4
        read = self._read(pointer_symbol(index), width, mask)
        arguments = [next(read) for _ in range(next(read))]
        pairs = list(read)
        return arguments, list(zip(pairs[::2], pairs[1::2], strict=True))

    def _read(self, symbol: str, width: int, mask: int) -> Iterator[int]:
        (found,) = [o for o in self._binary.objects if o.name == symbol]
        data = self._bytes(found.address, found.size)
        for at in range(0, found.size, width):
            yield int.from_bytes(data[at : at + width], "little") & mask

    def constants(self, address: Value, size: int, program: bool) -> Value | None:
        """What constant memory holds there; where the address is not one, of the objects that it may be in.

        C does not read past an object: of a range that reaches beyond one, the rest is left out.
        """
        if self.machine == "avr" and not program:
            return None
        lo, hi = address.lo, address.hi
        if not program and not (self._is_constant(lo) and self._is_constant(hi)):
            return None
        if address.step == 0:
            data = self._bytes(lo, size)
            return constant(int.from_bytes(data, "little"), 8 * size) if len(data) == size else None
        found: Value | None = None
        for start, length in self._objects:
            for at in range(max(start, lo), min(start + length - size, hi) + 1):
                if (at - lo) % address.step:
                    continue
                one = constant(int.from_bytes(self._bytes(at, size), "little"), 8 * size)
                found = one if found is None else join(found, one, 8 * size)
                if found.hi - found.lo == (1 << 8 * size) - 1:
                    return found
        return found

    def _is_constant(self, address: int) -> bool:
        at = bisect_right(self._starts, address) - 1
        return at >= 0 and self._starts[at] < 0x20000000 and bool(self._bytes(address, 1))


__all__ = ["Bound", "Code", "between", "derive"]
