"""``fuzzyc verify --c FILE`` finds a changed C: mutants are killed, or shown to compute the same."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzzyspec import api
from fuzzyspec.lower import Options
from tests.conftest import required_tool
from tests.mutation.c_mutants import mutants, parse
from tests.mutation.c_score import Equal, sampled, score
from tests.mutation.c_sweep import swept_equal
from tests.mutation.c_trial import FOUND, Trial
from tests.verify import verify_specs

pytestmark = pytest.mark.gate

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(autouse=True)
def compilers() -> None:
    """Mutants are compiled by both."""
    required_tool("gcc")
    required_tool("clang")


SWEPT = verify_specs.DANGER.replace("in [0, 6] ", "in [0, 6] raw uint8 0..250 ")
"""What a mutant computes of its 2^24 inputs is seen in seconds, while verify tries but a part of them."""
SHORT = {
    "rules as code of their own": (SWEPT, Options(optimize="speed", target="cortex-m0plus"), 40),
    "rules in loops": (SWEPT, Options(optimize="size", target="avr"), 40),
    "bytes": (verify_specs.BYTES, Options(target="avr"), 40),
}


def test_what_is_changed() -> None:
    """A mutant changes one place of the text and is C to the parser; every kind there is comes up in an example."""
    source = api.load(str(EXAMPLES / "nav.fz")).compile().files["nav.c"]
    found = mutants(source)
    assert {m.kind for m in found} == {
        *("constant", "table", "index", "operator", "comparison", "clamp", "deleted statement", "dropped else"),
        *("swapped operands", "cast", "type of a local"),
    }
    broken = parse(source).has_error
    for mutant in sampled(found, 60, 1):
        changed = mutant.of(source)
        assert changed != source and changed.startswith(source[: mutant.start])
        assert changed.endswith(source[mutant.end :]) and parse(changed).has_error == broken


@pytest.mark.parametrize("name", SHORT)
def test_mutants_are_killed(name: str) -> None:
    """Of a sample, 99 % of what is not shown to do the same are killed by verify: as much as is promised of all."""
    text, options, most = SHORT[name]
    found = score(text, options, most)
    print(found, *found.left, sep="\n")
    assert found.killed >= most // 4
    assert found.percent >= 99.0, found.left


def test_the_short_way_says_what_verify_says(tmp_path: Path) -> None:
    """Verify itself, given the mutated file, fails for the mutants that the trial calls killed, and for no other."""
    loaded = api.load(verify_specs.BYTES)
    with Trial(loaded, Options()) as trial:
        ends = {m: trial.verdict(m) for m in sampled(trial.mutants, 12, 3)}
        for name, content in trial.files.items():
            (tmp_path / name).write_bytes(content)
        assert {v in FOUND for v in ends.values()} == {True, False}
        for mutant, end in ends.items():
            (tmp_path / trial.name).write_bytes(mutant.of(trial.source))
            report = loaded.verify(c=tmp_path / trial.name)
            assert report.ok == (end in ("survived", "same object")), (mutant, end)


def test_no_killed_mutant_is_shown_equal() -> None:
    """The proofs never call equal what differs: of mutants that are killed, none is shown to do the same."""
    with Trial(api.load(verify_specs.BYTES), Options(optimize="size"), cases=20_000) as trial:
        judge = Equal(trial)
        killed = [m for m in sampled(trial.mutants, 50, 5) if trial.verdict(m) in FOUND]
        assert len(killed) > 20
        assert [str(m) for m in killed if judge.equal(m)] == []
        assert [str(m) for m in killed[::8] if swept_equal(trial, m)] == []
