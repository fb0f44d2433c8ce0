"""Recorded inputs: what a CSV may hold, and what is said of one that is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzzyspec import api
from fuzzyspec.verify import ScenarioError, read_scenario
from tests.verify import verify_specs

HEADER = "time, x, parts.0.size, parts.0.kind, parts.1.size, parts.1.kind\n"


@pytest.fixture(scope="module")
def keeper() -> api.Spec:
    """A system with a list and a state."""
    return api.load(verify_specs.HOLDING)


def test_rows_become_steps_from_the_first_state(keeper: api.Spec) -> None:
    """Values are quantised, lists end where a row does, and each row starts from the state that the last one left."""
    text = HEADER + "0, -1.0, 0.5, 3, , \n1, 0.0, , , , \n\n2, 1.5, 1, 2, 1.25, 9\n"
    rows = read_scenario(keeper._subject("both"), text, "log.csv")
    assert [row.follow for row in rows] == [False, True, True]
    assert [int(row.inputs["parts.count"][0]) for row in rows] == [1, 0, 2]
    assert [int(row.inputs["x"][0]) for row in rows] == [-16384, 0, 24576]
    assert rows[2].inputs["parts.size"].tolist() == [[1 << 14, 20480]]


def test_raws_and_counts_may_be_given(keeper: api.Spec) -> None:
    """With raws nothing is converted, and a count past the capacity is kept as recorded."""
    header = "x,parts.count," + ",".join(f"parts.{i}.{f}" for i in range(3) for f in ("size", "kind"))
    rows = read_scenario(keeper._subject("both"), f"{header}\n-32768,200,1,2,3,4,5,6\n", "log.csv", raw=True)
    assert rows[0].inputs["x"].tolist() == [-32768]
    assert rows[0].inputs["parts.count"].tolist() == [200]
    assert rows[0].inputs["parts.kind"].tolist() == [[2, 4, 6]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "log.csv: no header line"),
        ("x\n", "log.csv: no rows"),
        ("y\n1\n", "log.csv:1: `both` has no signal `y`"),
        ("x,x\n1,1\n", "log.csv:1: the column `x` appears twice"),
        ("parts.0.size,parts.0.kind\n1,1\n", "log.csv:1: no column `x`"),
        ("x,parts.0.size\n1,1\n", "log.csv:1: no column `parts.0.kind`"),
        ("x,parts.1.size,parts.1.kind\n1,1,1\n", "log.csv:2: element 0 of `parts`"),
        (HEADER + "0, 1, 0.5, , , \n", "log.csv:2: element 0 of `parts`"),
        (HEADER + "0, 1, , , 0.5, 1\n", "log.csv:2: element 0 of `parts`"),
        (HEADER + "0, 1, 0.5, 1\n", "log.csv:2: 4 values under 6 columns"),
        (HEADER + "0, one, 0.5, 1, , \n", "log.csv:2: x: `one` is no number"),
        (HEADER + "0, nan, 0.5, 1, , \n", "log.csv:2: x: `nan` is no number"),
        (HEADER + "0, , 0.5, 1, , \n", "log.csv:2: x: no value"),
        ("x,parts.count\n1,-1\n", "log.csv:2: parts.count: `-1` is no count"),
        ("x,parts.count\n1,1\n", "log.csv:2: element 0 of `parts`"),
        ("x,parts.999.size,parts.999.kind\n1,,\n", "log.csv:1: the column `parts.999.size` is beyond any list"),
    ],
)
def test_bad_recordings_are_told_by_line_and_column(text: str, message: str, keeper: api.Spec) -> None:
    """Whatever is wrong with a CSV, the message says where."""
    with pytest.raises(ScenarioError) as caught:
        read_scenario(keeper._subject("both"), text, "log.csv")
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(("text", "message"), [("x\n0.5\n", "`0.5` is no raw"), ("x\n40000\n", "`40000` is no raw")])
def test_raws_must_be_raws(text: str, message: str, keeper: api.Spec) -> None:
    """A fraction, or a number that the C type does not hold, is refused."""
    with pytest.raises(ScenarioError, match=message):
        read_scenario(keeper._subject("hold"), text, "log.csv", raw=True)


def test_a_replay_verifies_its_rows_alone(keeper: api.Spec, tmp_path: Path) -> None:
    """Every row goes through C, model and exact meaning, in order, and nothing else does."""
    log = tmp_path / "a log.csv"
    log.write_text(HEADER + "0, -1, 0.5, 3, , \n1, 0, , , , \n2, 1, 1, 2, 1.25, 9\n", encoding="utf-8")
    report = keeper.verify(scenario=log)
    assert report.ok
    assert [f.function for f in report.functions] == ["both"]
    assert report.functions[0].kinds == {"scenario": 3}
