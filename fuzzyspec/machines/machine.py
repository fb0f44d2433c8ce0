"""A module's C on one machine, built in one way: what of it came back, or how it died."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from types import TracebackType
from typing import Protocol, assert_never

import numpy.typing as npt

from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.fixed.program import Program
from fuzzyspec.machines.elf import WAY_OUT
from fuzzyspec.machines.emulate import Emulation
from fuzzyspec.machines.image import EmulationError, Image
from fuzzyspec.machines.simavr import SIMAVR, AvrEmulation, simavr_is_here
from fuzzyspec.machines.toolchains import CrossCompiler
from fuzzyspec.machines.wasm import WasmEmulation
from fuzzyspec.native import Death, Result
from fuzzyspec.native.module import broadcast_initial

Signals = Mapping[str, npt.ArrayLike]

_ELF = ("pyelftools", "elftools")
PACKAGES: Mapping[str, tuple[tuple[str, str], ...]] = {
    "unicorn": (("unicorn", "unicorn"), _ELF),
    "simavr": (_ELF,),
    "wasmtime": (("wasmtime", "wasmtime"),),
}
"""By emulator the packages that it takes, with the modules by which they are found."""


class Emulator(Protocol):
    """What runs an image."""

    def run(self, function: str, inputs: Signals, state: Signals | None = None) -> Result: ...

    def selftest(self) -> int: ...


class EmulatedMachine:
    """The C built for a target and run in its emulator. The folder vanishes with ``close`` (or the end of ``with``)."""

    def __init__(
        self, program: Program, files: Mapping[str, bytes], compiler: CrossCompiler, level: str, seconds: float = 60.0
    ) -> None:
        """Build and link. ``seconds`` limits some thousands of calls.

        Raises BuildError where the compiler rejects the C, MissingTool where the emulator is not installed.
        """
        self._program = program
        self._image = Image(program, files, compiler, level)
        try:
            self._emulator = _emulator(self._image, seconds)
        except BaseException:
            self._image.close()
            raise

    def run(self, function: str, inputs: Signals, state: Signals | None = None) -> Result | Death:
        """As ``native.NativeProcess.run``. Raises ``simavr.DoesNotFit`` where the device is too small."""
        if not state and self._program.function(function).state:
            state = broadcast_initial(self._program, function, inputs)
        try:
            return self._emulator.run(function, inputs, state)
        except EmulationError as error:
            return Death(error.case, str(error), "")

    def selftest(self) -> int | Death:
        """0, or 1 + the index of the first golden vector that differs. Raises as ``run``."""
        try:
            return self._emulator.selftest()
        except EmulationError as error:
            return Death(0, str(error), "")

    def close(self) -> None:
        """Remove what was built."""
        self._image.close()

    def __enter__(self) -> EmulatedMachine:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def emulator_of(compiler: CrossCompiler) -> str:
    """The name of what runs a target's images."""
    match compiler.target.machine:
        case "thumb" | "riscv32" | "mips":
            return "unicorn"
        case "avr":
            return "simavr"
        case "wasm32":
            return "wasmtime"
        case _:
            assert_never(compiler.target.machine)


def find_emulator(compiler: CrossCompiler) -> str:
    """The name of what runs a target's images. MissingTool where it is not installed."""
    name, what = emulator_of(compiler), f"is needed to run what is built for {compiler.target.name}"
    if name == "simavr" and not simavr_is_here():
        raise MissingTool(f"simavr {what}", f"get it: {SIMAVR}")
    for package, module in PACKAGES[name]:
        if importlib.util.find_spec(module) is None:
            raise MissingTool(f"the package {package} {what}", WAY_OUT)
    return name


def _emulator(image: Image, seconds: float) -> Emulator:
    match image.compiler.target.machine:
        case "thumb" | "riscv32" | "mips":
            return Emulation(image, selftest=True, seconds=seconds)
        case "avr":
            return AvrEmulation(image, seconds)
        case "wasm32":
            return WasmEmulation(image, seconds)
        case _:
            assert_never(image.compiler.target.machine)
