"""A module's C on one machine, built in one way: what of it came back, or how it died."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from types import TracebackType
from typing import Any, Literal, Protocol, assert_never

import numpy as np
import numpy.typing as npt

from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.fixed.program import Program
from fuzzyspec.machines.elf import WAY_OUT
from fuzzyspec.machines.emulate import Emulation
from fuzzyspec.machines.image import EmulationError, Image
from fuzzyspec.machines.qemu import PACKAGE, QEMU, QemuEmulation, qemu_is_here
from fuzzyspec.machines.simavr import SIMAVR, AvrEmulation, simavr_is_here
from fuzzyspec.machines.toolchains import CrossCompiler
from fuzzyspec.machines.wasm import WasmEmulation
from fuzzyspec.native import Death, Result
from fuzzyspec.native.layout import appended
from fuzzyspec.native.module import broadcast_initial

Emulators = Literal["unicorn", "qemu", "simavr", "wasmtime"]
Signals = Mapping[str, npt.ArrayLike]

_ELF = ("pyelftools", "elftools")
PACKAGES: Mapping[Emulators, tuple[tuple[str, str], ...]] = {
    "unicorn": (("unicorn", "unicorn"), _ELF),
    "qemu": (),
    "simavr": (_ELF,),
    "wasmtime": (("wasmtime", "wasmtime"),),
}
"""By emulator the packages that it takes, with the modules by which they are found."""


Arrays = Mapping[str, npt.NDArray[Any]]


class Emulator(Protocol):
    """What runs an image."""

    def run(self, function: str, inputs: Signals, state: Signals | None = None) -> Result: ...

    def selftest(self) -> int: ...


class EmulatedMachine:
    """The C built for a target and run in its emulator. The folder vanishes with ``close`` (or the end of ``with``)."""

    def __init__(
        self,
        program: Program,
        files: Mapping[str, bytes],
        compiler: CrossCompiler,
        level: str,
        seconds: float = 60.0,
        emulator: Emulators | None = None,
    ) -> None:
        """Build and link. ``seconds`` limits some thousands of calls; ``emulator`` as ``find_emulator`` gives it.

        Raises BuildError where the compiler rejects the C, MissingTool where the emulator is not installed.
        """
        self._program = program
        self._image = Image(program, files, compiler, level)
        try:
            self._emulator = _emulator(self._image, seconds, emulator or emulator_of(compiler))
        except BaseException:
            self._image.close()
            raise

    def run(self, function: str, inputs: Signals, state: Signals | None = None) -> Result | Death:
        """As ``native.NativeProcess.run``. Raises ``simavr.DoesNotFit`` where the device is too small."""
        if not state and self._program.function(function).state:
            state = broadcast_initial(self._program, function, inputs)
        signals = {k: np.asarray(v) for k, v in inputs.items()}
        return self._run(function, signals, {k: np.asarray(v) for k, v in (state or {}).items()})

    def _run(self, function: str, inputs: Arrays, state: Arrays) -> Result | Death:
        """Time passes faster on a machine that has much to do: what was late is run again, split at the late case, and
        only a call that alone takes all the time there is has no end."""
        try:
            return self._emulator.run(function, inputs, state or None)
        except EmulationError as error:
            at = error.case
            if not (error.late and at):
                return Death(at, str(error), "")
        before = self._run(function, _lanes(inputs, slice(None, at)), _lanes(state, slice(None, at)))
        if isinstance(before, Death):
            return before
        after = self._run(function, _lanes(inputs, slice(at, None)), _lanes(state, slice(at, None)))
        return (
            Death(at + after.case, after.what, after.output) if isinstance(after, Death) else appended([before, after])
        )

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


def _lanes(arrays: Arrays, lanes: slice) -> dict[str, npt.NDArray[Any]]:
    return {k: v[lanes] for k, v in arrays.items()}


def emulator_of(compiler: CrossCompiler) -> Emulators:
    """What runs a target's images, unless something else is asked for."""
    match compiler.target.machine:
        case "thumb" | "riscv32" | "mips":
            return "unicorn"
        case "avr":
            return "simavr"
        case "wasm32":
            return "wasmtime"
        case _:
            assert_never(compiler.target.machine)


def find_emulator(compiler: CrossCompiler, wanted: Emulators | None = None) -> Emulators:
    """What runs a target's images: ``wanted`` where it can, else its usual emulator, else QEMU where that is here.

    MissingTool where it is not installed.
    """
    machine = compiler.target.machine
    usual = emulator_of(compiler)
    name = wanted if wanted == "qemu" and machine in QEMU else usual
    lacking = _lacking(name, compiler)
    if lacking is None:
        return name
    if wanted is None and qemu_is_here(machine):
        return "qemu"
    raise lacking


def _lacking(name: Emulators, compiler: CrossCompiler) -> MissingTool | None:
    """What an emulator lacks."""
    machine, what = compiler.target.machine, f"is needed to run what is built for {compiler.target.name}"
    if name == "simavr" and not simavr_is_here():
        return MissingTool(f"simavr {what}", f"get it: {SIMAVR}")
    if name == "qemu" and not qemu_is_here(machine):
        return MissingTool(f"{QEMU[machine][0]} {what}", f"get it: {PACKAGE}")
    for package, module in PACKAGES[name]:
        if importlib.util.find_spec(module) is None:
            return MissingTool(f"the package {package} {what}", WAY_OUT)
    return None


def _emulator(image: Image, seconds: float, name: Emulators) -> Emulator:
    match name:
        case "unicorn":
            return Emulation(image, selftest=True, seconds=seconds)
        case "qemu":
            return QemuEmulation(image, seconds)
        case "simavr":
            return AvrEmulation(image, seconds)
        case "wasmtime":
            return WasmEmulation(image, seconds)
        case _:
            assert_never(name)
