"""What is estimated, held against what was measured."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from fuzzyspec import load
from fuzzyspec.estimate import band, estimate
from fuzzyspec.estimate.model import flash, time
from fuzzyspec.estimate.profile import profile
from fuzzyspec.estimate.weights import MACHINES, Figure, Option, weights
from fuzzyspec.fixed import build
from fuzzyspec.fixed.division import kernel_of
from fuzzyspec.fixed.program import Division, Local, Quotient
from fuzzyspec.lower import Options
from fuzzyspec.lower.strategy import Target
from scripts.fit_costs import alive, fit, tell

ROOT = Path(__file__).resolve().parents[2]
OPTIONS: tuple[Option, ...] = get_args(Option)


def test_every_machine_has_weights_for_what_is_measured_on_it() -> None:
    """Flash and stack on all, instructions on all but AVR, cycles on AVR and the Cortex-M0+; errors are in order."""
    for machine in MACHINES:
        for option in OPTIONS:
            found = {f: weights(machine, option, f) for f in get_args(Figure)}
            assert (found["instructions"] is None) == (machine == "avr")
            assert (found["cycles"] is not None) == (machine in ("avr", "cortex-m0plus"))
            for by in found.values():
                if by is not None:
                    assert 0 <= by.median <= by.nine_in_ten <= by.worst
                    assert all(w > 0 for w in by.by.values())


@pytest.mark.parametrize("division", get_args(Division))
def test_everything_that_divides_has_a_weight(division: Division) -> None:
    """In time and in flash, on every machine; nothing can be chosen because nobody measured it."""
    den = [Local("den", "uint32", 1, 2**bits - 1) for bits in (23, 27, 31)]
    quotients = [build.quotient(Local("num", "uint32", 0, 1), d, division) for d in den]
    for kernel in {kernel_of(q) for q in quotients if isinstance(q, Quotient)}:
        for machine in MACHINES:
            for option in OPTIONS:
                for figure in get_args(Figure):
                    by = weights(machine, option, figure)
                    if by is not None and figure != "stack":
                        stem = "kernel" if figure == "flash" else "quotient"
                        assert by.of({f"{stem}_{kernel.by}.{kernel.digit_bits}": 1}) > 0
                        assert by.of({f"{stem}_steps": 1}) > 0


def test_targets_are_those_that_can_be_compiled_for() -> None:
    """A target of the command line has weights, or is generic."""
    assert set(get_args(Target)) == {*MACHINES, "generic"}


def test_a_width_without_a_weight_goes_by_its_kind() -> None:
    """So that a machine to which widths are alike needs one weight for all."""
    by = weights("cortex-m4", "O2", "flash")
    assert by is not None
    stem = next(name for name in by.by if "." not in name and name != "entry")
    assert by.of({f"{stem}.99": 2.0}) == 2 * by.by[stem]
    assert by.of({"unheard_of.8": 5.0}) == 0


def test_the_longest_path_is_no_shorter_than_the_mean() -> None:
    """In instructions and in cycles, on every machine, for every function of nav."""
    program = load(ROOT / "examples" / "nav.fz").lowered.program
    for function in program.functions:
        for machine in MACHINES:
            found = estimate(program, function.name, machine)
            for mean, longest in (
                (found.instructions, found.instructions_max),
                (found.cycles, found.cycles_max),
            ):
                assert (mean is None) == (longest is None)
                assert mean is None or longest is None or 0 < mean <= longest * (1 + 1e-9)


def test_generic_is_the_geometric_mean_of_the_machines() -> None:
    """Of time and of flash; it has no cycles, and the widest band."""
    program = load(ROOT / "benchmarks" / "w2.fz").lowered.program
    found = profile(program, "danger")
    generic = estimate(program, "danger", "generic", "Os")
    logs = [(math.log(time(found, m, "Os")), math.log(flash(found, m, "Os"))) for m in MACHINES]
    assert generic.instructions == pytest.approx(math.exp(sum(t for t, _ in logs) / len(logs)))
    assert generic.flash == pytest.approx(math.exp(sum(f for _, f in logs) / len(logs)))
    assert generic.cycles is None
    assert band("generic", "Os", "flash") == max(band(m, "Os", "flash") or 0 for m in MACHINES)
    assert band("cortex-m4", "O2", "cycles") is None


def test_an_unknown_machine_is_a_key_error() -> None:
    """Nothing is guessed for it."""
    with pytest.raises(KeyError):
        estimate(load(ROOT / "benchmarks" / "w2.fz").lowered.program, "danger", "z80")


def test_a_callee_is_part_of_its_caller() -> None:
    """nav's step costs more than eight calls of danger and one of velocity, and holds the flash of both."""
    program = load(ROOT / "examples" / "nav.fz").lower(Options(target="cortex-m4")).program
    danger, velocity, nav = (estimate(program, name, "cortex-m4") for name in ("danger", "velocity", "nav"))
    assert danger.instructions is not None
    assert velocity.instructions is not None
    assert nav.instructions is not None
    assert nav.instructions > 6 * danger.instructions + velocity.instructions
    assert nav.flash > velocity.flash
    assert nav.stack > velocity.stack


def test_the_page_states_the_errors_that_the_weights_carry() -> None:
    """docs/cost.md is written by the same run as the weights."""
    page = (ROOT / "docs" / "cost.md").read_text()
    data = json.loads((ROOT / "fuzzyspec" / "estimate" / "weights.json").read_text())
    assert tell(page, data["machines"]) == page


def test_a_fit_finds_the_weights_that_figures_were_made_of() -> None:
    """Figures that are sums of two features give these back, though one of them was measured wrong."""
    given = [{"add.32": float(a), "entry": 1.0} for a in range(1, 40)]
    wanted = np.array([3.0 * f["add.32"] + 20 for f in given])
    wanted[7] *= 4
    found = fit(given, wanted, wanted)
    assert found["add.32"] == pytest.approx(3, rel=0.03)
    assert found["entry"] == pytest.approx(20, rel=0.03)


def test_programs_that_a_compiler_drops_are_told() -> None:
    """One that does ten times what others do for the same cost."""
    given = [{"add.32": 100.0}] * 9 + [{"add.32": 1000.0}]
    assert alive(given, np.full(10, 300.0)).tolist() == [True] * 9 + [False]
