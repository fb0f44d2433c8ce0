"""Runs functions on an emulated ATmega328P: ``simavr``'s program.

The cases lie in the device's flash and the results come over its serial port, so many cases are many runs of an image
that is linked once.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterator, Mapping

import numpy as np
import numpy.typing as npt

from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.machines.avr_harness import print_avr_batch, print_avr_selftest, print_cases
from fuzzyspec.machines.elf import patched, read_elf
from fuzzyspec.machines.image import EmulationError, Image
from fuzzyspec.machines.stream import case_size, decode, encode, result_size
from fuzzyspec.native.layout import Result, layout_of

SIMAVR = "apt install simavr"
_FLASH = 32_768 - 512
"""Bytes of flash without the interrupt vectors and the start-up code."""
_MOST_CASES = 20_000
"""Bytes of cases in one image: no object may be larger than 32 KB."""
_RECORDS = 1_024
"""Bytes of RAM, of 2 KB, that lists may take."""
_LINKED = ("-Os", "-Wl,--gc-sections")


class DoesNotFit(Exception):
    """What is to be run is too large for the device."""


def simavr_is_here() -> bool:
    """Whether the emulator is installed."""
    return shutil.which("simavr") is not None


class AvrFeed:
    """One function's image with room for cases. ``text`` is the C of a program that reads them (``avr_harness``)."""

    def __init__(self, image: Image, function: str, text: str) -> None:
        """Link. Raises BuildError, and DoesNotFit where the function or one of its cases is too large."""
        layout = layout_of(image.program, image.program.function(function), image.names)
        source, harness = image.write("harness.c", text), image.path / "harness.o"
        image.compiler.compile(source, harness, "O2", ("-std=gnu99",))
        taken = image.sizes(function).flash + sum(section.size for section in read_elf(harness).sections)
        room, size = min(_MOST_CASES, _FLASH - taken), case_size(layout)
        if size > _RECORDS:
            raise DoesNotFit(f"a case of {size} bytes does not fit its RAM")
        if room < size:
            raise DoesNotFit(f"{taken} bytes of code and tables leave its flash no room")
        index = [f.name for f in image.program.functions].index(function)
        self._image, self._case, self._made = image, max(1, size), image.path / f"feed-{index}.elf"
        self._room = room
        cases = image.write("cases.c", print_cases(room))
        image.compiler.toolchain.build([cases, image.own, harness], self._made, _LINKED)
        self._linked = self._made.read_bytes()

    def lines(self, cases: npt.NDArray[np.uint8], seconds: float) -> Iterator[list[str]]:
        """What the image prints, a list for each run: as many cases at once as there is room for."""
        chunk = self._room // self._case
        for at in range(0, len(cases), chunk):
            part = cases[at : at + chunk]
            data = {"fuzzyc_n": len(part).to_bytes(2, "little"), "fuzzyc_cases": part.tobytes()}
            self._made.write_bytes(patched(self._linked, data))
            yield run_simavr(self._image, self._made.name, seconds)


def run_simavr(image: Image, name: str, seconds: float) -> list[str]:
    """The lines that a program in the image's folder prints until it sleeps. Raises EmulationError where none ends."""
    if not simavr_is_here():
        raise MissingTool("simavr is needed to run what was built for avr", f"get it: {SIMAVR}")
    try:
        done = subprocess.run(
            ["simavr", "-m", "atmega328p", "-f", "16000000", name],
            cwd=image.path,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,  # the image's lines are on one or the other, by the version
            text=True,
            errors="replace",
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired as late:
        said = late.stdout.decode(errors="replace") if isinstance(late.stdout, bytes) else ""
        raise EmulationError(f"no end after {seconds:g} s", len(_bare_lines(said)), late=True) from late
    lines = _bare_lines(done.stdout)
    if not lines or not lines[-1].startswith("S"):
        raise EmulationError(f"simavr ended early: {done.stdout[-300:]!r}", len(lines))
    return lines


class AvrEmulation:
    """An image on the emulated device, as ``emulate.Emulation``. Every function is linked when it is first run."""

    def __init__(self, image: Image, seconds: float) -> None:
        """Raises MissingTool where simavr is not installed, BuildError."""
        if not simavr_is_here():
            raise MissingTool("simavr is needed to run what was built for avr", f"get it: {SIMAVR}")
        self.image = image
        image.selftest()  # what the compiler rejects is told now; what does not fit, when it is linked
        self._seconds = seconds
        self._feeds: dict[str, AvrFeed] = {}

    def run(
        self, function: str, inputs: Mapping[str, npt.ArrayLike], state: Mapping[str, npt.ArrayLike] | None = None
    ) -> Result:
        """As ``emulate.Emulation.run``; DoesNotFit where the device is too small."""
        layout = layout_of(self.image.program, self.image.program.function(function), self.image.names)
        if function not in self._feeds:
            self._feeds[function] = AvrFeed(self.image, function, print_avr_batch(self.image.program, function))
        cases = encode(layout, inputs, state)
        results: list[bytes] = []
        try:
            for lines in self._feeds[function].lines(cases, self._seconds):
                results += (bytes.fromhex(line) for line in lines[:-1])
        except EmulationError as error:
            raise EmulationError(f"{function}: {error}", len(results) + error.case, late=error.late) from error
        if len(results) != len(cases) or any(len(r) != result_size(layout) for r in results):
            raise EmulationError(f"{function}: simavr returned {len(results)} results for {len(cases)} cases")
        return decode(layout, b"".join(results), len(cases))

    def selftest(self) -> int:
        """What the self-test returns."""
        image = self.image
        source, main = image.write("main.c", print_avr_selftest(image.program)), image.path / "main.o"
        image.compiler.compile(source, main, "O2", ("-std=gnu99",))
        objects = [image.own, image.selftest(), main]
        taken = sum(section.size for made in objects for section in read_elf(made).sections)
        if taken > _FLASH:
            raise DoesNotFit(f"{taken} bytes of golden vectors and code do not fit its flash")
        image.compiler.toolchain.build(objects, image.path / "selftest.elf", _LINKED)
        return int.from_bytes(bytes.fromhex(run_simavr(image, "selftest.elf", self._seconds)[0]), "little")


def _bare_lines(said: str) -> list[str]:
    """What the image printed, without simavr's colours, its dot for the line's end, and its own lines."""
    plain = re.sub("\x1b\\[[0-9;]*m", "", said)
    lines = (line.strip().rstrip(".").strip() for line in plain.splitlines())
    return [line for line in lines if line and set(line) <= set("0123456789abcdefS ")]
