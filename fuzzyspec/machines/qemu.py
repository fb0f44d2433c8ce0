"""Runs an image in QEMU's user mode: the same code as ``emulate`` runs, in another emulator.

The image is a program that reads cases and writes results by the system calls of Linux, which QEMU serves. It has no
Cortex-M there, so Thumb runs on an Arm core that knows all of its instructions.
"""

from __future__ import annotations

import shutil
import struct
import subprocess
from collections.abc import Iterator, Mapping

import numpy as np
import numpy.typing as npt

from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.fixed.program import Program
from fuzzyspec.machines.harness import batch_symbol
from fuzzyspec.machines.image import EmulationError, Image
from fuzzyspec.machines.stream import case_size, decode, encode, result_size
from fuzzyspec.machines.toolchains import Machine
from fuzzyspec.native.layout import Layout, Result, layout_of

QEMU: Mapping[Machine, tuple[str, ...]] = {
    "thumb": ("qemu-arm", "-cpu", "max"),
    "riscv32": ("qemu-riscv32",),
    "mips": ("qemu-mips",),
}
PACKAGE = "apt install qemu-user"
_PER = 4096
"""Cases that the program reads before it writes their results."""
_SELFTEST = 0xFFFFFFFF
_PROGRAM = "fuzzyc_main"
_LATE = "no end after"

_CALLS: Mapping[Machine, tuple[tuple[int, int, int], str]] = {
    "thumb": (
        (3, 4, 1),
        """\
    register int32_t r0 __asm__("r0") = a;
    register const void *r1 __asm__("r1") = b;
    register uint32_t r2 __asm__("r2") = c;
    __asm__ volatile ("push {r7}\\n mov r7, %1\\n svc #0\\n pop {r7}" : "+r"(r0) : "r"(n), "r"(r1), "r"(r2) : "memory");
    return r0;""",
    ),
    "riscv32": (
        (63, 64, 93),
        """\
    register int32_t a0 __asm__("a0") = a;
    register const void *a1 __asm__("a1") = b;
    register uint32_t a2 __asm__("a2") = c;
    register int32_t a7 __asm__("a7") = n;
    __asm__ volatile ("ecall" : "+r"(a0) : "r"(a1), "r"(a2), "r"(a7) : "memory");
    return a0;""",
    ),
    "mips": (
        (4003, 4004, 4001),
        """\
    register int32_t v0 __asm__("$2") = n;
    register int32_t a0 __asm__("$4") = a;
    register const void *a1 __asm__("$5") = b;
    register uint32_t a2 __asm__("$6") = c;
    register int32_t a3 __asm__("$7");
    __asm__ volatile ("syscall" : "+r"(v0), "=r"(a3) : "r"(a0), "r"(a1), "r"(a2)
        : "memory", "$1", "$3", "$8", "$9", "$10", "$11", "$12", "$13", "$14", "$15", "$24", "$25");
    return a3 != 0 ? -1 : v0;""",
    ),
}
"""Numbers of read, write and exit, and how a system call is made."""


def qemu_is_here(machine: Machine) -> bool:
    """Whether QEMU's user mode for the machine is installed."""
    return machine in QEMU and shutil.which(QEMU[machine][0]) is not None


