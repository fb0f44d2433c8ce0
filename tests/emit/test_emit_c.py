"""The printed C computes what the integer model computes, under strict flags and sanitizers."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from emit_random import list_program, scalar_program

from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.emit import Plan, emit
from fuzzyspec.emit.ctypes import LIMITS
from fuzzyspec.fixed.certificate import Certificate
from fuzzyspec.fixed.program import Function, ListPort, Program
from fuzzyspec.fixed.run import run
from fuzzyspec.model.system import Module
from fuzzyspec.native import Death, NativeModule, NativeProcess

STRICT = [
    *("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wsign-conversion", "-Wshadow", "-Werror", "-Wundef"),
    *("-Wdouble-promotion", "-Wcast-qual", "-Wcast-align", "-Wwrite-strings"),
    *("-Wstrict-prototypes", "-Wmissing-prototypes"),
]
C99 = ("-std=c99", *STRICT)
CPLUSPLUS = ("-x", "c++", *(f for f in STRICT if not f.endswith("-prototypes")))
BUILDS = {
    "gcc": ("gcc", *C99, "-O2"),
    "gcc, 32 bits": ("gcc", "-m32", *C99, "-O2"),
    "clang": ("clang", *C99, "-O2"),
    "g++": ("g++", *CPLUSPLUS),
    "clang++": ("clang++", *CPLUSPLUS, "-Wno-deprecated"),
    # Random programs compare x + 3 with x, of which this old gcc says that it relies on int32_t not overflowing.
    "avr-gcc": ("avr-gcc", "-mmcu=atmega328p", *C99, "-Wno-strict-overflow", "-Os"),
}


@dataclass(frozen=True)
class Bare:
    """A program without certificates."""

    program: Program
    certificates: dict[str, Certificate] = field(default_factory=dict)


def plan_of(program: Program) -> Plan:
    """The files of a program that has no spec."""
    return emit(Module(program.name, (), ()), Bare(program), Source("by_hand.fz", ""))


def compiles(plan: Plan, command: tuple[str, ...], folder: Path) -> None:
    """Fail with the compiler's words where it says anything."""
    for name, content in plan.files.items():
        (folder / name).write_bytes(content)
    for name in plan.files:
        if name.endswith(".c"):
            line = [*command, "-c", name, "-o", "x.o"]
            done = subprocess.run(line, cwd=folder, capture_output=True, text=True, check=False)
            assert done.returncode == 0 and not done.stderr, done.stderr


def cases(function: Function, count: int) -> dict[str, np.ndarray]:
    """The ends of each type, zero and its neighbours, and random raws in between."""
    draw = np.random.default_rng(7)
    found: dict[str, np.ndarray] = {}

    def column(ctype: str, shape: tuple[int, ...]) -> np.ndarray:
        low, high = LIMITS[ctype]
        small = draw.integers(max(low, -300), min(high, 300) + 1, shape)
        wide = draw.integers(low, high + 1, shape)
        edge = draw.choice(np.array([low, low + 1, 0, 1, high - 1, high]), shape)
        return np.choose(draw.integers(0, 3, shape), [small, wide, edge])

    for port in function.inputs:
        if isinstance(port, ListPort):
            found[f"{port.name}.count"] = draw.integers(0, min(port.capacity + 3, 256), count)
            for inner in port.fields:
                found[f"{port.name}.{inner.name}"] = column(inner.ctype, (count, port.capacity))
        else:
            found[port.name] = column(port.ctype, (count,))
    return found


@pytest.mark.parametrize("seed", range(6))
def test_random_programs_agree_with_the_integer_model(seed: int) -> None:
    """Trees over every node, within 32 bits, come out bit for bit as in the model; so does the self-test."""
    program = scalar_program(seed)
    inputs = cases(program.functions[0], 4000)
    wanted = run(program, "mixed", inputs)
    with NativeModule(program, plan_of(program).files) as native:
        got = native.run("mixed", inputs)
        assert native.selftest() == 0
    for name, column in wanted.outputs.items():
        np.testing.assert_array_equal(got.outputs[name], column, err_msg=name)
    np.testing.assert_array_equal(got.status, wanted.status)


@pytest.mark.parametrize("seed", range(2))
def test_random_programs_hold_no_undefined_behaviour(seed: int) -> None:
    """The address and undefined-behaviour sanitizers find nothing at any of the cases."""
    program = scalar_program(100 + seed)
    inputs = cases(program.functions[0], 2000)
    with NativeProcess(program, plan_of(program).files, sanitize=True) as native:
        got = native.run("mixed", inputs)
    assert not isinstance(got, Death), got
    np.testing.assert_array_equal(got.status, run(program, "mixed", inputs).status)


@pytest.mark.parametrize("capacity", [1, 3, 32, 254, 255])
def test_lists_are_read_to_their_bound(capacity: int) -> None:
    """Counts from 0 past the capacity give the model's outputs and overrun bits; 255 cannot be overrun."""
    program = list_program(capacity)
    inputs = cases(program.functions[0], 1500)
    wanted = run(program, "lists", inputs)
    with NativeModule(program, plan_of(program).files) as native:
        got = native.run("lists", inputs)
        assert native.selftest() == 0
    np.testing.assert_array_equal(got.status, wanted.status)
    assert (got.status.max() == 1) == (capacity < 255)
    for name, column in wanted.outputs.items():
        np.testing.assert_array_equal(got.outputs[name], column)


@pytest.mark.parametrize("build", BUILDS)
@pytest.mark.parametrize("program", [scalar_program(3), list_program(5)], ids=["scalars", "lists"])
def test_no_compiler_says_a_word(build: str, program: Program, tmp_path: Path) -> None:
    """C99 and C++, int of 16 and of 32 bits: clean under every warning that we promise, and some more."""
    command = BUILDS[build]
    if shutil.which(command[0]) is None or not _links(command, tmp_path):
        pytest.skip(f"{build} is not installed")
    compiles(plan_of(program), command, tmp_path)


def _links(command: tuple[str, ...], folder: Path) -> bool:
    """Whether the compiler finds its own headers (a 32-bit gcc often does not)."""
    (folder / "probe.c").write_text("#include <stdint.h>\n")
    line = [*command, "-c", "probe.c", "-o", "x.o"]
    return subprocess.run(line, cwd=folder, capture_output=True, check=False).returncode == 0
