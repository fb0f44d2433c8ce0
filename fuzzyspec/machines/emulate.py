"""Runs an image in the emulator ``unicorn``: the results of N cases."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.machines.elf import WAY_OUT, Binary
from fuzzyspec.machines.harness import batch_symbol
from fuzzyspec.machines.image import FLASH, RAM, Image
from fuzzyspec.machines.stack import PAINT, untouched
from fuzzyspec.machines.stream import decode, encode, result_size
from fuzzyspec.native.layout import Result, layout_of

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


class Listener(Protocol):
    """Watches a run: told of every engine before it starts, and after it has come to its end."""

    def attach(self, engine: Any, sp: int) -> None:
        """``sp`` is the engine's name for the stack pointer."""

    def finish(self, lowest_written: int) -> None:
        """``lowest_written``: the lowest address of the stack whose paint is gone."""


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
        self.layouts = {f.name: layout_of(image.program, f, image.names) for f in image.program.functions}

    def run(self, function: str, inputs: Signals, state: Signals | None = None) -> Result:
        """N calls of the function named as in the spec, over raws as ``native.NativeModule.run`` takes them.

        Nothing is counted, so this is fast. Raises ValueError for signals that do not fit, EmulationError.
        """
        cases = encode(self.layouts[function], inputs, state)
        return decode(self.layouts[function], self.results(function, cases), len(cases))

    def results(self, function: str, cases: npt.NDArray[np.uint8], listener: Listener | None = None) -> bytes:
        """The stream of results of a stream of cases (``stream``), a chunk at a time. Raises EmulationError."""
        parts = (cases[at : at + _CHUNK] for at in range(0, len(cases), _CHUNK))
        return b"".join(self._batch(function, part, listener) for part in parts)

    def _batch(self, function: str, cases: npt.NDArray[np.uint8], listener: Listener | None) -> bytes:
        """One chunk through the harness."""
        import unicorn

        n = len(cases)
        index = [f.name for f in self.image.program.functions].index(function)
        size = n * result_size(self.layouts[function])
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
        if listener is not None:
            listener.attach(engine, sp)
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
        if listener is not None:
            listener.finish(_STACK + untouched(engine.mem_read(_STACK, _STACK_SIZE)))
        return bytes(engine.mem_read(_RESULTS, size)) if size else b""


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
