"""C that someone else wrote behind the same interface: held against its own meaning, however long it takes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest

from fuzzyspec import load
from fuzzyspec.cost import Conditions, measure
from fuzzyspec.fixed.run import Run, run
from tests.cost.cost_specs import PLAIN, compiler_for, stand_in

Ints = npt.NDArray[np.int64]


@pytest.mark.parametrize("off", [0, 2])
def test_outputs_are_held_against_the_meaning_given(off: int) -> None:
    """Doubling its input, and off by two raws: it passes with a slack of two, and only at zero off without."""
    program = load(PLAIN).lowered.program
    files = stand_in(f"out->z = (uint16_t)(in->x / 2U + {off}U); return 0U;")

    def meaning(function: str, inputs: Mapping[str, Ints], state: object) -> Run:
        return replace(run(program, function, inputs), outputs={"z": np.asarray(inputs["x"]) // 2})

    conditions = Conditions((compiler_for("cortex-m0plus"),), ("O2",), 20)
    strict = measure(program, lambda *_: files, conditions, meaning=meaning)
    loose = measure(program, lambda *_: files, conditions, meaning=meaning, slack=2)
    assert [r.matches for r in strict.records] == [off == 0]
    assert loose.mismatches == ()


@pytest.mark.parametrize("turns", [1, 20])
def test_long_calls_on_avr_are_counted_but_for_the_interrupts(turns: int) -> None:
    """``turns`` loops of 262,141 cycles each: an interrupt takes some 30 in 262,144."""
    loop = (
        f'__asm__ volatile ("ldi r25, {turns}\\n 2: ldi r26, 255\\n ldi r27, 255\\n 1: sbiw r26, 1\\n brne 1b\\n'
        ' dec r25\\n brne 2b" : : : "r25", "r26", "r27");'
    )
    idle = '__asm__ volatile ("" : : : "r25", "r26", "r27");'
    program = load(PLAIN).lowered.program
    conditions = Conditions((compiler_for("avr"),), ("O2",), 3, long_calls=True)
    few, more = (
        measure(program, lambda *_, b=body: stand_in(f"{b} out->z = in->x; return 0U;"), conditions).records[0]
        for body in (idle, loop)
    )
    assert few.cycles_mean is not None
    assert more.cycles_mean is not None
    exact = 1 + turns * (2 + 4 * 65535 - 1 + 3) - 1
    interrupts = exact // 262144 + 1
    assert exact <= more.cycles_mean - few.cycles_mean <= exact + 40 * interrupts
