"""The printed C on a machine whose ``int`` has 16 bits, and the C that is compiled for such a machine."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from fuzzyspec import load
from fuzzyspec.cost.avr import measure_avr
from fuzzyspec.estimate.inputs import draw_cases
from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Const, Define, Function, Local, Port, Program, ReadPort, SetOutput
from fuzzyspec.fixed.run import run
from fuzzyspec.lower import Options
from fuzzyspec.machines.image import Image
from fuzzyspec.machines.toolchains import TARGETS, find_compiler
from fuzzyspec.native import NativeModule
from tests.conftest import required_tool
from tests.emit.emit_random import scalar_program
from tests.emit.test_emit_c import BUILDS, WIDTHS, cases, compiles, plan_of
from tests.random_specs.generator import spec

ROOT = Path(__file__).resolve().parents[2]
SPECS = sorted((*ROOT.glob("examples/*.fz"), *ROOT.glob("benchmarks/*.fz")))
REGISTERS = """module clash

controller c {
    input  SP, e in [0, 4] { partition NEAR FAR }
    output PORTB in [0, 1] { partition LOW HIGH }
    table PORTB by SP, e {
              NEAR FAR
        NEAR: HIGH LOW
        FAR:  LOW  LOW
    }
}

system s {
    input ADC in [0, 4]
    input RTC[3] { TCNT1 in [0, 1] }
    let x = c(SP: max(i.TCNT1 for i in RTC, otherwise 0), e: ADC)
    output DDRB = x.PORTB
}
"""


@pytest.mark.parametrize("widths", WIDTHS)
@pytest.mark.parametrize("seed", range(200, 203))
def test_random_programs_agree_where_int_has_16_bits(seed: int, widths: Callable[[Program], Program]) -> None:
    """On an emulated ATmega328P the C's integers are the model's, bit for bit."""
    required_tool("avr-gcc")
    required_tool("simavr")
    program = widths(scalar_program(seed, count=12))
    inputs = cases(program.functions[0], 150)
    wanted = run(program, "mixed", inputs)
    with Image(program, plan_of(program).files, find_compiler(TARGETS["avr"]), "Os") as image:
        timed = measure_avr(image, "mixed", inputs, None)
    assert timed is not None
    for name, column in wanted.outputs.items():
        np.testing.assert_array_equal(timed.result.outputs[name], column, err_msg=name)
    np.testing.assert_array_equal(timed.result.status, wanted.status)


@pytest.mark.parametrize("path", SPECS, ids=lambda p: p.stem)
def test_what_is_compiled_for_avr_is_clean_and_equal_everywhere(path: Path, tmp_path: Path) -> None:
    """Narrow C has no warning from any compiler that is here, and computes on the host what the program says."""
    loaded, options = load(path), Options(target="avr", optimize="speed")
    plan = loaded.compile(options)
    for name, command in BUILDS.items():
        if shutil.which(command[0]) is not None and "-m32" not in command:
            (tmp_path / name).mkdir()
            compiles(plan, command, tmp_path / name)
    program = loaded.lower(options).program
    with NativeModule(program, plan.files) as native:
        assert native.selftest() == 0


@pytest.mark.gate
@pytest.mark.parametrize("seed", range(900, 904))
def test_random_specs_for_avr_are_clean_and_equal(seed: int, tmp_path: Path) -> None:
    """Controllers and systems of every kind, narrow: no compiler has a warning, and the host computes the program."""
    path = tmp_path / "random.fz"
    path.write_text(spec(seed))
    options = Options(target="avr", optimize="speed")
    program, plan = load(path).lower(options).program, load(path).compile(options)
    for name in ("gcc", "clang", "avr-gcc"):
        if shutil.which(BUILDS[name][0]) is not None:
            compiles(plan, BUILDS[name], tmp_path)
    with NativeModule(program, plan.files) as native:
        for function in program.functions:
            inputs, state = draw_cases(program, function, 300)
            wanted, got = (runs(function.name, inputs, state) for runs in (partial(run, program), native.run))
            for name, column in wanted.outputs.items():
                np.testing.assert_array_equal(got.outputs[name], column, err_msg=name)
            np.testing.assert_array_equal(got.status, wanted.status)


def test_a_choice_of_constants_goes_where_it_is_wanted(tmp_path: Path) -> None:
    """gcc makes a comparison of ``x < 3 ? 0 : 1``: stored in 8 bits, compared and added, it says no word."""
    x = Local("x", "uint8", 0, 255)
    chosen = build.select(build.compare("<", x, Const(3)), Const(0), Const(1))
    bit = build.local("bit", chosen)
    body = (
        Define(x, ReadPort("x", "uint8", 0, 255), True),
        Define(bit, chosen, True),
        SetOutput("sum", build.add(x, chosen)),
        SetOutput("bit", build.add(bit, build.select(build.compare("<", x, chosen), Const(2), Const(5)))),
    )
    ports = Port("sum", "uint16", 0, 256, None), Port("bit", "uint8", 0, 6, None)
    inputs = (Port("x", "uint8", 0, 255, None),)
    function = Function("choose", "controller", inputs, ports, (), (), (), (), (), body)
    for program in (Program("p", (function,)), Program("p", (function,), narrow=True)):
        for command in BUILDS.values():
            if shutil.which(command[0]) is not None and "-m32" not in command:
                compiles(plan_of(program), command, tmp_path)
        given = {"x": np.arange(256)}
        wanted = run(program, "choose", given)
        with NativeModule(program, plan_of(program).files) as native:
            got = native.run("choose", given)
        for name, column in wanted.outputs.items():
            np.testing.assert_array_equal(got.outputs[name], column, err_msg=name)


def test_names_of_registers_do_not_meet_their_macros(tmp_path: Path) -> None:
    """Inputs called as registers are: every file compiles where <avr/io.h> is read before it."""
    path = tmp_path / "clash.fz"
    path.write_text(REGISTERS)
    plan = load(path).compile()
    assert "uint16_t SP_;" in plan.files["clash.h"].decode()
    assert "CLASH_C_SP_MAX" in plan.files["clash.h"].decode()
    compiles(plan, BUILDS["gcc"], tmp_path)
    required_tool("avr-gcc")
    compiles(plan, (*BUILDS["avr-gcc"], "-include", "avr/io.h"), tmp_path)
