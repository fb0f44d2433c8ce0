"""Budgets as they arrive in the model."""

from __future__ import annotations

import json

import pytest

from fuzzyspec import load
from fuzzyspec.check import check
from fuzzyspec.check.report import module_report
from fuzzyspec.cli.cost import TARGETS as OFFERED
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source
from fuzzyspec.model.budget import MACHINES, TOLD_ON, Budget, words
from fuzzyspec.model.system import Module
from fuzzyspec.syntax import parse
from tests.syntax.specs import FIXTURES

SPEC = """\
module m
controller c {
    input  e in [-1, 1] { partition N Z P }
    output u in [0, 1]  { partition LOW MID HIGH }
    table u by e { N: LOW  Z: MID  P: HIGH }
    budget { %s }
}
"""


def checked(text: str) -> tuple[Module | None, tuple[Diagnostic, ...]]:
    """The model of a text and all that was found."""
    source = Source("m.fz", text)
    tree, torn = parse(source)
    module, found = check(tree, source, torn)
    return module, (*torn, *found)


def budgets(limits: str) -> tuple[Budget, ...]:
    """The budgets of a controller with these limits, which are sound."""
    module, found = checked(SPEC % limits)
    assert found == () and module is not None
    return module.controllers[0].budgets


def told(limits: str) -> list[tuple[str, str | None]]:
    """Codes and help of what is wrong with limits."""
    return [(d.code, d.help) for d in checked(SPEC % limits)[1]]


def test_all_forms_arrive() -> None:
    """Blocks join, units and params are worked out, bytes are whole: what is over a limit is at least one byte over."""
    text = (FIXTURES / "ok_budget.fz").read_text(encoding="utf-8")
    module, found = checked(text)
    assert found == () and module is not None
    drive, pump = module.controllers[0], module.systems[0]
    assert [words(b) for b in drive.budgets] == [
        "flash <= 2 KiB",
        "flash <= 1,500 B on cortex-m0plus",
        "ram <= 0 B",
        "instructions <= 900 on rv32imc",
        "cycles <= 4,000 on avr",
        "cycles <= 9,000",
    ]
    assert [(b.quantity, b.limit, b.target) for b in pump.budgets] == [("stack", 64, None), ("ram", 0, None)]
    assert [text[b.span.start : b.span.end] for b in pump.budgets] == ["stack <= 8 * depth / 2 * 1 B", "ram <= 0"]
    assert budgets("flash <= 1.9 B")[0].limit == 1


@pytest.mark.parametrize(
    ("limits", "text"), [("flash <= 3 KiB", "flash <= 3 KiB"), ("stack <= 1 kB", "stack <= 1,000 B")]
)
def test_what_is_said_of_a_limit_can_be_written(limits: str, text: str) -> None:
    """A limit in words is a limit again, but for the commas that part its thousands."""
    (budget,) = budgets(limits)
    assert words(budget) == text
    assert budgets(text.replace(",", ""))[0].limit == budget.limit


def test_a_limit_without_a_target_holds_where_it_can_be_told() -> None:
    """Cycles have no honest figure on the larger cores, instructions none on AVR."""
    flash, cycles, one = budgets("flash <= 1 KiB, cycles <= 900, cycles <= 800 on avr")
    assert flash.machines == MACHINES
    assert cycles.machines == ("cortex-m0plus", "avr")
    assert one.machines == ("avr",)
    assert set(TOLD_ON["instructions"]) | {"avr"} == set(MACHINES)


def test_the_machines_are_those_that_are_measured() -> None:
    """A budget can name each target of ``fuzzyc cost``, and no other."""
    assert MACHINES == OFFERED


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("cortex-m0", "cortex-m0plus"),
        ("cortex-m0+", "cortex-m0plus"),
        ("m4", "cortex-m4"),
        ("Cortex-M7", "cortex-m7"),
        ("cortex_m7", "cortex-m7"),
        ("cortexm4", "cortex-m4"),
        ("atmega328p", "avr"),
        ("riscv32", "rv32imc"),
    ],
)
def test_other_names_of_machines_lead_to_ours(name: str, meant: str) -> None:
    """What vendors and habits call a core is guessed."""
    assert told(f"flash <= 1 KiB on {name}") == [("FZ261", f"did you mean `{meant}`?")]


@pytest.mark.parametrize(
    ("name", "meant"), [("FLASH", "flash"), ("rom", "flash"), ("cycle", "cycles"), ("instrs", "instructions")]
)
def test_other_names_of_quantities_lead_to_ours(name: str, meant: str) -> None:
    """So is what they call a quantity."""
    assert told(f"{name} <= 1") == [("FZ260", f"did you mean `{meant}`?")]


def test_everything_wrong_with_a_limit_is_told() -> None:
    """Quantity, sign and target are looked at each for itself; the other limits stand."""
    assert [code for code, _ in told("rom < 1 KiB on m3, flash <= 5 m, cycles <= 7 kB")] == [
        "FZ260",
        "FZ265",
        "FZ261",
        "FZ262",
        "FZ262",
    ]


def test_memory_units_stay_in_budgets() -> None:
    """Outside of a budget `B` and `KiB` are free names for units of one's own."""
    text = (
        (SPEC % "flash <= 1 KiB").replace("module m\n", "module m\nunit KiB = 3 m\n").replace("[-1, 1]", "[-1, 1] KiB")
    )
    module, found = checked(text)
    assert found == () and module is not None
    assert module.controllers[0].budgets[0].limit == 1024
    assert [d.code for d in checked(text.replace("unit KiB = 3 m\n", ""))[1]] == ["FZ204"]


def test_the_words_of_a_budget_are_names_elsewhere() -> None:
    """Inputs, terms, lets and outputs may be called `budget`, `on` and `flash`."""
    text = """\
        module on
        controller budget {
            input  budget, on in [0, 1] { partition on off budget }
            output flash  in [0, 1] { partition budget full_on full }
            rules { if budget is on and on is budget then flash is full_on  if budget is not on then flash is budget
                    if on is not budget then flash is full_on }
            fires at 1/100
            budget { flash <= 1 KiB on avr }
        }
        system flash {
            input on in [0, 1]
            let cycles = budget(budget: on, on: 0)
            let budget = cycles.flash
            output flash = budget
            budget { ram <= 0 }
        }
    """
    module, found = checked(text)
    assert found == () and module is not None
    assert [words(b) for b in (*module.controllers[0].budgets, *module.systems[0].budgets)] == [
        "flash <= 1 KiB on avr",
        "ram <= 0 B",
    ]


def test_the_report_lists_budgets() -> None:
    """``check`` shows them, in words and as data."""
    module, _ = checked((FIXTURES / "ok_budget.fz").read_text(encoding="utf-8"))
    assert module is not None
    report = module_report(module)
    assert "  budget     stack <= 64 B\n             ram <= 0 B" in report.text()
    system = json.loads(json.dumps(report.as_json()))["systems"][0]
    assert system["budgets"][0] == {"quantity": "stack", "limit": 64, "target": None}
    nothing = module_report(checked(SPEC.replace("    budget { %s }\n", ""))[0] or module)
    assert "budget" not in nothing.text()


def test_the_header_states_budgets() -> None:
    """In the comment of the function that has them."""
    spec = load((FIXTURES / "ok_budget.fz").read_text(encoding="utf-8"))
    header = spec.compile().files["pump.h"].decode()
    *_, before = header.split("pump_status_t pump_step(")[0].split("/*")
    assert " * budget: stack <= 64 B; ram <= 0 B\n" in before
