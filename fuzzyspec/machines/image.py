"""The generated C built for a target: an image to emulate, and each function linked alone to see its size."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from fuzzyspec.emit.names import name_module
from fuzzyspec.fixed.program import Program
from fuzzyspec.machines.elf import Binary, read_elf
from fuzzyspec.machines.harness import LEFT, batch_symbol, pointer_symbol, print_emulated_harness, print_probe
from fuzzyspec.machines.toolchains import OWN, CrossCompiler

_CODE = ".text .text.* .rodata .rodata.* .srodata .srodata.* .progmem .progmem.*"
_DATA = ".data .data.* .bss .bss.* .sdata .sdata.* .sbss .sbss.* COMMON"
FLASH, RAM = 0x10000, 0x20000000
AVR_FLASH, AVR_RAM = 0x0, 0x800100

HARNESS = ("-std=c99", "-ffreestanding", "-fno-builtin", "-ffunction-sections", "-fdata-sections")


@dataclass(frozen=True, slots=True)
class Sizes:
    """Bytes of one function with all that it calls.

    ``flash``: code and tables, with what the compiler's library adds (a division); ``own``: without that. ``ram``:
    static data, 0 for all that fuzzyc generates.
    """

    flash: int
    own: int
    ram: int


class EmulationError(Exception):
    """The built code did not come to its end: a fault, or no end at all (``late``).

    ``case``: how many calls had returned.
    """

    def __init__(self, message: str, case: int = 0, *, late: bool = False) -> None:
        self.case = case
        self.late = late
        super().__init__(message)


class Image:
    """A module's C compiled once for a target, in a folder that vanishes with ``close`` (or the end of ``with``)."""

    def __init__(self, program: Program, files: Mapping[str, bytes], compiler: CrossCompiler, option: str) -> None:
        """Compile. Raises BuildError where the compiler rejects the C, MissingTool where it cannot be started."""
        self.program = program
        self.compiler = compiler
        self.option = option
        self.names = name_module(program)
        self._folder = tempfile.TemporaryDirectory(prefix="fuzzyc-")
        self.path = Path(self._folder.name).resolve()
        try:
            for name, content in files.items():
                (self.path / name).write_bytes(content)
            avr = compiler.target.machine == "avr"
            self.write("layout.ld", _script(AVR_FLASH, AVR_RAM) if avr else _script(FLASH, RAM))
            self.own = self.path / "own.o"
            compiler.compile(self.path / self.names.source, self.own, option, OWN)
        except BaseException:
            self.close()
            raise

    def write(self, name: str, text: str) -> Path:
        """A file in the image's folder."""
        path = self.path / name
        path.write_text(text, encoding="utf-8", newline="\n")
        return path

    def sizes(self, function: str) -> Sizes:
        """The sizes of one function, linked alone."""
        made = self.path / "alone.elf"
        self.compiler.link([self.own], self.path / "layout.ld", made, [self.names.functions[function].function])
        binary = read_elf(made)
        flash = binary.size(".own", ".library")
        return Sizes(flash, binary.size(".own"), binary.size(".own_ram", ".ram"))

    def emulated(self, *, selftest: bool = False, program: tuple[str, str] | None = None) -> Path:
        """All functions with the harness that feeds them (``harness.print_emulated_harness``), linked.

        ``program``: a function that is where the image begins, and the C that it is in.
        """
        source = self.write("harness.c", print_emulated_harness(self.program))
        harness, made = self.path / "harness.o", self.path / "image"
        self.compiler.compile(source, harness, "O1", HARNESS)
        roots = [batch_symbol(i) for i in range(len(self.program.functions))]
        objects = [self.own, harness]
        if selftest:
            roots.append(self.names.selftest)
            objects.append(self.selftest())
        if program is not None:
            main = self.path / "main.o"
            self.compiler.compile(self.write("main.c", program[1]), main, "O1", HARNESS)
            roots.insert(0, program[0])
            objects.append(main)
        self.compiler.link(objects, self.path / "layout.ld", made, roots, (LEFT,))
        return made

    def selftest(self) -> Path:
        """The self-test, compiled."""
        made = self.path / "selftest.o"
        if not made.exists():
            self.compiler.compile(self.path / self.names.selftest_source, made, self.option, OWN)
        return made

    def probed(self) -> Binary:
        """All functions with arguments for them (``harness.print_probe``)."""
        source = self.write("probe.c", print_probe(self.program))
        probe, made = self.path / "probe.o", self.path / "probe.elf"
        self.compiler.compile(source, probe, "O1", HARNESS)
        functions = [self.names.functions[f.name].function for f in self.program.functions]
        pointers = [pointer_symbol(i) for i in range(len(functions))]
        self.compiler.link([self.own, probe], self.path / "layout.ld", made, [*functions, *pointers])
        return read_elf(made)

    def close(self) -> None:
        """Remove the folder."""
        self._folder.cleanup()

    def __enter__(self) -> Image:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _script(flash: int, ram: int) -> str:
    """A linker script that keeps own code, harness and library apart, so that each can be sized and counted."""
    return f"""SECTIONS
{{
    . = {flash:#x};
    .own : {{ *own.o({_CODE}) }}
    .harness : {{ *harness.o({_CODE}) }}
    .library : {{ *({_CODE} .trampolines .trampolines.*) }}
    . = {ram:#x};
    .got : {{ *(.got .got.*) }}
    .own_ram : {{ *own.o({_DATA}) }}
    .ram : {{ *({_DATA}) }}
    /DISCARD/ : {{ *(.ARM.exidx .ARM.exidx.* .ARM.extab .ARM.extab.* .eh_frame .comment .note.*) }}
}}
"""
