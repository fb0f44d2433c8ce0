"""Real builds, run in emulators: the figures of C whose cost is known, and outputs that are compared."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzyspec import load
from fuzzyspec.cost import Conditions, Emulation, EmulationError, Image, Record, measure
from fuzzyspec.fixed.run import run
from fuzzyspec.machines.toolchains import Kind
from tests.cost.cost_specs import KEEPING, PLAIN, compiler_for, stand_in

BUILDS: list[tuple[str, Kind | None]] = [
    ("cortex-m0plus", "gcc"),
    ("cortex-m0plus", "zig"),
    ("cortex-m4", "gcc"),
    ("cortex-m7", "gcc"),
    ("rv32imc", "gcc"),
    ("rv32imc", "zig"),
    ("avr", None),
]


def record_of(target: str, body: str, kind: Kind | None = None, inputs: int = 3) -> Record:
    """The cost of a stand-in for PLAIN's controller."""
    conditions = Conditions((compiler_for(target, kind),), ("O2",), inputs)
    (record,) = measure(load(PLAIN).lowered.program, lambda *_: stand_in(body), conditions).records
    return record


@pytest.mark.parametrize(("target", "kind"), BUILDS)
def test_lists_states_and_nested_calls_come_out_as_the_integer_program_says(target: str, kind: Kind | None) -> None:
    """A system with a list and a state, on every target: bit for bit, no static RAM, and a stack."""
    spec = load(KEEPING)
    conditions = Conditions((compiler_for(target, kind),), ("Os",), 100)
    measured = measure(spec.lowered.program, lambda *_: spec.compile().files, conditions)
    assert measured.mismatches == ()
    assert [(r.target, r.option, r.function) for r in measured.records] == [
        (target, "Os", "hold"),
        (target, "Os", "both"),
    ]
    for record in measured.records:
        assert record.matches is True
        assert record.ram == 0
        assert record.stack is not None
        counted = record.cycles_mean if target == "avr" else record.instructions_mean
        assert counted is not None
        assert counted > 20
    inner, outer = measured.records
    assert outer.flash > inner.flash


@pytest.mark.parametrize("target", ["cortex-m0plus", "cortex-m4", "rv32imc"])
def test_a_hundred_more_instructions_are_counted_as_a_hundred(target: str) -> None:
    """Straight code: the difference of two builds is what was added, and each case costs the same."""
    few = record_of(target, "out->z = in->x; return 0U;")
    more = record_of(target, '__asm__ volatile (".rept 100\\n nop\\n .endr"); out->z = in->x; return 0U;')
    assert few.instructions_mean is not None
    assert more.instructions_mean == more.instructions_max == few.instructions_mean + 100
    if target == "cortex-m0plus":
        assert few.cycles_mean is not None
        assert more.cycles_mean == few.cycles_mean + 100
    else:
        assert more.cycles_mean is None


def test_instructions_whose_condition_fails_are_counted() -> None:
    """On a Cortex-M4 they are fetched and take their cycle: inside an IT block too."""
    body = '__asm__ volatile ("cmp %0, %0\\n itt ne\\n addne r3, #1\\n addne r3, #1" : : "r"(in) : "r3", "cc");'
    few = record_of("cortex-m4", "out->z = in->x; return 0U;", "gcc")
    more = record_of("cortex-m4", f"{body} out->z = in->x; return 0U;", "gcc")
    assert few.instructions_mean is not None
    assert more.instructions_mean == few.instructions_mean + 4


def test_a_taken_branch_takes_the_core_one_cycle_more() -> None:
    """A loop of 10: on a Cortex-M0+, 10 subtractions, 9 branches taken (2 cycles) and one not (1)."""
    loop = '__asm__ volatile (".syntax unified\\n movs r3, #10\\n 1: subs r3, #1\\n bne 1b" : : : "r3", "cc");'
    few = record_of("cortex-m0plus", "out->z = in->x; return 0U;", "gcc")
    more = record_of("cortex-m0plus", f"{loop} out->z = in->x; return 0U;", "gcc")
    assert few.instructions_mean is not None
    assert few.cycles_mean is not None
    assert more.instructions_mean == few.instructions_mean + 21
    assert more.cycles_mean == few.cycles_mean + 1 + 10 + 9 * 2 + 1


