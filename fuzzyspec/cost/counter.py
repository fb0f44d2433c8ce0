"""What each of N emulated calls took: instructions, cycles where there is a model of them, stack."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fuzzyspec.cost.thumb import Block, decode_thumb
from fuzzyspec.machines.emulate import Emulation
from fuzzyspec.machines.image import EmulationError
from fuzzyspec.machines.stream import decode, encode
from fuzzyspec.native.layout import Result

Ints = npt.NDArray[np.int64]
Signals = Mapping[str, npt.ArrayLike]


@dataclass(frozen=True, slots=True)
class Calls:
    """N measured calls: ``instructions`` (N,), ``cycles`` (N,) where there is a model of them, else None.

    ``stack``: the deepest that any call went below the stack pointer it was called with, in bytes.
    """

    result: Result
    instructions: Ints
    cycles: Ints | None
    stack: int


def measure_calls(emulation: Emulation, function: str, inputs: Signals, state: Signals | None = None) -> Calls:
    """As ``Emulation.run``, and what each call took, from the function's first instruction to its return."""
    layout = emulation.layouts[function]
    cases = encode(layout, inputs, state)
    counter = Counter(emulation, emulation.binary.symbols[emulation.image.names.functions[function].function] & ~1)
    results = emulation.results(function, cases, counter)
    if len(counter.instructions) != len(cases):
        raise EmulationError(f"{len(cases)} cases made {len(counter.instructions)} calls")
    cycles = None if counter.unknown else np.array(counter.cycles, dtype=np.int64)
    instructions = np.array(counter.instructions, dtype=np.int64)
    return Calls(decode(layout, results, len(cases)), instructions, cycles, counter.deepest)


class Counter:
    """Counts what is executed between a call of the function and the harness's next instruction.

    Blocks are counted as they are entered, by the instructions in them: that includes those whose condition fails.
    """

    def __init__(self, emulation: Emulation, entry: int) -> None:
        binary = emulation.binary
        self.instructions: list[int] = []
        self.cycles: list[int] = []
        self.unknown = emulation.image.compiler.target.name != "cortex-m0plus"
        self.deepest = 0
        self._decode = _DECODERS[emulation.image.compiler.target.machine]
        self._entry = entry
        self._harness = binary.span(".harness")
        self._level: int | None = None
        self._lowest = 0

    def attach(self, engine: Any, sp: int) -> None:
        """Listen to an engine that is about to run."""
        import unicorn

        known: dict[tuple[int, int], Block] = {}
        instructions, cycles, harness, entry = self.instructions, self.cycles, self._harness, self._entry
        inside = False
        fall_through = -1
        self._level = None

        def on_block(uc: Any, address: int, size: int, _: object) -> None:
            nonlocal inside, fall_through
            if address in harness:
                inside = False
                return
            level = uc.reg_read(sp)
            if not inside:
                if address != entry:
                    return
                inside = True
                fall_through = -1
                instructions.append(0)
                cycles.append(0)
                if self._level is None:
                    self._level = self._lowest = level
            block = known.get((address, size))
            if block is None:
                block = known[address, size] = self._decode(bytes(uc.mem_read(address, size)))
                self.unknown = self.unknown or block.cycles is None
            instructions[-1] += block.instructions
            cycles[-1] += block.cycles or 0
            if fall_through not in (-1, address):
                cycles[-1] += 1
            fall_through = address + size if block.conditional else -1
            self._lowest = min(self._lowest, level)

        engine.hook_add(unicorn.UC_HOOK_BLOCK, on_block)

    def finish(self, lowest_written: int) -> None:
        """The chunk is done: the lowest address at which the paint is gone tells how deep the calls went."""
        if self._level is not None:
            self.deepest = max(self.deepest, self._level - min(self._lowest, lowest_written))


def _decode_riscv(code: bytes) -> Block:
    at = count = 0
    while at < len(code):
        at += 4 if code[at] & 3 == 3 else 2
        count += 1
    return Block(count, None, False)


_DECODERS: Mapping[str, Callable[[bytes], Block]] = {"thumb": decode_thumb, "riscv32": _decode_riscv}
