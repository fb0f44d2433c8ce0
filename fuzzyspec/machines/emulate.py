"""Runs an image in the emulator ``unicorn``: the results of N cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.machines.elf import WAY_OUT, Binary, read_elf
from fuzzyspec.machines.harness import LEFT, batch_symbol
from fuzzyspec.machines.image import FLASH, RAM, EmulationError, Image
from fuzzyspec.machines.stack import PAINT, untouched
from fuzzyspec.machines.stream import decode, encode, result_size
from fuzzyspec.native.layout import Result, layout_of

Signals = Mapping[str, npt.ArrayLike]

_PAGE = 0x1000
_STACK, _STACK_SIZE = 0x28000000, 0x10000
_HOME = 64
"""Bytes above the stack pointer: some calling conventions let a callee store its arguments there."""
_CASES, _RESULTS = 0x30000000, 0x50000000
_END = 0x08000000
"""Where the harness returns to; nothing is executed there."""
_CHUNK = 1 << 14
_SECONDS = 300


class Listener(Protocol):
    """Watches a run: told of every engine before it starts, and after it has come to its end."""

    def attach(self, engine: Any, sp: int) -> None:
        """``sp`` is the engine's name for the stack pointer."""

    def finish(self, lowest_written: int) -> None:
        """``lowest_written``: the lowest address of the stack whose paint is gone."""


@dataclass(frozen=True, slots=True)
class _Registers:
    """The emulator's names of a core's registers."""

    sp: int
    link: int
    pc: int
    arguments: tuple[int, int, int]
    result: int


class Emulation:
    """An image in the emulator. Every run starts an engine of its own."""

    def __init__(self, image: Image, *, selftest: bool = False, seconds: float = _SECONDS) -> None:
        """Link the image. ``seconds`` limits some thousands of calls. MissingTool where unicorn is not installed."""
        try:
            import unicorn  # noqa: F401
        except ImportError as error:
            raise MissingTool("the package unicorn is needed to run what was built", WAY_OUT) from error
        self.image = image
        self.binary: Binary = read_elf(image.emulated(selftest=selftest))
        self.layouts = {f.name: layout_of(image.program, f, image.names) for f in image.program.functions}
        self._seconds = seconds

    def run(self, function: str, inputs: Signals, state: Signals | None = None) -> Result:
        """N calls of the function named as in the spec, over raws as ``native.NativeModule.run`` takes them.

        Nothing is counted, so this is fast. Raises ValueError for signals that do not fit, EmulationError.
        """
        cases = encode(self.layouts[function], inputs, state)
        return decode(self.layouts[function], self.results(function, cases), len(cases))

    def results(self, function: str, cases: npt.NDArray[np.uint8], listener: Listener | None = None) -> bytes:
        """The stream of results of a stream of cases (``stream``), a chunk at a time. Raises EmulationError."""
        found: list[bytes] = []
        for at in range(0, len(cases), _CHUNK):
            try:
                found.append(self._batch(function, cases[at : at + _CHUNK], listener))
            except EmulationError as error:
                raise EmulationError(f"{function}: {error}", at + error.case, late=error.late) from error
        return b"".join(found)

    def selftest(self) -> int:
        """What the self-test returns, if it was linked in. Raises EmulationError."""
        engine, registers = self._engine()
        self._start(engine, registers, self.image.names.selftest, ())
        return int(engine.reg_read(registers.result)) & 0xFFFF

    def _batch(self, function: str, cases: npt.NDArray[np.uint8], listener: Listener | None) -> bytes:
        """One chunk through the harness."""
        n = len(cases)
        index = [f.name for f in self.image.program.functions].index(function)
        size = n * result_size(self.layouts[function])
        engine, registers = self._engine()
        _map(engine, _CASES, max(cases.size, 1), writable=False)
        engine.mem_write(_CASES, cases.tobytes())
        _map(engine, _RESULTS, max(size, 1), writable=True)
        if listener is not None:
            listener.attach(engine, registers.sp)
        try:
            self._start(engine, registers, batch_symbol(index), (n, _CASES, _RESULTS))
        except EmulationError as error:
            left = self._word(engine, self.binary.symbols[LEFT])
            raise EmulationError(str(error), n - left if 0 < left <= n else 0, late=error.late) from error
        if listener is not None:
            listener.finish(_STACK + untouched(engine.mem_read(_STACK, _STACK_SIZE)))
        return bytes(engine.mem_read(_RESULTS, size)) if size else b""

    def _engine(self) -> tuple[Any, _Registers]:
        """An engine with the image and a painted stack."""
        engine, registers = _engine(self.image.compiler.target.cpu)
        for section in self.binary.sections:
            _map(engine, section.address, section.size, writable=section.address >= RAM)
            if section.data is not None:
                engine.mem_write(section.address, section.data)
        _map(engine, _END, _PAGE, writable=False)
        _map(engine, _STACK, _STACK_SIZE, writable=True)
        engine.mem_write(_STACK, bytes([PAINT]) * _STACK_SIZE)
        return engine, registers

    def _start(self, engine: Any, registers: _Registers, symbol: str, arguments: Sequence[int]) -> None:
        """Call a function of the image, and wait for it to return."""
        import unicorn

        thumb = int(self.image.compiler.target.machine == "thumb")
        engine.reg_write(registers.sp, _STACK + _STACK_SIZE - _HOME)
        engine.reg_write(registers.link, _END | thumb)
        for register, value in zip(registers.arguments, arguments, strict=False):
            engine.reg_write(register, value)
        try:
            engine.emu_start(self.binary.symbols[symbol] | thumb, _END, timeout=int(self._seconds * 1_000_000))
        except unicorn.UcError as error:
            raise EmulationError(f"{error} at {engine.reg_read(registers.pc):#x}") from error
        at = int(engine.reg_read(registers.pc))
        if at & ~1 != _END:
            raise EmulationError(f"no end after {self._seconds:g} s, at {at:#x}", late=True)

    def _word(self, engine: Any, address: int) -> int:
        big = self.image.compiler.target.machine == "mips"
        return int.from_bytes(engine.mem_read(address, 4), "big" if big else "little")


