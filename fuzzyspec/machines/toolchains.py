"""The targets, and the compilers that build for them: a gcc where one is installed, else the ``ziglang`` package."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Literal

from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.native.toolchain import Toolchain

Machine = Literal["thumb", "riscv32", "mips", "avr", "wasm32"]
Kind = Literal["gcc", "zig"]
KINDS: tuple[Kind, ...] = ("gcc", "zig")

OPTIMISATIONS = ("O2", "Os")

OWN = ("-std=c99", "-ffreestanding", "-ffunction-sections", "-fdata-sections")
"""How the generated C is compiled, besides the optimisation and the CPU: sections let the linker drop what a
function does not use."""

ZIG_QUIET = ("-fno-sanitize=all", "-fno-unwind-tables", "-fno-asynchronous-unwind-tables")
"""zig cc's defaults, which no firmware wants, turned off."""


@dataclass(frozen=True, slots=True)
class Target:
    """``gcc`` is the cross compiler's name and its flags; ``zig`` the flags of ``zig cc``; None where it will not do.

    ``cpu`` names the core that is emulated.
    """

    name: str
    machine: Machine
    cpu: str
    gcc: tuple[str, ...] | None
    zig: tuple[str, ...] | None
    package: str | None


_BARE_MIPS = ("-EB", "-march=mips32r2", "-msoft-float", "-mno-abicalls", "-fno-pic", "-no-pie", "-static", "-G0")
"""For a compiler that would else build for GNU/Linux."""


def _cortex(name: str, cpu: str) -> Target:
    return Target(
        name,
        "thumb",
        cpu,
        ("arm-none-eabi-gcc", "-mthumb", f"-mcpu={name}"),
        ("-target", "thumb-freestanding-eabi", f"-mcpu={name.replace('-', '_')}"),
        "apt install --no-install-recommends gcc-arm-none-eabi",
    )


_ALL = (
    _cortex("cortex-m0plus", "Cortex-M0+"),
    _cortex("cortex-m4", "Cortex-M4"),
    _cortex("cortex-m7", "Cortex-M7"),
    Target(
        "rv32imc",
        "riscv32",
        "RV32IMC",
        ("riscv64-unknown-elf-gcc", "-march=rv32imc", "-mabi=ilp32"),
        ("-target", "riscv32-freestanding-none", "-mcpu=generic_rv32+m+c"),
        "apt install gcc-riscv64-unknown-elf",
    ),
    # zig has no <avr/pgmspace.h>, without which the tables would go to RAM.
    Target("avr", "avr", "ATmega328P", ("avr-gcc", "-mmcu=atmega328p"), None, "apt install gcc-avr avr-libc"),
    # Big-endian.
    Target(
        "mips-be",
        "mips",
        "MIPS32R2",
        ("mips-linux-gnu-gcc", *_BARE_MIPS),
        ("-target", "mips-freestanding-eabi", "-mcpu=mips32r2+soft_float", "-fno-pic", "-mno-abicalls"),
        "apt install gcc-mips-linux-gnu",
    ),
    Target("wasm32", "wasm32", "WebAssembly", None, ("-target", "wasm32-freestanding"), None),
)
TARGETS: Mapping[str, Target] = MappingProxyType({t.name: t for t in _ALL})


@dataclass(frozen=True, slots=True)
class CrossCompiler:
    """A compiler for one target."""

    target: Target
    kind: Kind
    toolchain: Toolchain

    @property
    def description(self) -> str:
        """Name and version, without a folder."""
        return description_of(self.kind, self.toolchain.command)

    def compile(self, source: Path, made: Path, option: str, flags: Sequence[str] = OWN) -> None:
        """One object file. Raises BuildError."""
        quiet = ZIG_QUIET if self.kind == "zig" else ()
        self.toolchain.build([source], made, ("-c", f"-{option}", *flags, *quiet))

    def link(
        self, objects: Sequence[Path], script: Path, made: Path, roots: Sequence[str], data: Sequence[str] = ()
    ) -> None:
        """An image laid out by a linker script: the roots, what they need, and nothing else. Raises BuildError.

        ``data``: variables that must be found by name.
        """
        if self.target.machine == "wasm32":
            shown = [f"-Wl,--export={name}" for name in (*roots, *data, "__heap_base")]
            self.toolchain.build(objects, made, ("-nostdlib", "-Wl,--no-entry", "-Wl,--gc-sections", *shown))
            return
        wanted = [f"-Wl,-u,{name}" for name in roots]
        flags = ("-nostdlib", f"-Wl,-T,{script.name}", "-Wl,--gc-sections", f"-Wl,-e,{roots[0]}", *wanted)
        libraries = ("-lm", "-lgcc") if self.target.machine == "avr" else ("-lgcc",)  # AVR's floats are in avr-libc
        self.toolchain.build(objects, made, flags, ("-lcompiler_rt",) if self.kind == "zig" else libraries)


def find_compiler(target: Target, kind: Kind | None = None) -> CrossCompiler:
    """The target's gcc, else zig; only ``kind`` where that is given. MissingTool says how to get one."""
    if kind in (None, "gcc") and target.gcc is not None and shutil.which(target.gcc[0]) is not None:
        return CrossCompiler(target, "gcc", Toolchain(target.gcc))
    if kind in (None, "zig") and target.zig is not None and importlib.util.find_spec("ziglang") is not None:
        return CrossCompiler(target, "zig", Toolchain((sys.executable, "-m", "ziglang", "cc", *target.zig)))
    ways = [target.package] if target.package is not None and kind != "zig" else []
    if target.zig is not None and kind != "gcc":
        ways.append("pip install 'fuzzyc[targets]'")
    if not ways:
        raise MissingTool(f"{kind} cannot build for {target.name}", f"leave out --compiler {kind}")
    raise MissingTool(f"no compiler for {target.name} was found", f"get one: {' or '.join(ways)}")


@cache
def description_of(kind: Kind, command: tuple[str, ...]) -> str:
    """Name and version of a compiler, without a folder."""
    if kind == "zig":
        from importlib.metadata import version

        return f"zig cc (ziglang {version('ziglang')})"
    done = subprocess.run([command[0], "-dumpversion"], capture_output=True, text=True, check=False)
    return f"{Path(command[0]).name} {done.stdout.strip()}"
