"""The printed C computes what the integer model computes, under strict flags and sanitizers."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest

from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.emit import Plan, emit
from fuzzyspec.fixed.build import LIMITS
from fuzzyspec.fixed.certificate import Certificate
from fuzzyspec.fixed.program import Function, ListPort, Program
from fuzzyspec.fixed.run import run
from fuzzyspec.lower.widths import fit_widths
from fuzzyspec.model.system import Module
from fuzzyspec.native import Death, NativeModule, NativeProcess
from tests.conftest import required_tool, without
from tests.emit.emit_holding import HOLDING
from tests.emit.emit_random import list_program, scalar_program

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


def words(program: Program) -> Program:
    """The program as it is, its locals of any type."""
    return program


def narrow(program: Program) -> Program:
    """In the narrowest arithmetic, its locals of any type."""
    return replace(program, narrow=True)


def fitted(program: Program) -> Program:
    """In the narrowest arithmetic, its locals as narrow as they can be."""
    return replace(program, narrow=True, functions=tuple(fit_widths(f, "narrow") for f in program.functions))


WIDTHS: list[Callable[[Program], Program]] = [words, narrow, fitted]


@pytest.mark.parametrize("widths", WIDTHS)
@pytest.mark.parametrize("seed", range(4))
def test_random_programs_agree_with_the_integer_model(seed: int, widths: Callable[[Program], Program]) -> None:
    """Trees over every node, within 32 bits, come out bit for bit as in the model; so does the self-test."""
    program = widths(scalar_program(seed))
    inputs = cases(program.functions[0], 4000)
    wanted = run(program, "mixed", inputs)
    with NativeModule(program, plan_of(program).files) as native:
        got = native.run("mixed", inputs)
        assert native.selftest() == 0
    for name, column in wanted.outputs.items():
        np.testing.assert_array_equal(got.outputs[name], column, err_msg=name)
    np.testing.assert_array_equal(got.status, wanted.status)


@pytest.mark.parametrize("widths", WIDTHS)
def test_random_programs_hold_no_undefined_behaviour(widths: Callable[[Program], Program]) -> None:
    """The address and undefined-behaviour sanitizers find nothing at any of the cases."""
    program = widths(scalar_program(100))
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


def test_state_passes_through_calls() -> None:
    """A nested state is read, kept and handed on as in the model, and the caller repeats the callee's bit."""
    inputs = cases(HOLDING.function("main"), 500)
    state = {"new.duty": np.arange(500) % 201, "other.duty": np.arange(500) // 3}
    wanted = run(HOLDING, "main", inputs, state)
    with NativeModule(HOLDING, plan_of(HOLDING).files) as native:
        got = native.run("main", inputs, state)
        first = native.run("main", {"a": [-32768]})
        assert native.selftest() == 0
    np.testing.assert_array_equal(got.outputs["total"], wanted.outputs["total"])
    np.testing.assert_array_equal(got.status, wanted.status)
    for key, column in wanted.state.items():
        np.testing.assert_array_equal(got.state[key], column)
    assert set(got.status) == {0, 1}
    assert first.outputs["total"][0] == 9 + 5


def test_names_that_c_keeps_are_moved_aside() -> None:
    """A controller called step, an input called class and a call called in get names that compile."""
    plan = plan_of(HOLDING)
    header = plan.files["hold.h"].decode()
    assert "hold_status_t hold_step(hold_state_t *state, const hold_input_t *in, hold_output_t *out);" in header
    assert "hold_step_(hold_step_state_t *state," in header
    assert "int16_t class_;" in header


def test_only_what_is_used_is_printed() -> None:
    """Locals that only records read are pruned, kernels that nothing calls are left out."""
    source = plan_of(HOLDING).files["hold.c"].decode()
    assert "idle" not in source
    assert "hold_quotient" not in source and "hold_mul_high" not in source
    assert "hold_quotient" in plan_of(scalar_program(0)).files["rnd.c"].decode().replace("rnd_", "hold_")


@pytest.mark.parametrize("change", ["table", "comparison", "constant"])
def test_the_selftest_finds_an_edit(change: str) -> None:
    """An entry, a comparison or a constant changed in the C makes the self-test name a vector."""
    files = dict(plan_of(HOLDING).files)
    old, new = {
        "table": (b"77, 100", b"78, 100"),
        "comparison": (b"value >= 0", b"value > 0"),
        "constant": (b"32768", b"40000"),
    }[change]
    assert old in files["hold.c"]
    files["hold.c"] = files["hold.c"].replace(old, new)
    with NativeModule(HOLDING, files) as native:
        assert 1 <= native.selftest() <= 64


@pytest.mark.parametrize("build", BUILDS)
@pytest.mark.parametrize("widths", WIDTHS)
@pytest.mark.parametrize("program", [scalar_program(3), list_program(5), HOLDING], ids=["scalars", "lists", "holding"])
def test_no_compiler_says_a_word(
    build: str, program: Program, widths: Callable[[Program], Program], tmp_path: Path
) -> None:
    """C99 and C++, int of 16 and of 32 bits: clean under every warning that we promise, and some more."""
    command = BUILDS[build]
    required_tool(command[0])
    if not _links(command, tmp_path):
        without(f"{build} has no headers")
    compiles(plan_of(widths(program)), command, tmp_path)


def _links(command: tuple[str, ...], folder: Path) -> bool:
    """Whether the compiler finds its own headers (a 32-bit gcc often does not)."""
    (folder / "probe.c").write_text("#include <stdint.h>\n")
    line = [*command, "-c", "probe.c", "-o", "x.o"]
    return subprocess.run(line, cwd=folder, capture_output=True, check=False).returncode == 0
