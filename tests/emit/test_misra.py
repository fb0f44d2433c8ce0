"""The generated C deviates from MISRA C:2012 where docs/misra.md says so, and nowhere else."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzzyspec import load
from fuzzyspec.emit import write
from fuzzyspec.lower import Options
from fuzzyspec.lower.strategy import Goal, Target
from tests.emit.emit_misra import PAGE, allowed, beyond, findings
from tests.random_specs.generator import spec

ROOT = PAGE.parents[1]
TEXT = PAGE.read_text(encoding="utf-8")
CASES: tuple[tuple[str, Goal, Target], ...] = (
    ("examples/nav", "balanced", "generic"),
    ("examples/temperature", "balanced", "generic"),
    ("examples/tipper", "balanced", "generic"),
    ("benchmarks/w1", "speed", "avr"),
    ("benchmarks/w2", "speed", "cortex-m0plus"),
    ("benchmarks/w3", "speed", "avr"),
    ("benchmarks/w3", "size", "cortex-m0plus"),
    ("benchmarks/w3s", "size", "cortex-m4"),
)


@pytest.mark.gate
@pytest.mark.parametrize(("name", "goal", "target"), CASES)
def test_nothing_is_found_beyond_the_page(name: str, goal: Goal, target: Target, tmp_path: Path) -> None:
    """In header, source and self-test of what the goal and the target choose."""
    write(load(ROOT / f"{name}.fz").compile(Options(optimize=goal, target=target)), tmp_path)
    found = findings(tmp_path)
    assert found != []
    assert beyond(found, TEXT) == []


@pytest.mark.gate
@pytest.mark.parametrize("seed", [2, 5])
def test_nothing_is_found_in_random_specs(seed: int, tmp_path: Path) -> None:
    """Nor in C of several controllers and systems with lists and states."""
    path = tmp_path / "random.fz"
    path.write_text(spec(seed))
    write(load(path).compile(Options()), tmp_path / "c")
    assert beyond(findings(tmp_path / "c"), TEXT) == []


VIOLATIONS = {
    "15.6": "uint32_t planted(uint32_t x) { if (x > 1U) x = 1U; return x; }",
    "15.1": "uint32_t planted(uint32_t x) { if (x > 1U) { goto end; } x = 2U; end: return x; }",
    "13.4": "uint32_t planted(uint32_t x) { uint32_t y; if ((y = x) > 1U) { y = 1U; } return y; }",
    "7.1": "uint32_t planted(uint32_t x) { return x + 017; }",
    "7.3": "int32_t planted(void) { return 7l; }",
    "12.2": "uint8_t planted(uint8_t x) { return (uint8_t)((uint8_t)1U << 9U) + x; }",
    "17.2": "uint32_t planted(uint32_t x) { return planted(x); }",
}


@pytest.mark.parametrize("rule", VIOLATIONS)
def test_a_planted_violation_is_beyond_the_page(rule: str, tmp_path: Path) -> None:
    """Of rules that are not listed, and of listed ones on a line that is not as the page says."""
    (tmp_path / "planted.c").write_text(f"#include <stdint.h>\n{VIOLATIONS[rule]}\n")
    assert rule in {f.rule for f in beyond(findings(tmp_path), TEXT)}


@pytest.mark.gate
def test_every_deviation_is_needed(tmp_path: Path) -> None:
    """Each row of the page is found in some C that we generate: none is left over."""
    found: set[str] = set()
    for name, goal, target in (CASES[0], CASES[3]):
        write(load(ROOT / f"{name}.fz").compile(Options(optimize=goal, target=target)), tmp_path / name)
        found |= {f.rule for f in findings(tmp_path / name)}
    assert set(allowed(TEXT)) == found
