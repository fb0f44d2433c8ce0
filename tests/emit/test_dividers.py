"""The C of every kernel that divides: the same integer, and no intermediate that wraps around."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.emit import Plan, emit
from fuzzyspec.fixed import build
from fuzzyspec.fixed.build import UINT32_MAX
from fuzzyspec.fixed.certificate import Certificate
from fuzzyspec.fixed.program import Const, Define, Division, Function, Local, Port, Program, ReadPort, SetOutput
from fuzzyspec.fixed.run import run
from fuzzyspec.model.system import Module
from fuzzyspec.native import NativeModule
from tests.conftest import required_tool

INTERVALS = (
    *((0, 2**bits - 1) for bits in (8, 16, 17, 20, 22, 23, 24, 25, 27, 28, 31)),
    *((0, 2**bits) for bits in (1, 17, 23, 24, 27)),
    *((2**20, 2**23), (2**20, 2**23 - 1), (1_000_000, 7_000_000), (2**21, 2**24 - 1), (2**18, 2**23 - 1)),
    *((2**12, 2**24 - 512), (2**21, 2**24), (2**24, 2**27), (2**16, 2**19)),
    *((2**24, 2**27 - 1), (1000, 2**26), (5, 60_000)),
)


class Bare:
    """A program without certificates."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.certificates: dict[str, Certificate] = {}


def dividing(division: Division) -> Program:
    """A function for every interval of the divisor: what lies outside is taken to its ends."""
    functions = []
    for index, (lo, hi) in enumerate(INTERVALS):
        num, den = (Local(name, "uint32", 0, UINT32_MAX) for name in ("num", "den"))
        low = Local("low", "uint32", lo, UINT32_MAX)
        held = Local("held", "uint32", lo, hi)
        body = (
            *(Define(local, ReadPort(local.name, "uint32", 0, UINT32_MAX), True) for local in (num, den)),
            Define(low, build.greatest(den, Const(lo)), True),
            Define(held, build.least(low, Const(hi)), True),
            SetOutput("ratio", build.quotient(num, held, division)),
        )
        ports = tuple(Port(name, "uint32", 0, UINT32_MAX, None) for name in ("num", "den"))
        outputs = (Port("ratio", "uint32", 0, 65536, None),)
        functions.append(Function(f"over_{index}", "controller", ports, outputs, (), (), (), (), (), body))
    return Program("divide", tuple(functions))


def files(program: Program) -> Plan:
    """Its C."""
    return emit(Module(program.name, (), ()), Bare(program), Source("by_hand.fz", ""))


def pairs(lo: int, hi: int) -> tuple[np.ndarray, np.ndarray]:
    """Divisors at the ends of the interval, at every power of two, at the cells of the table, and of every size
    between; numerators at both ends, around the divisor, and around many exact quotients."""
    draw = np.random.default_rng(hi - lo)
    sizes = np.exp2(draw.uniform(np.log2(max(lo, 1)), np.log2(hi), 4000)).astype(np.int64)
    cells = [(cell << shift) + d for cell in range(16, 129) for shift in range(0, 24, 3) for d in (-1, 0, 1)]
    powers = [2**k + d for k in range(32) for d in (-1, 0, 1)]
    den = np.clip(np.concatenate([sizes, cells, powers, [0, 1, lo, lo + 1, hi - 1, hi]]), lo, hi)
    den = np.repeat(den, 12)
    exact = draw.integers(0, 65537, den.size) * den // 65536
    some = draw.integers(0, 12, den.size)
    num = np.select(
        [some == k for k in range(9)],
        [exact, exact + 1, exact - 1, den, den - 1, den + 1, np.zeros_like(den), np.ones_like(den), den // 2],
        draw.integers(0, np.maximum(den, 1)),
    )
    return np.clip(num, 0, UINT32_MAX), den


def floor(num: np.ndarray, den: np.ndarray) -> np.ndarray:
    """What the kernel promises."""
    return np.where(num < den, num * 65536 // np.maximum(den, 1), 65536)


@pytest.mark.parametrize("division", get_args(Division))
def test_every_divider_gives_the_same_integer(division: Division) -> None:
    """The C over intervals of every size, known from below or not, 0 among them: the quotient's floor, or 65536."""
    program = dividing(division)
    with NativeModule(program, files(program).files) as native:
        for function, (lo, hi) in zip(program.functions, INTERVALS, strict=True):
            num, den = pairs(lo, hi)
            inputs = {"num": num, "den": den}
            got = native.run(function.name, inputs).outputs["ratio"]
            np.testing.assert_array_equal(got, floor(num, den), err_msg=f"{lo} .. {hi}")
            np.testing.assert_array_equal(run(program, function.name, inputs, checked=True).outputs["ratio"], got)
        assert native.selftest() == 0


@pytest.mark.gate
@pytest.mark.parametrize("division", get_args(Division))
def test_no_divider_wraps_around(division: Division, tmp_path: Path) -> None:
    """Clang's check of unsigned arithmetic finds no intermediate outside of 32 bits at any of the pairs."""
    required_tool("clang")
    program = dividing(division)
    for name, content in files(program).files.items():
        (tmp_path / name).write_bytes(content)
    calls = []
    for index, (lo, hi) in enumerate(INTERVALS):
        num, den = (column[::5] for column in pairs(lo, hi))
        calls.append(
            f"    {{ divide_over_{index}_input_t in; divide_over_{index}_output_t out; uint32_t i;\n"
            f"      for (i = 0; i < {len(num)}; ++i) {{ in.num = num_{index}[i]; in.den = den_{index}[i];\n"
            f"        divide_over_{index}(&in, &out); }} }}\n"
        )
        for name, values in (("num", num), ("den", den)):
            text = ",".join(f"{v}U" for v in values.tolist())
            (tmp_path / f"{name}_{index}.h").write_text(f"static const uint32_t {name}_{index}[] = {{{text}}};\n")
    includes = "".join(f'#include "{n}_{k}.h"\n' for k in range(len(INTERVALS)) for n in ("num", "den"))
    main = f'#include "divide.h"\n{includes}int main(void)\n{{\n{"".join(calls)}    return 0;\n}}\n'
    (tmp_path / "main.c").write_text(main)
    checks = "-fsanitize=undefined,unsigned-integer-overflow,unsigned-shift-base"
    command = ["clang", "-O1", checks, "-fsanitize-trap=all", "main.c", "divide.c", "-o", "main"]
    built = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    done = subprocess.run([str(tmp_path / "main")], capture_output=True, text=True, check=False)
    assert done.returncode == 0
