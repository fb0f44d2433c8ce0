"""The derived worst case of real builds: never below what was measured, and close to it."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzzyspec import load
from fuzzyspec.cost import Conditions, Record, measure
from fuzzyspec.cost.limit import limit
from fuzzyspec.lower import Options
from fuzzyspec.machines.toolchains import Kind
from fuzzyspec.model.controller import Controller
from tests.cost.cost_specs import compiler_for

ROOT = Path(__file__).resolve().parents[2]
MARKS = {"w2": (), **dict.fromkeys(("w1", "w3", "w3s", "nav"), pytest.mark.gate)}
SPECS = [
    pytest.param(path, id=path.stem, marks=MARKS.get(path.stem, pytest.mark.long))
    for path in sorted([*(ROOT / "benchmarks").glob("*.fz"), *(ROOT / "examples").glob("*.fz")])
]
BUILDS: list[tuple[str, Kind | None]] = [
    ("cortex-m0plus", "gcc"),
    ("cortex-m0plus", "zig"),
    ("cortex-m4", "gcc"),
    ("cortex-m4", "zig"),
    ("rv32imc", "gcc"),
    ("rv32imc", "zig"),
    ("avr", None),
]

M7 = [(path, kind) for path in ("w1", "w3s", "nav") for kind in ("gcc", "zig")]
"""The Cortex-M7 has the M4's instructions; other compilers' choices for it are tried on few."""

NOT_DERIVED = {("nav", "cortex-m0plus", "zig")}
"""That the list is not empty there is known of another register than its count, through more branches than are told
apart."""


def records_of(text: str, target: str, kind: Kind | None, option: str, inputs: int) -> tuple[Record, ...]:
    """What ``fuzzyc cost`` would tell of a spec."""
    conditions = Conditions((compiler_for(target, kind),), (option,), inputs, worst=True)
    spec = load(text)
    chosen = Options(optimize="size" if option == "Os" else "speed", target=target)
    return measure(spec.lowered.program, lambda *_: spec.compile(chosen).files, conditions).records


@pytest.mark.parametrize(("target", "kind"), BUILDS)
@pytest.mark.parametrize("option", ["O2", "Os"])
@pytest.mark.parametrize("path", SPECS)
def test_the_derived_worst_case_holds_and_is_close(path: Path, target: str, kind: Kind | None, option: str) -> None:
    """For every function of the benchmarks and the examples: no input took more, and the largest is not far below. No
    controller takes less than is counted."""
    holds_and_is_close(path, target, kind, option)


@pytest.mark.gate
@pytest.mark.parametrize(("stem", "kind"), M7)
def test_it_does_on_a_cortex_m7_too(stem: str, kind: Kind) -> None:
    """The same, of the build for speed."""
    folder = "examples" if stem == "nav" else "benchmarks"
    holds_and_is_close(ROOT / folder / f"{stem}.fz", "cortex-m7", kind, "O2")


def holds_and_is_close(path: Path, target: str, kind: Kind | None, option: str) -> None:
    """Measured, limit and derived of a spec's functions, in their order."""
    text = path.read_text(encoding="utf-8")
    functions = load(text).functions
    for record in records_of(text, target, kind, option, 60):
        function = functions[record.function]
        mean = record.cycles_mean if target == "avr" else record.instructions_mean
        assert mean is not None
        assert not isinstance(function, Controller) or limit(function, target) <= mean
        if (record.function, target, kind) in NOT_DERIVED:
            assert record.worst_reason is not None
            assert "has no bound that could be derived" in record.worst_reason
            continue
        pairs = [(record.instructions_max, record.instructions_worst), (record.cycles_max, record.cycles_worst)]
        told = [(seen, worst) for seen, worst in pairs if seen is not None]
        assert told, record
        for seen, worst in told:
            assert worst is not None, record
            assert seen <= worst <= 1.5 * seen, record
