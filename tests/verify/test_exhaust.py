"""``fuzzyc verify --exhaustive``: every input once, a fault at one of them, interruptions, and what is refused."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyspec import load
from fuzzyspec.cli.main import INTERRUPTED, main
from fuzzyspec.cli.progress import duration
from fuzzyspec.cli.sweepfile import SweepFile
from fuzzyspec.emit import write
from fuzzyspec.verify import Sweep, Swept
from fuzzyspec.verify.space import space_of, spoken_count
from fuzzyspec.verify.swept import BlockFound
from tests.verify import verify_specs

ALL = 256 * 256
"""Inputs of the controller of BYTES."""

SMALL_LIST = """\
module one
controller hold {
    input  x in [-1, 1] raw int8 { term low = ramp_down(-0.8, -0.3)  term high = ramp_up(0.2, 0.9) }
    output y in [0, 3] raw uint8 step 1 { singletons A B  otherwise hold initial 2 }
    infer { defuzzify = weighted_average }
    rules {
        if x is low then y is A
        if x is high then y is B
    }
}
system both {
    input parts[1] { size in [0, 2] m raw uint8 }
    output big = max(p.size for p in parts, otherwise 0 m)
}
"""


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    """A controller of two bytes, with its C beside it."""
    path = tmp_path / "tiny.fz"
    path.write_text(verify_specs.BYTES, encoding="utf-8")
    write(load(path).compile(), tmp_path)
    return path


@pytest.fixture
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sixteen blocks of four slices."""
    monkeypatch.setattr("fuzzyspec.verify.exhaust.BLOCK", ALL // 16)
    monkeypatch.setattr("fuzzyspec.verify.exhaust.SLICE", ALL // 64)


def swept(spec: Path, capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, dict[str, Any]]:
    """The exit status and the report of a sweep after very few other cases."""
    common = ["--exhaustive", "--cases", "10", "--no-sanitize", "--format", "json"]
    status = main(["verify", str(spec), *common, *words])
    return status, json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(("function", "inputs"), [("hold", 256 * 4), ("both", 256 * 256)])
def test_a_space_holds_every_input_once(function: str, inputs: int) -> None:
    """Raws, legal states, counts and list elements: as many different cases as there are numbers."""
    (subject,) = [s for s in load(SMALL_LIST)._subjects if s.name == function]
    space = space_of(subject)
    assert space.inputs == inputs
    batch = space.batch(np.arange(inputs))
    columns = [v.reshape(inputs, -1) for v in (*batch.inputs.values(), *batch.state.values())]
    assert len(np.unique(np.hstack(columns), axis=0)) == inputs
    assert subject.fixed(batch.inputs, batch.state).status.shape == (inputs,)


@pytest.mark.usefixtures("small_blocks")
def test_every_input_is_swept(tiny: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """All of them through C, program and meaning; the largest error is not below what random cases find."""
    status, report = swept(tiny, capsys)
    assert status == 0
    (found,) = report["functions"]
    assert found["kinds"]["every input"] == ALL
    assert report["notes"][-1] == "fan: every input went through C and integer program, the exact meaning too"
    assert main(["verify", str(tiny), "--cases", "20000", "--no-sanitize", "--format", "json"]) == 0
    (random,) = json.loads(capsys.readouterr().out)["functions"]
    assert found["outputs"][0]["largest_error"] == random["outputs"][0]["largest_error"]


@pytest.mark.usefixtures("small_blocks")
def test_a_fault_at_one_input_of_all_is_found(tiny: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One bit at one input: exit status 1, and that input is shown."""
    text = tiny.with_suffix(".c").read_text(encoding="utf-8")
    start = text.index("\ntiny_status_t tiny_fan(")
    end = text.index("return", start)
    change = "if ((in->error == 91) && (in->rate == 203U)) { out->duty ^= 1U; }\n    "
    mine = tiny.with_name("mine.c")
    mine.write_text(text[:end] + change + text[end:], encoding="utf-8")
    status, report = swept(tiny, capsys, "--c", str(mine))
    assert status == 1
    (failure,) = report["failures"]
    assert (failure["kind"], failure["example"]["raws"]) == ("c", {"error": 91, "rate": 203})


class _Stopped:
    """Keeps in a file, and is interrupted at the fifth block."""

    def __init__(self, file: SweepFile) -> None:
        self._file = file
        self._blocks = 0

    def load(self, key: Mapping[str, str]) -> Mapping[str, Swept]:
        """As the file."""
        return self._file.load(key)

    def save(self, found: Mapping[str, Swept], *, last: bool) -> None:
        """As the file, up to a point."""
        self._file.save(found, last=last)
        self._blocks += 1
        if self._blocks == 5:
            raise KeyboardInterrupt


@pytest.mark.usefixtures("small_blocks")
def test_an_interrupted_sweep_goes_on_where_it_was(tiny: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What was done is kept, the rest follows, and the outcome is that of a sweep in one go."""
    state = tiny.with_name("state.json")
    told: list[tuple[int, float, int]] = []
    sweep = Sweep(_Stopped(SweepFile(state)), lambda *words: told.append(words), processors=1)
    with pytest.raises(KeyboardInterrupt):
        load(tiny).verify(cases=10, sanitize=False, sweep=sweep)
    ((inputs, seconds, processors),) = told
    assert (inputs, processors) == (ALL, 1)
    assert seconds > 0
    kept = json.loads(state.read_text(encoding="utf-8"))["functions"]["fan"]["done"]
    assert kept == [[0, 5]]
    status, resumed = swept(tiny, capsys, "--state", str(state))
    assert status == 0
    assert resumed["notes"][-1].endswith(f"{5 * ALL // 16:,} of them in an earlier run")
    _, whole = swept(tiny, capsys)
    assert resumed["functions"] == whole["functions"]


def test_interrupted_on_the_command_line(
    tiny: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit status 130, and a word on how to go on."""
    state = tiny.with_name("state.json")

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("fuzzyspec.verify.exhaust._blocks", interrupt)
    assert main(["verify", str(tiny), "--exhaustive", "--cases", "10", "--state", str(state)]) == INTERRUPTED
    assert "the same command goes on from there" in capsys.readouterr().err
    assert json.loads(state.read_text(encoding="utf-8"))["functions"]["fan"]["done"] == []


def test_a_state_of_something_else_is_refused_and_left_alone(tiny: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of another spec, and a file that is no state at all: exit status 2, the file as it was."""
    state = tiny.with_name("state.json")
    words = ["verify", str(tiny), "--exhaustive", "--cases", "10", "--no-sanitize", "--state", str(state)]
    assert main(words) == 0
    before = state.read_text(encoding="utf-8")
    tiny.write_text(verify_specs.BYTES.replace("0.7", "0.6"), encoding="utf-8")
    capsys.readouterr()
    assert main(words) == 2
    assert "is of another spec" in capsys.readouterr().err
    assert state.read_text(encoding="utf-8") == before
    for other in ('{"kind": "fuzzyc sweep"}', "[]", "my notes"):
        state.write_text(other, encoding="utf-8")
        assert main(words) == 2
        assert "was not written by --exhaustive" in capsys.readouterr().err
        assert state.read_text(encoding="utf-8") == other


def test_too_many_inputs_are_refused_with_their_number(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Exit status 2, how many there are, and what can be swept."""
    path = tmp_path / "keeper.fz"
    path.write_text(verify_specs.HOLDING, encoding="utf-8")
    assert main(["verify", str(path), "--exhaustive"]) == 2
    said = capsys.readouterr().err
    assert "at most 4,294,967,296 inputs can be swept, but both has about 2^" in said
    assert "--only hold" in said
    assert main(["verify", str(path), "--state", "x"]) == 2
    assert "give --exhaustive too" in capsys.readouterr().err


@given(st.permutations(range(12)))
def test_blocks_come_in_any_order(order: list[int]) -> None:
    """The account is the same, is told apart from what is missing, and survives its file."""
    found = [BlockFound(b, b, {"y": (float(b % 5), b)}, {"d": (1, b % 2, float(b))}, ()) for b in range(12)]
    account = Swept()
    for position, block in enumerate(order):
        assert set(account.missing(12)) == set(order[position:])
        account.add(found[block])
        account = Swept.from_data(json.loads(json.dumps(account.as_data())))
    assert account == Swept([(0, 12)], sum(range(12)), {"y": (4.0, 4)}, {"d": (12, 6, 11.0)})


def test_numbers_and_times_are_told_for_people() -> None:
    """In full while they can be read."""
    assert spoken_count(2**32) == "4,294,967,296"
    assert spoken_count(2**64) == "about 2^64"
    assert [duration(s) for s in (3.4, 99, 100, 5999, 7200)] == ["3 s", "99 s", "2 min", "100 min", "2.0 h"]
