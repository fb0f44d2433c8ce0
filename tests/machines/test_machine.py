"""The generated C and planted faults on every emulated machine, through cross compilers and the ziglang package."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzyspec import load
from fuzzyspec.estimate.inputs import draw_cases
from fuzzyspec.fixed.run import run
from fuzzyspec.machines.image import EmulationError
from fuzzyspec.machines.machine import EmulatedMachine, Emulators, Signals
from fuzzyspec.machines.qemu import QEMU as COMMANDS
from fuzzyspec.machines.toolchains import TARGETS, Kind
from fuzzyspec.native import Death, Result
from tests.conftest import required_tool
from tests.cost.cost_specs import KEEPING, PLAIN, compiler_for, stand_in

BUILDS: list[tuple[str, Kind]] = [
    ("cortex-m0plus", "gcc"),
    ("cortex-m4", "zig"),
    ("rv32imc", "gcc"),
    ("rv32imc", "zig"),
    ("avr", "gcc"),
    ("mips-be", "gcc"),
    ("mips-be", "zig"),
    ("wasm32", "zig"),
]
QEMU: list[tuple[str, Kind]] = [("cortex-m0plus", "gcc"), ("rv32imc", "zig"), ("mips-be", "gcc"), ("mips-be", "zig")]
INPUTS = {"x": np.array([5, 6, 7, 700, 9]), "y": np.zeros(5, dtype=np.int64)}


def plain_on(
    target: str, kind: Kind, body: str, seconds: float = 60.0, emulator: Emulators | None = None
) -> EmulatedMachine:
    """A stand-in for PLAIN's controller on a machine."""
    files = {**stand_in(body), "plain_selftest.c": b"#include <stdint.h>\nuint16_t plain_selftest(void);\n"}
    files["plain_selftest.c"] += b"uint16_t plain_selftest(void) { return 3U; }\n"
    return EmulatedMachine(load(PLAIN).lowered.program, files, compiler_for(target, kind), "O1", seconds, emulator)


@pytest.mark.parametrize(("target", "kind"), BUILDS)
def test_every_machine_computes_the_integer_program(target: str, kind: Kind) -> None:
    """Outputs, status and state of a controller that holds, and of a system with a list, at -O0; the self-test too."""
    spec = load(KEEPING)
    program = spec.lowered.program
    with EmulatedMachine(program, spec.compile().files, compiler_for(target, kind), "O0") as machine:
        assert machine.selftest() == 0
        for function in program.functions:
            inputs, state = draw_cases(program, function, 60)
            got = machine.run(function.name, inputs, state)
            wanted = run(program, function.name, inputs, state)
            assert isinstance(got, Result)
            assert {k: v.tolist() for k, v in got.outputs.items()} == {k: v.tolist() for k, v in wanted.outputs.items()}
            assert got.status.tolist() == wanted.status.tolist()
            assert {k: v.tolist() for k, v in got.state.items()} == {k: v.tolist() for k, v in wanted.state.items()}


@pytest.mark.parametrize(("target", "kind"), BUILDS)
def test_the_selftest_tells_what_it_returned(target: str, kind: Kind) -> None:
    """A self-test that fails says so from every machine."""
    with plain_on(target, kind, "out->z = in->x; return 0U;") as machine:
        assert machine.selftest() == 3


@pytest.mark.parametrize(("target", "kind"), [b for b in BUILDS if b[0] != "avr"])
def test_a_fault_is_a_death_at_its_case(target: str, kind: Kind) -> None:
    """A read from beyond all memory in the fourth case is found there; an AVR has no memory that it may not read."""
    body = "if (in->x == 700U) { out->z = *(const volatile uint16_t *)0x7FFF0000; } else { out->z = 1U; } return 0U;"
    with plain_on(target, kind, body) as machine:
        died = machine.run("fan", INPUTS)
    assert isinstance(died, Death)
    assert died.case == 3


@pytest.mark.parametrize(("target", "kind"), BUILDS)
def test_a_call_that_does_not_return_is_a_death_at_its_case(target: str, kind: Kind) -> None:
    """Within the time limit."""
    body = "volatile uint16_t go = in->x; while (go == 700U) { } out->z = 1U; return 0U;"
    with plain_on(target, kind, body, seconds=1.0) as machine:
        died = machine.run("fan", INPUTS)
    assert isinstance(died, Death)
    assert died.case == 3


@pytest.mark.gate
@pytest.mark.parametrize(("target", "kind"), QEMU)
def test_qemu_runs_the_same_images(target: str, kind: Kind) -> None:
    """Another emulator: the integer program's outcomes, the self-test's verdict, a fault and a hang at their case."""
    required_tool(COMMANDS[TARGETS[target].machine][0])
    spec = load(KEEPING)
    program = spec.lowered.program
    compiler = compiler_for(target, kind)
    with EmulatedMachine(program, spec.compile().files, compiler, "O0", emulator="qemu") as machine:
        assert machine.selftest() == 0
        for function in program.functions:
            inputs, state = draw_cases(program, function, 60)
            got, wanted = machine.run(function.name, inputs, state), run(program, function.name, inputs, state)
            assert isinstance(got, Result)
            assert all(np.array_equal(got.outputs[k], v) for k, v in wanted.outputs.items())
            assert all(np.array_equal(got.state[k], v) for k, v in wanted.state.items())
            assert np.array_equal(got.status, wanted.status)
    fault = "if (in->x == 700U) { out->z = *(const volatile uint16_t *)0x7FFF0000; } else { out->z = 1U; } return 0U;"
    hang = "volatile uint16_t go = in->x; while (go == 700U) { } out->z = 1U; return 0U;"
    for body in (fault, hang):
        with plain_on(target, kind, body, 2.0, "qemu") as machine:
            assert machine.selftest() == 3
            died = machine.run("fan", INPUTS)
        assert isinstance(died, Death)
        assert died.case == 3


def test_what_is_only_late_is_run_again() -> None:
    """A limit that passes between two calls is no hang: all results are there, in their order."""
    with plain_on("cortex-m0plus", "zig", "out->z = in->x; return 0U;") as machine:
        inner = machine._emulator
        told: list[int] = []

        class Slow:
            """Comes to two calls before its time is over."""

            def run(self, function: str, inputs: Signals, state: Signals | None = None) -> Result:
                """The first two, or that it is late."""
                n = len(np.asarray(inputs["x"]))
                told.append(n)
                if n > 2:
                    raise EmulationError("no end after 1 s", 2, late=True)
                return inner.run(function, inputs, state)

            def selftest(self) -> int:
                """As it is."""
                return inner.selftest()

        machine._emulator = Slow()
        got = machine.run("fan", INPUTS)
    assert isinstance(got, Result)
    assert got.outputs["z"].tolist() == INPUTS["x"].tolist()
    assert told == [5, 2, 3, 2, 1]
