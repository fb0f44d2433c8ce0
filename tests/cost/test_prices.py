"""The prices of the counted limit, against the sequences that docs/limit.md lists and against compilers."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Mapping
from pathlib import Path

import pytest

from fuzzyspec.cost.prices import CORES, STEPS, price
from tests.conftest import required_tool

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "limit.md").read_text(encoding="utf-8")
ASSEMBLERS: Mapping[str, tuple[str, ...]] = {
    "cortex-m0plus": ("arm-none-eabi-gcc", "-mthumb", "-mcpu=cortex-m0plus"),
    "cortex-m4": ("arm-none-eabi-gcc", "-mthumb", "-mcpu=cortex-m4"),
    "rv32imc": ("riscv64-unknown-elf-gcc", "-march=rv32imc", "-mabi=ilp32"),
    "avr": ("avr-gcc", "-mmcu=atmega328p"),
}
AVR_CYCLES = {
    "mul": 2,
    "ld": 2,
    "ldd": 2,
    "st": 2,
    "lpm": 3,
    "push": 2,
    "pop": 2,
    "rjmp": 2,
    "ijmp": 2,
    "ret": 4,
    "brsh": 1.5,
    "brlo": 1.5,
}
"""AVR Instruction Set Manual, AVRe+; a branch is taken as often as not; all others that are used take 1."""


def sequences(core: str) -> str:
    """The listing of a core's steps."""
    (found,) = re.findall(rf"^```asm {core}\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    return str(found)


def counted(core: str) -> dict[str, float]:
    """What each step's lines take."""
    found: dict[str, float] = {}
    step, times = "", 1
    for line in sequences(core).splitlines():
        words = line.split("/*")[0].split()
        match words:
            case []:
                continue
            case [".rept", count]:
                times = int(count)
            case [".endr"]:
                times = 1
            case [label] if label.endswith(":"):
                step = label.removesuffix(":")
                found[step] = 0
            case [mnemonic, *_]:
                cycles = AVR_CYCLES.get(mnemonic, 1) if core == "avr" else 1
                found[step] += times * cycles * (0.5 if "half" in line else 1)
    return found


@pytest.mark.parametrize("core", CORES)
def test_a_price_is_the_length_of_its_sequence(core: str) -> None:
    """Every step of every core, none left out on either side."""
    assert counted(core) == {step: price(step, core) for step in STEPS}


@pytest.mark.parametrize("core", CORES)
def test_the_sequences_are_instructions_of_their_core(core: str, tmp_path: Path) -> None:
    """GNU's assembler takes every line for that very CPU; branches lead to where the step ends."""
    command = ASSEMBLERS[core]
    required_tool(command[0])
    syntax = ".syntax unified\n" if core.startswith("cortex") else ""
    listed = re.sub(r"^(?=\w+:)", "1:\n", sequences(core), flags=re.MULTILINE)
    (tmp_path / "steps.s").write_text(f"{syntax}{listed}1:\n", encoding="utf-8")
    done = subprocess.run(
        [*command, "-c", "-o", str(tmp_path / "steps.o"), str(tmp_path / "steps.s")],
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr


KERNELS = """\
typedef __UINT32_TYPE__ u32;
u32 line(u32 u) { return (u * 43691U + 36865U) >> 16; }
u32 multiply(u32 s, u32 c) { return (s * c) >> 15; }
u32 cube(u32 s, u32 c) { return ((s >> 6) * c) >> 15; }
u32 scaled_sum(u32 a, u32 h) { return a + (h << 1); }
u32 quadratic(u32 a, u32 c) { return a + (40001U - ((21111U * c) >> 16)) * c; }
u32 cubic(u32 m, u32 c) { return m + (40001U - (((30001U - ((10111U * c) >> 16)) * c) >> 16)) * c; }
u32 moment(u32 m, u32 a) { return m + 40001U * a; }
u32 lerp(u32 p, u32 q, u32 d, u32 e) { return (p * d + q * e) >> 15; }
"""
QUOTIENT = "u32 quotient(u32 num, u32 den) { return ((num << 8) / den << 8) + (((num << 8) % den) << 8) / den; }\n"
"""Where the core divides."""


@pytest.mark.parametrize("core", ["cortex-m0plus", "cortex-m4", "rv32imc"])
def test_no_compiler_beats_a_price(core: str, tmp_path: Path) -> None:
    """gcc -O2, its return left out, takes no less than is counted for a step; for most of them just as much."""
    command = ASSEMBLERS[core]
    required_tool(command[0])
    (tmp_path / "steps.c").write_text(KERNELS + ("" if core == "cortex-m0plus" else QUOTIENT), encoding="utf-8")
    built = tmp_path / "steps.o"
    subprocess.run([*command, "-O2", "-c", "-o", str(built), str(tmp_path / "steps.c")], check=True)
    dump = [command[0].replace("-gcc", "-objdump"), "-d", "--no-show-raw-insn", str(built)]
    text = subprocess.run(dump, check=True, capture_output=True, text=True).stdout
    found: dict[str, int] = {}
    for line in text.splitlines():
        if named := re.match(r"[0-9a-f]+ <(\w+)>:", line):
            step = named[1]
            found[step] = 0
        elif (taken := re.match(r"\s+[0-9a-f]+:\s+(\S+)(\s+lr)?", line)) and not (taken[1] in NO_STEP or taken[2]):
            found[step] += 1
    assert all(price(step, core) <= n for step, n in found.items()), found
    assert 2 * sum(price(step, core) == n for step, n in found.items()) > len(found)


NO_STEP = {"ret", ".word", ".short", "nop"}
"""Returns (``bx lr`` too), the literal pool, padding."""