class QemuEmulation:
    """An image in QEMU, as ``emulate.Emulation``."""

    def __init__(self, image: Image, seconds: float) -> None:
        """Link. Raises MissingTool where QEMU is not installed, BuildError."""
        machine = image.compiler.target.machine
        if not qemu_is_here(machine):
            raise MissingTool(f"{QEMU[machine][0]} is needed to run what was built", f"get it: {PACKAGE}")
        self.image = image
        self._command = QEMU[machine]
        self._seconds = seconds
        text = "\n".join(_print(image.program, image, machine))
        self._made = image.emulated(selftest=True, program=(_PROGRAM, text))

    def run(
        self, function: str, inputs: Mapping[str, npt.ArrayLike], state: Mapping[str, npt.ArrayLike] | None = None
    ) -> Result:
        """As ``emulate.Emulation.run``."""
        layout = layout_of(self.image.program, self.image.program.function(function), self.image.names)
        index = [f.name for f in self.image.program.functions].index(function)
        cases, size = encode(layout, inputs, state), result_size(layout)
        said, death = self._feed(index, cases, _PER)
        if death is not None:
            before = len(said) // size
            one_by_one, again = self._feed(index, cases[before : before + _PER], 1)
            found = again or death
            raise EmulationError(f"{function}: {found}", before + len(one_by_one) // size, late=_LATE in found)
        if len(said) != len(cases) * size:
            raise EmulationError(f"{function}: QEMU gave {len(said)} bytes of {len(cases) * size}")
        return decode(layout, said, len(cases))

    def selftest(self) -> int:
        """What the self-test returns."""
        said, death = self._feed(_SELFTEST, np.zeros((0, 0), dtype=np.uint8), 1)
        if death is not None or len(said) != 2:
            raise EmulationError(death or "the self-test returned nothing")
        return int.from_bytes(said, "little")

    def _feed(self, index: int, cases: npt.NDArray[np.uint8], per: int) -> tuple[bytes, str | None]:
        """What the program wrote, and how it died if it did."""
        try:
            done = subprocess.run(
                [*self._command, self._made],
                input=struct.pack("<III", index, len(cases), per) + cases.tobytes(),
                capture_output=True,
                timeout=self._seconds,
                check=False,
            )
        except subprocess.TimeoutExpired as late:
            return late.stdout or b"", f"{_LATE} {self._seconds:g} s"
        if done.returncode != 0:
            said = done.stderr.decode(errors="replace").strip().splitlines()
            return done.stdout, said[-1] if said else f"ended with exit status {done.returncode}"
        return done.stdout, None


def _print(program: Program, image: Image, machine: Machine) -> Iterator[str]:
    """The program: a header of three words (function, cases, cases at once), the cases in, the results out."""
    (read, write, leave), body = _CALLS[machine]
    layouts: list[Layout] = [layout_of(program, f, image.names) for f in program.functions]
    yield "#include <stdint.h>"
    yield f"static int32_t call(int32_t n, int32_t a, const void *b, uint32_t c)\n{{\n{body}\n}}"
    yield f"static uint8_t cases[{_PER * max(1, *(case_size(x) for x in layouts), 12)}];"
    yield f"static uint8_t results[{_PER * max(1, *(result_size(x) for x in layouts))}];"
    yield f"uint16_t {image.names.selftest}(void);"
    yield from (f"void {batch_symbol(i)}(uint32_t n, const uint8_t *in, uint8_t *out);" for i in range(len(layouts)))
    yield f"void {_PROGRAM}(void);"
    yield "static void leave(int32_t status)\n{\n    for (;;) {"
    yield f"        (void)call({leave}, status, 0, 0);\n    }}\n}}"
    yield "static void take(uint32_t size)\n{\n    uint32_t at = 0;\n    while (at < size) {"
    yield f"        const int32_t got = call({read}, 0, cases + at, size - at);"
    yield "        if (got <= 0) { leave(3); }\n        at += (uint32_t)got;\n    }\n}"
    yield "static void give(uint32_t size)\n{\n    uint32_t at = 0;\n    while (at < size) {"
    yield f"        const int32_t put = call({write}, 1, results + at, size - at);"
    yield "        if (put <= 0) { leave(4); }\n        at += (uint32_t)put;\n    }\n}"
    yield "static uint32_t word(uint32_t at)\n{\n    return (uint32_t)cases[at] | (uint32_t)cases[at + 1] << 8"
    yield "        | (uint32_t)cases[at + 2] << 16 | (uint32_t)cases[at + 3] << 24;\n}"
    yield f"void {_PROGRAM}(void)\n{{\n    uint32_t function, n, per;"
    yield "    take(12);\n    function = word(0);\n    n = word(4);\n    per = word(8);"
    yield f"    if (function == {_SELFTEST:#x}U) {{\n        const uint16_t failed = {image.names.selftest}();"
    yield "        results[0] = (uint8_t)failed;\n        results[1] = (uint8_t)(failed >> 8);\n        give(2);\n    }"
    yield "    while (n != 0) {\n        const uint32_t now = n < per ? n : per;\n        switch (function) {"
    for i, layout in enumerate(layouts):
        yield f"        case {i}:\n            take(now * {case_size(layout)}U);"
        yield f"            {batch_symbol(i)}(now, cases, results);"
        yield f"            give(now * {result_size(layout)}U);\n            break;"
    yield "        default:\n            leave(5);\n        }\n        n -= now;\n    }\n    leave(0);\n}"
    yield ""
