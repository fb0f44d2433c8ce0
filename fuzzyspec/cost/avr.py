"""Runs one function on an emulated ATmega328P: ``simavr``'s program, which counts every cycle.

The image prints what it computed and what its timers read; the cases lie in its flash, so many cases are many images.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fuzzyspec.machines.elf import read_elf
from fuzzyspec.machines.emulate import EmulationError
from fuzzyspec.machines.harness import print_avr_harness
from fuzzyspec.machines.image import Image
from fuzzyspec.machines.stream import case_size, decode, encode, result_size
from fuzzyspec.native.layout import Result, layout_of

Ints = npt.NDArray[np.int64]

_FLASH = 32_768 - 512
"""Bytes of flash without the interrupt vectors and the start-up code."""
_MOST_CASES = 20_000
"""Bytes of cases in one image: no object may be larger than 32 KB."""
_RECORDS = 1_024
"""Bytes of RAM, of 2 KB, that lists may take."""
_RETURN = 4
"""Cycles of RET: what the empty function takes."""
_SECONDS = 300


@dataclass(frozen=True, slots=True)
class AvrCalls:
    """N measured calls. ``cycles``: (N,), from the function's first instruction to its return.

    ``stack``: the deepest that any call wrote, its return address included.
    """

    result: Result
    cycles: Ints
    stack: int


def simavr_is_here() -> bool:
    """Whether the emulator is installed."""
    return shutil.which("simavr") is not None


def measure_avr(
    image: Image,
    function: str,
    inputs: Mapping[str, npt.ArrayLike],
    state: Mapping[str, npt.ArrayLike] | None,
    *,
    long_calls: bool = False,
) -> AvrCalls | None:
    """N calls of the function named as in the spec; None where it does not fit the device together with its inputs.

    With ``long_calls`` they may take more than half a million cycles (``harness.print_avr_harness``).
    Raises BuildError, EmulationError.
    """
    layout = layout_of(image.program, image.program.function(function), image.names)
    source = image.write("harness.c", print_avr_harness(image.program, function, long_calls=long_calls))
    harness = image.path / "harness.o"
    image.compiler.compile(source, harness, "O2", ("-std=gnu99",))
    taken = image.sizes(function).flash + sum(section.size for section in read_elf(harness).sections)
    room = min(_MOST_CASES, _FLASH - taken)
    if room < case_size(layout) or case_size(layout) > _RECORDS:
        return None
    cases = encode(layout, inputs, state)
    chunk = room // max(1, case_size(layout))
    results, cycles, stack = [], [], 0
    for at in range(0, len(cases), chunk):
        part = cases[at : at + chunk]
        lines = _run(image, part)
        empty = _cycles(lines[0]) - _RETURN
        for line in lines[1:-1]:
            words = line.split()
            results.append(bytes.fromhex(words[0]))
            cycles.append(_cycles(words[1]) - empty)
        stack = max(stack, int.from_bytes(bytes.fromhex(lines[-1][1:]), "little"))
    if len(results) != len(cases) or any(len(r) != result_size(layout) for r in results):
        raise EmulationError(f"{function}: simavr returned {len(results)} results for {len(cases)} cases")
    return AvrCalls(decode(layout, b"".join(results), len(cases)), np.array(cycles, dtype=np.int64), stack)


def _run(image: Image, cases: npt.NDArray[np.uint8]) -> list[str]:
    """The lines that an image with these cases prints."""
    numbers = ",".join(str(b) for b in cases.tobytes()) or "0"
    text = f"#include <avr/pgmspace.h>\n#include <stdint.h>\nconst uint16_t fuzzyc_n = {len(cases)};\n"
    source = image.write("cases.c", f"{text}const uint8_t fuzzyc_cases[] PROGMEM = {{{numbers}}};\n")
    made = image.path / "image.elf"
    image.compiler.toolchain.build([source, image.own, image.path / "harness.o"], made, ("-Os", "-Wl,--gc-sections"))
    command = ["simavr", "-m", "atmega328p", "-f", "16000000", made.name]
    try:
        done = subprocess.run(
            command,
            cwd=image.path,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,  # the image's lines are on one or the other, by the version
            text=True,
            errors="replace",
            timeout=_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise EmulationError(f"simavr came to no end in {_SECONDS} s") from error
    lines = [line for line in map(_bare, done.stdout.splitlines()) if line]
    if len(lines) < 2 or not lines[-1].startswith("S"):
        raise EmulationError(f"simavr ended early: {done.stdout[-300:]!r}")
    return lines


def _bare(line: str) -> str:
    """What the image printed, without simavr's colours and its dot for the line's end; empty for simavr's own lines."""
    for colour in ("\x1b[32m", "\x1b[31m", "\x1b[0m"):
        line = line.replace(colour, "")
    line = line.strip().rstrip(".")
    return line.strip() if set(line) <= set("0123456789abcdefS ") else ""


def _cycles(times: str) -> int:
    """From the two timers: the fine one's difference, modulo 2^16, nearest to what the coarse one says."""
    read = bytes.fromhex(times)
    fine = (int.from_bytes(read[2:4], "little") - int.from_bytes(read[0:2], "little")) % 65536
    coarse = (read[4] + 256 * read[5]) * 1024
    return fine + 65536 * max(0, round((coarse - fine) / 65536))
