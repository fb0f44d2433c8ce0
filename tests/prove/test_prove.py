"""The C of examples and workloads is proved free of alarms, and C with a fault is not."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from fuzzyspec import load
from fuzzyspec.cli.main import main
from fuzzyspec.emit.names import name_module
from fuzzyspec.lower import Options
from fuzzyspec.lower.strategy import Goal, Target
from fuzzyspec.prove import WIDTHS, needed, prove
from fuzzyspec.prove.driver import print_driver
from tests.conftest import required_tool
from tests.random_specs.generator import spec as random_spec

pytestmark = pytest.mark.gate

ROOT = Path(__file__).resolve().parents[2]
W1 = ROOT / "benchmarks" / "w1.fz"
CASES: tuple[tuple[str, Goal, Target], ...] = (
    ("examples/nav", "balanced", "generic"),
    ("examples/temperature", "balanced", "generic"),
    ("examples/tipper", "balanced", "generic"),
    ("benchmarks/w1", "balanced", "generic"),
    ("benchmarks/w2", "balanced", "generic"),
    ("benchmarks/w3", "balanced", "generic"),
    ("benchmarks/w3s", "balanced", "generic"),
    ("benchmarks/w1", "speed", "avr"),
    ("benchmarks/w2", "speed", "cortex-m0plus"),
    ("benchmarks/w2", "size", "cortex-m0plus"),
    ("benchmarks/w3", "balanced", "rv32imc"),
    ("benchmarks/w3s", "size", "cortex-m0plus"),
)
"""Each way to divide by loops, by the machine, by a table and without is among them; the rest is `make prove`'s."""
SEEDS = range(10)


@pytest.mark.parametrize("bits", WIDTHS)
@pytest.mark.parametrize(("spec", "goal", "target"), CASES)
def test_no_alarm_is_left(spec: str, goal: Goal, target: Target, bits: int) -> None:
    """Of any input, count and state, with an int of 32 bits and of 16: no overflow, wrap-around or invalid access."""
    required_tool("frama-c")
    loaded, options = load(ROOT / f"{spec}.fz"), Options(optimize=goal, target=target)
    proof = prove(loaded.lower(options).program, loaded.compile(options).files, bits)
    assert proof.alarms == ()
    assert proof.seen > 0
    assert sum(proof.proved.values()) > 0


@pytest.mark.parametrize("bits", WIDTHS)
@pytest.mark.parametrize("seed", SEEDS)
def test_no_alarm_is_left_in_a_random_spec(seed: int, bits: int, tmp_path: Path) -> None:
    """Specs that nobody has chosen are proved like those that we have."""
    required_tool("frama-c")
    path = tmp_path / f"random{seed}.fz"
    path.write_text(random_spec(seed), encoding="utf-8")
    loaded = load(path)
    proof = prove(loaded.lower(Options()).program, loaded.compile(Options()).files, bits)
    assert proof.alarms == ()
    assert sum(proof.proved.values()) > 0


