"""Budgets, held against what was measured."""

from __future__ import annotations

import json
from dataclasses import fields, replace
from pathlib import Path

import pytest

from fuzzyspec.cli.main import main
from fuzzyspec.cost import Record, Verdict, confirm
from fuzzyspec.cost.budgets import as_lines
from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.model.budget import QUANTITIES, Budget, Machine, Quantity
from tests.cost.cost_specs import PLAIN, compiler_for

NOWHERE = Span(0, 0)
MEASURED = {
    "target": "cortex-m0plus",
    "option": "O2",
    "function": "fan",
    "instructions_mean": 80.5,
    "instructions_max": 100,
    "cycles_mean": 95.5,
    "cycles_max": 120,
    "flash": 500,
    "ram": 0,
    "stack": 48,
}
M0 = Record(**dict.fromkeys((f.name for f in fields(Record)), None) | MEASURED)
AVR = replace(M0, target="avr", instructions_mean=None, instructions_max=None, cycles_mean=400.0, cycles_max=450)
SMALL = replace(M0, option="Os", flash=400, instructions_max=150)
FIGURES: dict[Quantity, int] = {"flash": 500, "ram": 0, "stack": 48, "instructions": 100, "cycles": 120}


def limit(quantity: Quantity, most: int, target: Machine | None = None) -> Budget:
    """A limit from nowhere in particular."""
    return Budget(quantity, most, target, NOWHERE)


def verdicts(*limits: Budget, records: tuple[Record, ...] = (M0, SMALL, AVR)) -> tuple[Verdict, ...]:
    """What comes of limits of ``fan``, rv32imc having no compiler."""
    return confirm({"fan": limits}, records, "O2", {"rv32imc": "get one"})


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_the_limit_itself_is_allowed_and_no_more(quantity: Quantity) -> None:
    """Each quantity is held against its own figure, never against a mean."""
    figure = FIGURES[quantity]
    (met,) = verdicts(limit(quantity, figure, "cortex-m0plus"))
    (missed,) = verdicts(limit(quantity, figure - 1, "cortex-m0plus"))
    assert (met.measured, met.met) == (figure, True)
    assert (missed.measured, missed.met) == (figure, False)


def test_without_a_target_every_measured_one_is_judged() -> None:
    """And one without a compiler is told of; targets that nobody asked for are not."""
    found = verdicts(limit("flash", 450))
    assert [(v.target, v.met, v.why) for v in found] == [
        ("cortex-m0plus", False, ""),
        ("rv32imc", None, "get one"),
        ("avr", False, ""),
    ]
    assert [v.target for v in verdicts(limit("cycles", 450))] == ["cortex-m0plus", "avr"]
    assert verdicts(limit("flash", 450, "cortex-m7")) == ()


def test_another_build_that_meets_a_limit_is_named() -> None:
    """One build is judged; that the other would do is the way out."""
    flash, instructions = verdicts(limit("flash", 450, "cortex-m0plus"), limit("instructions", 99, "cortex-m0plus"))
    assert (flash.met, flash.instead) == (False, "Os")
    assert (instructions.met, instructions.instead) == (False, "")
    lines = "\n".join(as_lines((flash, instructions)))
    assert "budget of fan, held against the -O2 build" in lines
    assert "500 B  MISSED by 50 B; met by -Os" in lines
    assert "100  MISSED by 1 (largest seen)" in lines


def test_what_no_emulator_ran_is_neither_met_nor_missed() -> None:
    """Sizes are there without one, the rest is not."""
    blind = replace(AVR, cycles_mean=None, cycles_max=None, stack=None, matches=None)
    flash, cycles = verdicts(limit("flash", 500, "avr"), limit("cycles", 1, "avr"), records=(blind,))
    assert (flash.met, cycles.met, cycles.measured) == (True, None, None)
    assert "emulator" in cycles.why


def test_what_is_derived_goes_before_what_was_seen() -> None:
    """A limit on time holds for every call, so the worst case that was derived is held against it, tried or not."""
    derived = replace(M0, instructions_worst=130, cycles_worst=170)
    limits = limit("instructions", 110, "cortex-m0plus"), limit("cycles", 170, "cortex-m0plus")
    instructions, cycles = verdicts(*limits, records=(derived,))
    assert (instructions.measured, instructions.basis, instructions.met) == (130, "derived", False)
    assert (cycles.measured, cycles.basis, cycles.met) == (170, "derived", True)
    assert "130  MISSED by 20 (derived; 100 is the largest seen)" in "\n".join(as_lines((instructions,)))


@pytest.fixture
def budgeted(tmp_path: Path) -> str:
    """A spec with a limit that holds and one that cannot."""
    path = tmp_path / "plain.fz"
    both = "    budget { flash <= 60 KiB, cycles <= 2 on cortex-m0plus, stack <= 60 kB on avr }\n}\n"
    path.write_text(PLAIN.removesuffix("}\n") + both, encoding="utf-8")
    return str(path)


def test_a_missed_budget_ends_with_1(budgeted: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The other limits are told as met; those on targets that were not asked for are not told."""
    compiler_for("cortex-m0plus")
    command = ["cost", budgeted, "--target", "cortex-m0plus", "--inputs", "20"]
    assert main(command) == 1
    out = capsys.readouterr().out
    assert "flash <= 60 KiB" in out and "MISSED by" in out and "avr" not in out
    assert main([*command, "--optimize", "size", "--format", "json"]) == 1
    data = json.loads(capsys.readouterr().out)
    assert data["ok"] is False
    flash, cycles = data["budgets"]
    (small,) = [r for r in data["records"] if r["option"] == "Os"]
    assert (flash["option"], flash["measured"], flash["met"]) == ("Os", small["flash"], True)
    assert cycles == {
        "function": "fan",
        "quantity": "cycles",
        "limit": 2,
        "target": "cortex-m0plus",
        "option": "Os",
        "measured": small["cycles_max"] if small["cycles_worst"] is None else small["cycles_worst"],
        "basis": "largest seen" if small["cycles_worst"] is None else "derived",
        "largest_seen": small["cycles_max"],
        "met": False,
        "why": "",
    }


def test_the_build_that_was_made_is_judged(budgeted: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Where only one option is measured there is no other to judge."""
    compiler_for("cortex-m4")
    options = ["--target", "cortex-m4", "--inputs", "20", "--opt", "Os", "--format", "json"]
    assert main(["cost", budgeted, *options]) == 0
    data = json.loads(capsys.readouterr().out)
    assert [(b["option"], b["met"]) for b in data["budgets"]] == [("Os", True)]
