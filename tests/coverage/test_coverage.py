"""Verify's own cases give every condition of the generated C both outcomes, but those that no input gives it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from fuzzyspec import api
from fuzzyspec.lower import Options
from fuzzyspec.lower.strategy import Goal, Target
from tests.conftest import required_tool
from tests.coverage.measured import measured
from tests.coverage.unreached import MOST, verdicts
from tests.random_specs.generator import spec

pytestmark = pytest.mark.gate

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def tools() -> None:
    """What counts, and what reads the counts."""
    for name in ("frama-c", "clang-19", "llvm-profdata-19", "llvm-cov-19"):
        required_tool(name)


SHORT: tuple[tuple[str, Goal, Target], ...] = (
    ("examples/tipper", "balanced", "generic"),
    ("examples/tipper", "speed", "cortex-m0plus"),
    ("examples/temperature", "balanced", "generic"),
    ("examples/nav", "balanced", "generic"),
    ("benchmarks/w1", "balanced", "avr"),
    ("benchmarks/w2", "speed", "cortex-m0plus"),
    ("benchmarks/w3s", "balanced", "generic"),
    ("random 1", "balanced", "generic"),
    ("random 4", "balanced", "generic"),
    ("random 8", "speed", "cortex-m0plus"),
)
CHOICES: tuple[tuple[Goal, Target], ...] = (
    ("balanced", "generic"),
    ("speed", "cortex-m0plus"),
    ("size", "generic"),
    ("balanced", "avr"),
)
LONG = [
    (name, goal, target)
    for name in ("examples/tipper", "examples/temperature", "benchmarks/w1", "benchmarks/w2", "benchmarks/w3s")
    for goal, target in CHOICES
    if (name, goal, target) not in SHORT
] + [
    ("random 4", "speed", "cortex-m0plus"),
    ("random 8", "balanced", "generic"),
    ("random 1", "speed", "generic"),
    ("examples/nav", "size", "generic"),
    ("examples/nav", "balanced", "avr"),
    ("benchmarks/w3", "balanced", "generic"),
    ("benchmarks/w3", "size", "generic"),
    ("benchmarks/w3", "balanced", "avr"),
]
OVERLAP = r"\(\w+_area > \w+_overlap\)"
GUARDS = rf"{OVERLAP}|\(\w+_moment > \w+_moment_off\)|num < den"
CEILING = {"examples/nav": (OVERLAP, 1 << 12), "benchmarks/w3": (GUARDS, 1 << 12)}
"""Where the search for an input comes to no end: outcomes that have not come up and may yet be left, and its boxes.

A controller of four inputs with a centroid has too many boxes around the corners of its terms for that.
"""


@pytest.mark.parametrize(
    ("name", "goal", "target"), [*SHORT, *(pytest.param(*case, marks=pytest.mark.long) for case in LONG)]
)
def test_every_branch_is_taken_or_shown_unreachable(name: str, goal: Goal, target: Target) -> None:
    """Both outcomes of every condition come up, unless no input at all has them; in a decision of several conditions
    each is shown to change it by itself, unless it has but one outcome; what is left is of the stated class."""
    seed = name.removeprefix("random ")
    loaded = api.load(spec(int(seed)) if seed != name else str(ROOT / f"{name}.fz"))
    options = Options(optimize=goal, target=target)
    program, files = loaded.lower(options).program, loaded.compile(options).files
    source = files[f"{program.name}.c"].decode()
    pattern, most = CEILING.get(name, ("", MOST))
    found = measured(program, files, loaded._subjects)
    assert len(found.had) > len(found.missed)
    ends = verdicts(program, files, loaded._subjects, found.missed, most)
    left = {f"{o.condition.of(source)} is {o.holds}: {v}" for o, v in ends.items() if v != "unreachable"}
    print(f"{len(found.had)} of {len(ends) + len(found.had)} outcomes, {len(ends) - len(left)} shown unreachable")
    print(f"{found.conditions - len(found.tied)} of {found.conditions} conditions shown to decide by themselves")
    assert [text for text in left if not re.fullmatch(f"({pattern}) is False: open", text)] == []
    stuck = {o.condition for o, v in ends.items() if v == "unreachable"}
    assert [c.of(source) for c in found.tied if c not in stuck] == []


PLANTED = """\
    if (service == 12347U) {
        if (in->food == 54321U) {
            service = 1U;
        }
    }
    if (service > 65535U) {
        service = 2U;
    }
"""


def test_what_is_missed_is_told_apart() -> None:
    """A planted branch for one input is missed, and that input found; one for no input is shown to be that."""
    loaded = api.load(str(ROOT / "examples" / "tipper.fz"))
    files, at = dict(loaded.compile().files), "    uint32_t service = in->service;\n"
    changed = files["tipper.c"].decode().replace(at, at + PLANTED)
    files["tipper.c"] = changed.encode()
    program = loaded.lower(Options()).program
    found = measured(program, files, loaded._subjects, 20_000)
    ends = {o.condition.of(changed): v for o, v in verdicts(program, files, loaded._subjects, found.missed).items()}
    assert ends["in->food == 54321U"] == "reached"
    assert ends["service > 65535U"] == "unreachable"


@pytest.mark.parametrize("target", ["generic", "cortex-m0plus"])
def test_what_came_up_is_never_shown_unreachable(target: Target) -> None:
    """Of outcomes that some input had none is called unreachable, and for most the search finds an input as well."""
    loaded, options = api.load(str(ROOT / "examples" / "temperature.fz")), Options(optimize="speed", target=target)
    program, files = loaded.lower(options).program, loaded.compile(options).files
    found = measured(program, files, loaded._subjects, 20_000)
    ends = verdicts(program, files, loaded._subjects, found.had, 1 << 13)
    assert [o for o, v in ends.items() if v == "unreachable"] == []
    assert sum(v == "reached" for v in ends.values()) > 10
