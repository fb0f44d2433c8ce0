"""Widths: what the machine's registers decide about the C types of locals."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import pytest

from fuzzyspec import load
from fuzzyspec.fixed.build import LIMITS
from fuzzyspec.fixed.program import AssignElement, Define, DefineArray, Element, Local, Loop, Stmt
from fuzzyspec.fixed.prune import expressions, nodes, statements
from fuzzyspec.lower.module import Options, lower
from fuzzyspec.lower.strategy import Goal, Target

ROOT = Path(__file__).resolve().parents[2]
SPECS = sorted((*ROOT.glob("examples/*.fz"), *ROOT.glob("benchmarks/*.fz")))


def locals_of(body: tuple[Stmt, ...]) -> list[Local]:
    """The locals that statements declare, those of inner blocks left out, those of loops not."""
    found = [s.local for s in body if isinstance(s, Define)]
    return found + [s.counter for s in body if isinstance(s, Loop)]


@pytest.mark.gate
@pytest.mark.parametrize("target", ["generic", "cortex-m0plus", "cortex-m4", "rv32imc"])
def test_words_on_machines_of_32_bits(target: Target) -> None:
    """Every local fills a register, so that nothing is cut to a narrower type on the way."""
    for path in SPECS:
        for function in lower(load(path).module, Options(target=target)).program.functions:
            assert {local.ctype for local in locals_of(function.body)} <= {"uint32", "int32"}


@pytest.mark.gate
def test_the_narrowest_types_on_a_machine_of_8_bits() -> None:
    """Every local has the smallest type that holds its interval."""
    found = [
        local
        for path in SPECS
        for goal in get_args(Goal)
        for function in lower(load(path).module, Options(optimize=goal, target="avr")).program.functions
        for local in locals_of(function.body)
    ]
    for local in found:
        low, high = LIMITS[local.ctype]
        assert low <= local.lo and local.hi <= high
    assert {"uint8", "int8", "uint16", "uint32"} <= {local.ctype for local in found}


@pytest.mark.parametrize(("target", "ctype"), [("cortex-m0plus", "uint32"), ("avr", "uint16")])
def test_pairs_of_degrees_are_words_where_registers_are(target: Target, ctype: str) -> None:
    """The arrays of two degrees of W3's loops are words on 32 bits, wherever they are declared, set or read."""
    (function,) = lower(
        load(ROOT / "benchmarks" / "w3.fz").module, Options(optimize="size", target=target)
    ).program.functions
    every = list(statements(function.body))
    pairs = {s.name: s.ctype for s in every if isinstance(s, DefineArray) and s.size == 2}
    assert set(pairs.values()) == {ctype}
    assert {s.ctype for s in every if isinstance(s, AssignElement) and s.array in pairs} == {ctype}
    read = [n for e in expressions(function.body) for n in nodes(e) if isinstance(n, Element) and n.array in pairs]
    assert {n.ctype for n in read} == {ctype}
