"""`make bench` in short: the page that it writes, the page that stands in docs, and what peers are given."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks import own
from benchmarks.__main__ import main
from benchmarks.baselines import lookup_c
from benchmarks.page import _up, page
from benchmarks.peers import PEERS, measure_generated, measure_peer, task_of
from benchmarks.peers.counted import instructions
from benchmarks.peers.fll import fll
from benchmarks.peers.task import SAMPLES, Skipped, imported
from benchmarks.plot import drawn
from benchmarks.results import Results, as_json, from_json
from benchmarks.workloads import WORKLOADS, Workload
from fuzzyspec.native import find_toolchain
from tests.benchmarks.hand_written import sampled
from tests.conftest import required_package, without
from tests.cost.cost_specs import compiler_for

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One workload and one target with few inputs, without peers: the folder that it wrote to."""
    compiler_for("cortex-m0plus")
    folder = tmp_path_factory.mktemp("bench")
    words = ["--short", "--no-peers", "--jobs", "1", "--target", "cortex-m0plus", "--workload", "W2"]
    assert main([*words, "--docs", str(folder), "--json", str(folder / "all.json")]) == 0
    return folder


def results_of(folder: Path) -> Results:
    """What was measured."""
    return from_json(json.loads((folder / "all.json").read_text(encoding="utf-8")))


def test_a_short_run_measures_all_three_kinds(short: Path) -> None:
    """fuzzyc, table and float C have a cost, an error and outputs that were compared; fuzzyc is within its bound."""
    results = results_of(short)
    assert [e.kind for e in results.own] == ["fuzzyc", "lookup table", "float C"]
    for entry in results.own:
        assert entry.error is not None
        assert {(r.target, r.option, r.matches) for r in entry.records} == {
            ("cortex-m0plus", "O2", True),
            ("cortex-m0plus", "Os", True),
        }
    fuzzyc = results.own[0]
    assert fuzzyc.error is not None
    assert fuzzyc.certified is not None
    assert fuzzyc.error.largest <= fuzzyc.certified
    assert all(r.instructions_worst is not None for r in fuzzyc.records)


def test_page_and_plot_are_the_same_for_the_same_results(short: Path, tmp_path: Path) -> None:
    """Written again from the figures alone, both come out byte for byte."""
    results = results_of(short)
    assert from_json(json.loads(json.dumps(as_json(results)))) == results
    assert main(["--again", str(short / "all.json"), "--docs", str(tmp_path)]) == 0
    for name in ("benchmarks.md", "benchmarks.svg"):
        assert (tmp_path / name).read_bytes() == (short / name).read_bytes()
    assert page(results).encode() == (short / "benchmarks.md").read_bytes()
    assert drawn(results) == (short / "benchmarks.svg").read_bytes()


def test_no_page_comes_of_c_that_computes_something_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A table's C with one entry changed is not its model's: status 1, the case named, nothing written."""
    compiler_for("cortex-m0plus")
    right = lookup_c

    def wrong(*arguments: Any) -> str:
        return right(*arguments).replace("return status;", "out->ddc ^= 1U;\n    return status;")

    monkeypatch.setattr(own, "lookup_c", wrong)
    words = ["--short", "--no-peers", "--jobs", "1", "--target", "cortex-m0plus", "--workload", "W2"]
    assert main([*words, "--docs", str(tmp_path / "docs")]) == 1
    assert "output ddc" in capsys.readouterr().err
    assert not (tmp_path / "docs").exists()


def test_bounds_are_never_rounded_down() -> None:
    """Two digits, upwards."""
    assert [_up(v) for v in (0.0051001, 0.0185, 0.4076, 1.21, None)] == ["0.0052 %", "0.019 %", "0.41 %", "1.3 %", "-"]
    assert all(float(_up(v).split()[0]) >= v for v in np.linspace(0.0001, 9.99, 500).tolist())


@pytest.mark.parametrize("workload", WORKLOADS, ids=lambda w: w.name)
def test_the_committed_page_has_a_row_for_every_workload(workload: Workload) -> None:
    """In the table of costs, with figures, and in that of errors."""
    text = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")
    name = re.escape(workload.name)
    assert re.search(rf"^\| {name} \| fuzzyc \| -O2 \| [\d,]+ \|", text, re.MULTILINE)
    assert re.search(rf"^\| {name} \| fuzzyc \| [\d.]+ % \| [\d.]+ % \| [\d.]+ % \|$", text, re.MULTILINE)


@pytest.mark.parametrize("workload", [w for w in WORKLOADS if w.short], ids=lambda w: w.name)
def test_peers_are_given_the_controller_itself(workload: Workload) -> None:
    """pyfuzzylite, from the text that fuzzylite gets too, computes what numpy does over the middles of 100 parts."""
    fuzzylite = pytest.importorskip("fuzzylite")
    task = task_of(workload, 12)
    engine = fuzzylite.FllImporter().from_string(fll(task.controller))
    for at, row in enumerate(task.rows):
        for variable, value in zip(engine.input_variables, row, strict=True):
            variable.value = value
        engine.process()
        values = {k: float(v[at]) for k, v in task.values.items()}
        for name, wanted in sampled(task.controller, values, SAMPLES, ends=False).items():
            # A few hundred operations of float64 on either side.
            room = 1000 * np.finfo(float).eps * task.ranges[name]
            assert abs(np.asarray(engine.output_variable(name).value).item() - wanted) <= room


@pytest.mark.parametrize("peer", [name for name in PEERS if name.startswith("scikit")])
def test_scikit_fuzzy_is_measured_or_left_out_with_a_reason(peer: str) -> None:
    """W2 by either of its interfaces has an error and a time; W3s is not for it."""
    required_package("skfuzzy")
    w2, w3s = (next(w for w in WORKLOADS if w.name == name) for name in ("W2", "W3s"))
    entry = measure_peer(peer, task_of(w2, 20, 20))
    assert entry.error is not None
    assert entry.nanoseconds is not None
    assert measure_peer(peer, task_of(w3s, 20)).left_out == "it has no weighted average of singletons"


def test_callgrind_counts_what_a_function_executes(tmp_path: Path) -> None:
    """A hundred more instructions a call, over three calls, are three hundred; what is outside does not count."""
    found = []
    for nops in (1, 101):
        body = f'__asm__ volatile (".rept {nops}\\n nop\\n .endr");'
        (tmp_path / "f.c").write_text(f"void counted(void);\nvoid counted(void) {{ {body} }}\n", encoding="utf-8")
        (tmp_path / "m.c").write_text(
            "void counted(void);\nint main(void) { counted(); counted(); counted(); return 0; }\n", encoding="utf-8"
        )
        find_toolchain().build([tmp_path / "m.c", tmp_path / "f.c"], tmp_path / "host", ("-O2",))
        total = instructions(["./host"], "counted", tmp_path)
        if total is None:
            without("valgrind is not installed")
        found.append(total)
    assert found[1] - found[0] == 300


def test_fuzzycs_own_c_is_measured_on_the_host() -> None:
    """With an error within its bound and a time; W3s has inputs below 0 to write into C."""
    (workload,) = [w for w in WORKLOADS if w.name == "W3s"]
    entry = measure_generated(workload, 50)
    assert entry.error is not None
    bounds = [o.percent_of_range for o in workload.spec.certificate("velocity").outputs]
    assert entry.error.largest <= max(float(b) for b in bounds if b is not None)
    assert entry.nanoseconds is not None


def test_a_library_that_is_not_installed_is_skipped() -> None:
    """With the reason that the page then gives."""
    with pytest.raises(Skipped, match="not installed"):
        imported("no_such_library_of_fuzzy_logic")