FAULTS = {
    "a missing shift": (r" >> 16U;\n    uint32_t service_mu", r";\n    uint32_t service_mu"),
    "a missing zero test": (r"if \(num < den\)", "if (num <= den)"),
    "an index one too far": (r"k < 3U", "k <= 3U"),
    "a dropped clamp": (r"service_at = 20480U;", "service_at = service_at;"),
    "a digit too many": (r"\(num << 8U\) / den", "(num << 9U) / den"),
    "a lost difference": (r"\(tip_h << 8U\) - tip_square", "(tip_h << 6U) - tip_square"),
    "an output that is not set": (r"out->tip = \(uint16_t\)tip_steps;", "(void)tip_steps;"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_an_alarm(fault: str) -> None:
    """One change of the C, and something that the analyser asks for cannot be proved any more."""
    required_tool("frama-c")
    options = Options(optimize="size", target="rv32imc")
    loaded = load(W1)
    files = dict(loaded.compile(options).files)
    changed, count = re.subn(*FAULTS[fault], files["w1.c"].decode(), count=1)
    assert count == 1
    files["w1.c"] = changed.encode()
    assert prove(loaded.lower(options).program, files, 32).alarms != ()


LISTS = """\
module lists
system far {
    input seen[3] { gap in [0, 9] m }
    output most = max(s.gap for s in seen, otherwise 0 m)
}
"""


def test_a_list_is_read_no_further_than_its_count(tmp_path: Path) -> None:
    """Counts up to the bound and beyond are no alarm; a clamp of the count that lets one more through is."""
    required_tool("frama-c")
    path = tmp_path / "lists.fz"
    path.write_text(LISTS)
    loaded = load(path)
    program, files = loaded.lower(Options()).program, dict(loaded.compile().files)
    assert prove(program, files, 32).alarms == ()
    source = files["lists.c"].decode()
    for old, new in (("seen_used > LISTS_SEEN_MAX", "seen_used > 4U"), ("n < seen_used", "n <= seen_used")):
        assert old in source
        alarms = prove(program, files | {"lists.c": source.replace(old, new, 1).encode()}, 32).alarms
        assert any(a.kind == "mem_access" for a in alarms)


HELD = """\
module held
controller fan {
    input x in [0, 10] K raw uint8 0..100 { partition low high }
    output y in [0, 10] K raw int16 step 0.1 {
        singletons SLOW FAST
        otherwise hold initial 1 K
    }
    fires at 1/2
    rules { if x is low then y is SLOW with 0.8  if x is high then y is FAST with 0.8 }
}
system held {
    input x in [0, 10] K raw uint8 0..100
    let y = fan(x: x)
    output z in [0, 100] = (y.y * y.y) / (1 K * 1 K)
}
"""


def test_a_state_is_shown_to_keep_its_range(tmp_path: Path) -> None:
    """Where any state were too much, one in range is enough, unless a call or the setting up leaves the range."""
    required_tool("frama-c")
    path = tmp_path / "held.fz"
    path.write_text(HELD)
    loaded = load(path)
    program, files = loaded.lower(Options()).program, dict(loaded.compile().files)
    proof = prove(program, files, 32)
    assert proof.alarms == ()
    assert proof.kept
    source = files["held.c"].decode()
    for old, new in (("state->y = 10;", "state->y = -1;"), ("state->y = (int16_t)y_steps", "state->y = (int16_t)-1")):
        assert old in source
        faulty = prove(program, files | {"held.c": source.replace(old, new, 1).encode()}, 32)
        assert any(a.kind.startswith("given_") for a in faulty.alarms)


def test_the_driver_leaves_nothing_out() -> None:
    """Every function is called, with every input, count and record from where the analyser takes any value."""
    program = load(ROOT / "examples" / "nav.fz").lower(Options()).program
    names, driver = name_module(program), print_driver(program)
    for function in names.functions.values():
        assert f"(void){function.function}(" in driver
    assert "in.obstacles_count = any_uint8;" in driver
    assert "a_obstacles[i].bearing = any_int16;" in driver
    assert "in.target_bearing = any_int16;" in driver


def test_the_command_proves_and_refuses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Status 0 and a line a width where nothing is left; 1 and the alarms for a C with a fault; 2 for a wrong word."""
    required_tool("frama-c")
    needed()
    assert main(["prove", str(W1), "--int-bits", "32"]) == 0
    assert capsys.readouterr().out.endswith("w1: proved\n")
    bad = tmp_path / "bad.c"
    source = load(W1).compile(Options(optimize="size", target="rv32imc")).files["w1.c"].decode()
    bad.write_text(source.replace("if (num < den)", "if (num <= den)"))
    chosen = ["--target", "rv32imc", "--optimize", "size", "--int-bits", "32"]
    assert main(["prove", str(W1), *chosen, "--c", str(bad), "--format", "json"]) == 1
    (proof,) = json.loads(capsys.readouterr().out)["proofs"]
    assert not proof["ok"]
    assert "division_by_zero" in {a["kind"] for a in proof["alarms"]}
    assert main(["prove", str(W1), "--optimize", "fast"]) == 2
