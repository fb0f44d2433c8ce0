"""Runs an image in the emulator ``unicorn``: results of N cases, and what each call took."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fuzzyspec.cost.elf import WAY_OUT, Binary
from fuzzyspec.cost.harness import batch_symbol
from fuzzyspec.cost.image import FLASH, RAM, Image
from fuzzyspec.cost.stack import PAINT, untouched
from fuzzyspec.cost.stream import decode, encode, result_size
from fuzzyspec.cost.thumb import Block, decode_thumb
from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.native.layout import Result, layout_of

Ints = npt.NDArray[np.int64]
Signals = Mapping[str, npt.ArrayLike]

_PAGE = 0x1000
_STACK, _STACK_SIZE = 0x28000000, 0x10000
_CASES, _RESULTS = 0x30000000, 0x50000000
_END = 0x08000000
"""Where the harness returns to; nothing is executed there."""
_CHUNK = 1 << 16
_SECONDS = 300


class EmulationError(Exception):
    """The built code did not come to its end: a fault, or no end at all."""


@dataclass(frozen=True, slots=True)
class Calls:
    """N measured calls: ``instructions`` (N,), ``cycles`` (N,) where there is a model of them, else None.

    ``stack``: the deepest that any call went below the stack pointer it was called with, in bytes.
    """

    result: Result
    instructions: Ints
    cycles: Ints | None
    stack: int


class Emulation:
    """An image in the emulator. Every run starts an engine of its own."""

    def __init__(self, image: Image) -> None:
        """Link the image. Raises MissingTool where unicorn is not installed."""
        try:
            import unicorn  # noqa: F401
        except ImportError as error:
            raise MissingTool("the package unicorn is needed to run what was built", WAY_OUT) from error
        self.image = image
        self.binary: Binary = image.emulated()
        self._layouts = {f.name: layout_of(image.program, f, image.names) for f in image.program.functions}

    def run(self, function: str, inputs: Signals, state: Signals | None = None) -> Result:
        """N calls of the function named as in the spec, over raws as ``native.NativeModule.run`` takes them.

        Nothing is counted, so this is fast. Raises ValueError for signals that do not fit, EmulationError.
        """
        cases = encode(self._layouts[function], inputs, state)
        found = [self._batch(function, cases[at : at + _CHUNK], None) for at in range(0, len(cases), _CHUNK)]
        return decode(self._layouts[function], b"".join(found), len(cases))

    def measure(self, function: str, inputs: Signals, state: Signals | None = None) -> Calls:
        """As ``run``, and what each call took, from the function's first instruction to its return."""
        layout = self._layouts[function]
        cases = encode(layout, inputs, state)
        counter = Counter(self, self.binary.symbols[self.image.names.functions[function].function] & ~1)
        results = b"".join(
            self._batch(function, cases[at : at + _CHUNK], counter) for at in range(0, len(cases), _CHUNK)
        )
        if len(counter.instructions) != len(cases):
            raise EmulationError(f"{len(cases)} cases made {len(counter.instructions)} calls")
        cycles = None if counter.unknown else np.array(counter.cycles, dtype=np.int64)
        instructions = np.array(counter.instructions, dtype=np.int64)
        return Calls(decode(layout, results, len(cases)), instructions, cycles, counter.deepest)

    def _batch(self, function: str, cases: npt.NDArray[np.uint8], counter: Counter | None) -> bytes:
        """One chunk through the harness."""
        import unicorn

        n = len(cases)
        index = [f.name for f in self.image.program.functions].index(function)
        size = n * result_size(self._layouts[function])
        engine, registers = _engine(self.image.compiler.target.cpu)
        for section in self.binary.sections:
            _map(engine, section.address, section.size, writable=section.address >= RAM)
            if section.data is not None:
                engine.mem_write(section.address, section.data)
        _map(engine, _END, _PAGE, writable=False)
        _map(engine, _CASES, max(cases.size, 1), writable=False)
        engine.mem_write(_CASES, cases.tobytes())
        _map(engine, _RESULTS, max(size, 1), writable=True)
        _map(engine, _STACK, _STACK_SIZE, writable=True)
        engine.mem_write(_STACK, bytes([PAINT]) * _STACK_SIZE)
        sp, link, *arguments = registers
        for register, value in zip(
            (sp, *arguments, link), (_STACK + _STACK_SIZE, n, _CASES, _RESULTS, _END | 1), strict=True
        ):
            engine.reg_write(register, value)
        if counter is not None:
            counter.attach(engine, sp)
        entry = self.binary.symbols[batch_symbol(index)]
        if self.image.compiler.target.machine == "thumb":
            entry |= 1
        else:
            engine.reg_write(link, _END)
        try:
            engine.emu_start(entry, _END, timeout=_SECONDS * 1_000_000)
        except unicorn.UcError as error:
            raise EmulationError(f"{function}: {error} at {_pc(engine):#x}") from error
        if _pc(engine) & ~1 != _END:
            raise EmulationError(f"{function}: no end after {_SECONDS} s, at {_pc(engine):#x}")
        if counter is not None:
            counter.finish(_STACK + untouched(engine.mem_read(_STACK, _STACK_SIZE)))
        return bytes(engine.mem_read(_RESULTS, size)) if size else b""


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


def _engine(cpu: str) -> tuple[Any, tuple[int, ...]]:
    """A new engine, and its registers: stack pointer, link, three arguments."""
    import unicorn
    from unicorn import arm_const as arm
    from unicorn import riscv_const as riscv

    if cpu == "RV32IMC":
        engine = unicorn.Uc(unicorn.UC_ARCH_RISCV, unicorn.UC_MODE_RISCV32)
        a = (riscv.UC_RISCV_REG_A0, riscv.UC_RISCV_REG_A1, riscv.UC_RISCV_REG_A2)
        return engine, (riscv.UC_RISCV_REG_SP, riscv.UC_RISCV_REG_RA, *a)
    engine = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
    models = {
        "Cortex-M0+": arm.UC_CPU_ARM_CORTEX_M0,
        "Cortex-M4": arm.UC_CPU_ARM_CORTEX_M4,
        "Cortex-M7": arm.UC_CPU_ARM_CORTEX_M7,
    }
    engine.ctl_set_cpu_model(models[cpu])
    r = (arm.UC_ARM_REG_R0, arm.UC_ARM_REG_R1, arm.UC_ARM_REG_R2)
    return engine, (arm.UC_ARM_REG_SP, arm.UC_ARM_REG_LR, *r)


def _map(engine: Any, address: int, size: int, *, writable: bool) -> None:
    """Map the pages of a range that are not mapped yet."""
    import unicorn

    rights = unicorn.UC_PROT_READ | (unicorn.UC_PROT_WRITE if writable else unicorn.UC_PROT_EXEC)
    mapped = {page for lo, hi, _ in engine.mem_regions() for page in range(lo, hi + 1, _PAGE)}
    first, last = address & -_PAGE, (address + size - 1) & -_PAGE
    missing = [page for page in range(first, last + 1, _PAGE) if page not in mapped]
    if missing:
        engine.mem_map(missing[0], missing[-1] + _PAGE - missing[0], rights)


def _pc(engine: Any) -> int:
    import unicorn
    from unicorn import arm_const, riscv_const

    risc = engine._arch == unicorn.UC_ARCH_RISCV
    return int(engine.reg_read(riscv_const.UC_RISCV_REG_PC if risc else arm_const.UC_ARM_REG_PC))


assert FLASH < _END < RAM < _STACK < _CASES < _RESULTS