@pytest.mark.parametrize("rounds", [1, 1000, 65535])
def test_cycles_of_avr_are_exact_over_more_than_one_turn_of_its_timer(rounds: int) -> None:
    """``sbiw; brne`` takes 4 cycles a round, 3 the last; the loads 2. 65,535 rounds turn the timer 4 times."""
    loop = (
        f'__asm__ volatile ("ldi r26, {rounds & 255}\\n ldi r27, {rounds >> 8}\\n 1: sbiw r26, 1\\n brne 1b"'
        ' : : : "r26", "r27");'
    )
    few = record_of("avr", '__asm__ volatile ("" : : : "r26", "r27"); out->z = in->x; return 0U;')
    more = record_of("avr", f"{loop} out->z = in->x; return 0U;")
    assert few.cycles_mean is not None
    assert more.cycles_mean == few.cycles_mean + 2 + 4 * rounds - 1


@pytest.mark.parametrize("target", ["cortex-m0plus", "rv32imc"])
def test_stack_that_is_reserved_counts_although_nothing_is_written_there(target: str) -> None:
    """400 bytes of which one is written."""
    body = "volatile uint8_t room[400]; room[399] = 1U; if (room[399] == 1U) { out->z = in->x; } return 0U;"
    record = record_of(target, body, "gcc")
    assert record.stack is not None
    assert 400 <= record.stack <= 416


def test_sizes_tell_tables_library_and_static_ram() -> None:
    """A table is flash, a counter is RAM, and a Cortex-M0+ divides by calling its library."""
    plain = record_of("cortex-m0plus", "out->z = in->x; return 0U;", "gcc")
    table = "static const uint16_t t[50] = { 1U, 2U, 3U }; @ out->z = t[in->x % 32U]; return 0U;"
    more = record_of("cortex-m0plus", table, "gcc")
    assert 100 <= more.flash - plain.flash < 140
    assert (more.ram, more.flash_own) == (0, more.flash)
    divided = record_of("cortex-m0plus", "out->z = (uint16_t)(40000U / (in->x + 1U)); return 0U;", "gcc")
    assert divided.flash > divided.flash_own + 100
    counting = record_of("cortex-m0plus", "static uint32_t n; @ ++n; out->z = (uint16_t)n; return 0U;", "gcc")
    assert counting.ram == 4


@pytest.mark.parametrize("target", ["cortex-m0plus", "avr"])
def test_a_wrong_output_is_reported_with_its_inputs(target: str) -> None:
    """C that computes something else does not pass: the first case that differs is named."""
    program = load(PLAIN).lowered.program
    conditions = Conditions((compiler_for(target),), ("O2",), 20)
    measured = measure(program, lambda *_: stand_in("out->z = 7U; return 0U;"), conditions)
    (mismatch,) = measured.mismatches
    assert measured.records[0].matches is False
    assert (mismatch.target, mismatch.what, mismatch.got) == (target, "output z", 7)
    inputs = {k: np.array([v]) for k, v in mismatch.inputs.items()}
    assert run(program, "fan", inputs).outputs["z"].tolist() == [mismatch.wanted]


def test_a_fault_names_the_function() -> None:
    """C that reads from nowhere ends the measurement, not the process."""
    with pytest.raises(EmulationError, match="fan"):
        record_of("cortex-m0plus", "out->z = *(const uint16_t *)16U; return 0U;")


def test_writing_to_a_table_is_a_fault() -> None:
    """What is const lies in flash, which the emulation keeps from being written."""
    with pytest.raises(EmulationError):
        record_of(
            "cortex-m0plus",
            "static const uint16_t t[2] = { 1U, 2U }; @ *(volatile uint16_t *)(uintptr_t)&t[in->x & 1U] = 5U;"
            " out->z = t[in->y & 1]; return 0U;",
        )


def test_the_emulation_runs_raws_of_the_callers_choice() -> None:
    """What ``verify`` will want: any raws, legal or not, any number of cases, no counting."""
    spec = load(PLAIN)
    program = spec.lowered.program
    rng = np.random.default_rng(1)
    inputs = {"x": rng.integers(0, 65536, 70_000), "y": rng.integers(-32768, 32768, 70_000)}
    with Image(program, spec.compile().files, compiler_for("cortex-m0plus"), "O2") as image:
        result = Emulation(image).run("fan", inputs)
    wanted = run(program, "fan", inputs)
    assert np.array_equal(result.outputs["z"], wanted.outputs["z"])
    assert np.array_equal(result.status, wanted.status)
