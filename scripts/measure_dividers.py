"""Measures every kernel that divides, by itself, on every target: writes ``fuzzyspec/estimate/dividers.json``.

What a function takes more for a quotient than for an exclusive or of the same two numbers. A fit over whole programs
cannot tell these apart, since a program has few of them and most programs the same.
"""

from __future__ import annotations

import json
from pathlib import Path

from fuzzyspec.cost import TARGETS, find_compiler
from fuzzyspec.cost.measure import Conditions, Record, measure
from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.emit import emit
from fuzzyspec.fixed import build
from fuzzyspec.fixed.certificate import Certificate
from fuzzyspec.fixed.division import CELLS
from fuzzyspec.fixed.program import Define, Division, Expr, Function, Local, Port, Program, ReadPort, SetOutput
from fuzzyspec.model.system import Module

FOUND = Path(__file__).resolve().parent.parent / "fuzzyspec" / "estimate" / "dividers.json"
ALONE: dict[str, tuple[Division, int, int]] = {
    "loop.1": ("loop", 2**20, 2**23),
    "rounds.1": ("rounds", 2**20, 2**23),
    "unrolled.1": ("unrolled", 2**20, 2**23),
    "newton.8": ("newton", 2**22, 2**23),
    "newton.4": ("newton", 2**26, 2**27),
    "reciprocal.8": ("reciprocal", 2**20, 2**23),
    "reciprocal.4": ("reciprocal", 2**24, 2**27),
    "hardware.16": ("hardware", 2**13, 2**16 - 1),
    "hardware.8": ("hardware", 2**20, 2**24 - 1),
    "hardware.4": ("hardware", 2**24, 2**28 - 1),
}
"""By a kernel's name how it divides and what: divisors that need not be shifted."""
SHIFTED: tuple[Division, int, int] = ("reciprocal", 1, 2**23)
STEPS = 3
"""The same with divisors of which nothing is known, and the shifts that it takes."""


class Bare:
    """A program without certificates."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.certificates: dict[str, Certificate] = {}


def dividing(by: Division, lo: int, hi: int) -> Program:
    """Two functions of the same two numbers."""
    num, den = Local("num", "uint32", 0, hi - 1), Local("den", "uint32", lo, hi)
    ports = (Port("num", "uint32", 0, lo, None), Port("den", "uint32", lo, hi, None))
    reads = tuple(Define(v, ReadPort(v.name, "uint32", v.lo, v.hi), True) for v in (num, den))

    def function(name: str, value: Expr) -> Function:
        outputs = (Port("ratio", "uint32", 0, build.UINT32_MAX, None),)
        return Function(name, "controller", ports, outputs, (), (), (), (), (), (*reads, SetOutput("ratio", value)))

    plain = function("plain", build.bits_xor(num, den))
    return Program("dividing", (plain, function("divided", build.quotient(num, den, by))))


def taken(by: Division, lo: int, hi: int) -> dict[tuple[str, str], dict[str, float]]:
    """By target and option what the quotient adds."""
    program = dividing(by, lo, hi)
    files = emit(Module(program.name, (), ()), Bare(program), Source("by_hand.fz", "")).files
    compilers = tuple(find_compiler(target) for target in TARGETS.values())
    measured = measure(program, lambda target, option: files, Conditions(compilers, inputs=300))
    if measured.mismatches:
        raise SystemExit(f"{by}: {measured.mismatches[0]}")
    records: dict[tuple[str, str], list[Record]] = {}
    for record in measured.records:
        records.setdefault((record.target, record.option), []).append(record)
    table = CELLS if by == "reciprocal" else 0
    found = {}
    for key, (plain, divided) in records.items():
        found[key] = {
            "instructions": (divided.instructions_mean or 0) - (plain.instructions_mean or 0),
            "cycles": (divided.cycles_mean or 0) - (plain.cycles_mean or 0),
            "flash": divided.flash - plain.flash - table,
        }
    return found


def main() -> None:
    """Write what was found, rounded to tenths."""
    every = {name: taken(*how) for name, how in ALONE.items()}
    shifted = taken(*SHIFTED)
    machines: dict[str, dict[str, dict[str, dict[str, float]]]] = {}
    for machine, option in shifted:
        figures = machines.setdefault(machine, {}).setdefault(option, {})
        for figure in ("instructions", "cycles", "flash"):
            stem = "kernel" if figure == "flash" else "quotient"
            base = every["reciprocal.8"][machine, option][figure]
            found = {f"{stem}_{name}": by[machine, option][figure] for name, by in every.items()}
            found[f"{stem}_steps"] = (shifted[machine, option][figure] - base) / STEPS
            if any(found.values()):
                figures[figure] = {name: round(value, 1) for name, value in found.items()}
    note = "Written by scripts/measure_dividers.py: what a quotient adds to a function, by kernel."
    FOUND.write_text(json.dumps({"note": note, "machines": machines}, indent=1, sort_keys=True) + "\n")


if __name__ == "__main__":
    main()
