"""Object files of the generated C hold code and constants, export the header's names, and call next to nothing."""

from __future__ import annotations

import subprocess
from functools import cache
from pathlib import Path

import pytest

from fuzzyspec import load
from fuzzyspec.emit import Plan, write
from fuzzyspec.emit.names import Names, name_module
from fuzzyspec.lower import Options
from fuzzyspec.lower.strategy import Goal, Target
from tests.conftest import required_tool
from tests.emit.emit_objects import Object, read

ROOT = Path(__file__).resolve().parents[2]
BUILDS: dict[str, tuple[tuple[str, ...], frozenset[str]]] = {
    "gcc": (("gcc",), frozenset()),
    "clang": (("clang",), frozenset()),
    "cortex-m0plus": (
        ("arm-none-eabi-gcc", "-mthumb", "-mcpu=cortex-m0plus"),
        frozenset({"__aeabi_uidiv", "__aeabi_idiv", "__aeabi_uidivmod", "__aeabi_idivmod"}),
    ),
    "cortex-m4": (("arm-none-eabi-gcc", "-mthumb", "-mcpu=cortex-m4"), frozenset()),
    "rv32imc": (("riscv64-unknown-elf-gcc", "-march=rv32imc", "-mabi=ilp32"), frozenset()),
    "avr": (
        ("avr-gcc", "-mmcu=atmega328p"),
        frozenset({"__udivmodsi4", "__divmodsi4", "__udivmodhi4", "__mulsi3", "__mulhisi3", "__umulhisi3"})
        | {"__usmulhisi3", "__muluhisi3", "__mulohisi3", "__mulshisi3"},
    ),
    "mips-be": (("mips-linux-gnu-gcc", "-mno-abicalls", "-fno-pic"), frozenset()),
}
"""Compilers, and what of their libraries a function may call: division and products that a machine lacks."""
CASES: tuple[tuple[str, Goal, Target], ...] = (
    ("examples/nav", "balanced", "generic"),
    ("examples/temperature", "balanced", "generic"),
    ("examples/tipper", "balanced", "generic"),
    ("benchmarks/w2", "size", "cortex-m4"),
    ("benchmarks/w3", "speed", "avr"),
    ("benchmarks/w3s", "speed", "cortex-m0plus"),
)


@cache
def compiled(name: str, goal: Goal, target: Target) -> tuple[Plan, Names]:
    """The C of a case, and what its symbols are called."""
    loaded, options = load(ROOT / f"{name}.fz"), Options(optimize=goal, target=target)
    return loaded.compile(options), name_module(loaded.lower(options).program)


def built(source: Path, build: str, level: str) -> Object:
    """The object file of one C file."""
    command, _ = BUILDS[build]
    required_tool(command[0])
    line = [*command, "-std=c99", "-ffreestanding", "-g", level, "-c", source.name, "-o", "x.o"]
    subprocess.run(line, cwd=source.parent, check=True, capture_output=True)
    return read(source.parent / "x.o")


@pytest.mark.parametrize("level", ["-O0", "-O2", "-Os", "-O3"])
@pytest.mark.parametrize("build", BUILDS)
def test_objects_hold_code_and_constants_alone(build: str, level: str, tmp_path: Path) -> None:
    """No byte that is written to, no floating point, no heap, no 64-bit helper, no memcpy; the header's names alone."""
    for name, goal, target in CASES:
        plan, names = compiled(name, goal, target)
        write(plan, tmp_path)
        stateful = {n.init for n in names.functions.values() if n.state}
        for source, exported in (
            (names.source, {n.function for n in names.functions.values()} | stateful),
            (names.selftest_source, {names.selftest}),
        ):
            found = built(tmp_path / source, build, level)
            assert found.exported == exported
            assert found.written == {}
            assert found.floats == 0
            own = {n.function for n in names.functions.values()} | stateful if source != names.source else set()
            assert found.wanted <= BUILDS[build][1] | own


PLANTED = {
    "written": "uint32_t planted(uint32_t x) { static uint32_t last = 3U; last += x; return last; }",
    "bss": "uint32_t planted(uint32_t x) { static uint32_t last; last += x; return last; }",
    "floats": "uint32_t planted(uint32_t x) { float half = 0.5f; return (uint32_t)((float)x * half); }",
    "heap": "void *malloc(uint32_t); uint32_t planted(uint32_t x) { return *(uint32_t *)malloc(x); }",
    "wide": "uint32_t planted(uint32_t x) { return (uint32_t)((((uint64_t)x << 20) / (x | 1U))); }",
    "exported": "uint32_t planted(uint32_t x) { return x; } uint32_t other(uint32_t x) { return x; }",
}


@pytest.mark.parametrize("fault", PLANTED)
def test_planted_faults_show(fault: str, tmp_path: Path) -> None:
    """Data that is written to, floating point, heap, division of 64 bits and a name too many are each seen."""
    source = tmp_path / "planted.c"
    source.write_text(f"#include <stdint.h>\n{PLANTED[fault]}\n")
    found = built(source, "cortex-m0plus", "-O0")
    seen = {
        "written": found.written != {},
        "floats": found.floats > 0,
        "wanted": not found.wanted <= BUILDS["cortex-m0plus"][1],
        "exported": found.exported != {"planted"},
    }
    expected = {"bss": {"written"}, "floats": {"floats", "wanted"}, "heap": {"wanted"}, "wide": {"wanted"}}
    assert {k for k, v in seen.items() if v} == expected.get(fault, {fault})