def _engine(cpu: str) -> tuple[Any, _Registers]:
    """A new engine for a core."""
    import unicorn
    from unicorn import arm_const as arm
    from unicorn import mips_const as mips
    from unicorn import riscv_const as riscv

    if cpu == "RV32IMC":
        a = (riscv.UC_RISCV_REG_A0, riscv.UC_RISCV_REG_A1, riscv.UC_RISCV_REG_A2)
        registers = _Registers(riscv.UC_RISCV_REG_SP, riscv.UC_RISCV_REG_RA, riscv.UC_RISCV_REG_PC, a, a[0])
        return unicorn.Uc(unicorn.UC_ARCH_RISCV, unicorn.UC_MODE_RISCV32), registers
    if cpu == "MIPS32R2":
        a = (mips.UC_MIPS_REG_A0, mips.UC_MIPS_REG_A1, mips.UC_MIPS_REG_A2)
        v = mips.UC_MIPS_REG_V0
        registers = _Registers(mips.UC_MIPS_REG_SP, mips.UC_MIPS_REG_RA, mips.UC_MIPS_REG_PC, a, v)
        return unicorn.Uc(unicorn.UC_ARCH_MIPS, unicorn.UC_MODE_MIPS32 | unicorn.UC_MODE_BIG_ENDIAN), registers
    engine = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
    models = {
        "Cortex-M0+": arm.UC_CPU_ARM_CORTEX_M0,
        "Cortex-M4": arm.UC_CPU_ARM_CORTEX_M4,
        "Cortex-M7": arm.UC_CPU_ARM_CORTEX_M7,
    }
    engine.ctl_set_cpu_model(models[cpu])
    r = (arm.UC_ARM_REG_R0, arm.UC_ARM_REG_R1, arm.UC_ARM_REG_R2)
    return engine, _Registers(arm.UC_ARM_REG_SP, arm.UC_ARM_REG_LR, arm.UC_ARM_REG_PC, r, r[0])


def _map(engine: Any, address: int, size: int, *, writable: bool) -> None:
    """Map the pages of a range that are not mapped yet."""
    import unicorn

    rights = unicorn.UC_PROT_READ | (unicorn.UC_PROT_WRITE if writable else unicorn.UC_PROT_EXEC)
    mapped = {page for lo, hi, _ in engine.mem_regions() for page in range(lo, hi + 1, _PAGE)}
    first, last = address & -_PAGE, (address + size - 1) & -_PAGE
    missing = [page for page in range(first, last + 1, _PAGE) if page not in mapped]
    if missing:
        engine.mem_map(missing[0], missing[-1] + _PAGE - missing[0], rights)


assert FLASH < _END < RAM < _STACK < _CASES < _RESULTS
