"""The printed C on a machine whose ``int`` has 16 bits, and the C that is compiled for such a machine."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fuzzyspec import load
from fuzzyspec.cost.avr import measure_avr, simavr_is_here
from fuzzyspec.cost.image import Image
from fuzzyspec.cost.toolchains import TARGETS, find_compiler
from fuzzyspec.fixed.program import Program
from fuzzyspec.fixed.run import run
from fuzzyspec.lower import Options
from fuzzyspec.native import NativeModule
from tests.emit.emit_random import scalar_program
from tests.emit.test_emit_c import BUILDS, WIDTHS, cases, compiles, plan_of

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
    if shutil.which("avr-gcc") is None or not simavr_is_here():
        pytest.skip("avr-gcc and simavr are not installed")
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
    spec, options = load(path), Options(target="avr", optimize="speed")
    plan = spec.compile(options)
    for name, command in BUILDS.items():
        if shutil.which(command[0]) is not None and "-m32" not in command:
            (tmp_path / name).mkdir()
            compiles(plan, command, tmp_path / name)
    program = spec.lower(options).program
    with NativeModule(program, plan.files) as native:
        assert native.selftest() == 0


def test_names_of_registers_do_not_meet_their_macros(tmp_path: Path) -> None:
    """Inputs called as registers are: every file compiles where <avr/io.h> is read before it."""
    path = tmp_path / "clash.fz"
    path.write_text(REGISTERS)
    plan = load(path).compile()
    assert "uint16_t SP_;" in plan.files["clash.h"].decode()
    assert "CLASH_C_SP_MAX" in plan.files["clash.h"].decode()
    compiles(plan, BUILDS["gcc"], tmp_path)
    if shutil.which("avr-gcc") is None:
        pytest.skip("avr-gcc is not installed")
    compiles(plan, (*BUILDS["avr-gcc"], "-include", "avr/io.h"), tmp_path)
