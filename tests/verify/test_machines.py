"""``fuzzyc verify --target``: real runs on every machine, and planted C that is right on some machines only."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from fuzzyspec import load
from fuzzyspec.cli.main import main
from fuzzyspec.cli.verify import LEVELS, MACHINES
from fuzzyspec.emit import write
from fuzzyspec.verify import LEVELS as ALL_LEVELS
from fuzzyspec.verify import NAMES
from tests.conftest import required_package, required_tool
from tests.verify import verify_specs

FEW = ["--cases", "300", "--target-cases", "200", "--no-sanitize", "--format", "json"]
TARGETS = ("host", "cortex-m0plus", "cortex-m4", "rv32imc", "avr", "mips-be", "wasm32")


@pytest.fixture(autouse=True)
def tools() -> None:
    """What runs the targets' images, and a compiler for each."""
    for package in ("unicorn", "elftools", "wasmtime", "ziglang"):
        required_package(package)
    required_tool("simavr")
    required_tool("avr-gcc")


@pytest.fixture
def keeper(tmp_path: Path) -> Path:
    """A controller that holds, and a system with a list, with their C beside them."""
    path = tmp_path / "keeper.fz"
    path.write_text(verify_specs.HOLDING, encoding="utf-8")
    write(load(path).compile(), tmp_path)
    return path


def verified(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, dict[str, Any]]:
    """The exit status and the report of a short verification."""
    status = main(["verify", *words, *FEW])
    return status, json.loads(capsys.readouterr().out)


def test_the_command_line_offers_what_there_is() -> None:
    """Its lists, which cost no import, are those of the verification."""
    assert MACHINES == NAMES
    assert LEVELS == ALL_LEVELS


def test_every_machine_agrees(keeper: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Lists, state, status and self-test, two levels: a record for each build, all without a mismatch."""
    status, report = verified(capsys, str(keeper), "--target", ",".join(TARGETS), "--levels", "O0,O2")
    assert status == 0
    records = report["machines"]
    assert isinstance(records, list)
    assert {r["target"] for r in records} == set(TARGETS)
    for record in records:
        assert (record["mismatches"], record["selftest"], record["left_out"]) == (0, 0, None)
        assert [f["cases"] for f in record["functions"]] == [200, 200]
    builds = {(r["target"], r["compiler"], r["level"]) for r in records}
    assert len(builds) == len(records) == 2 * len({b[:2] for b in builds})


@pytest.mark.gate
@pytest.mark.parametrize(
    ("condition", "wrong"),
    [
        ("sizeof(int) == 2U", {"avr"}),
        ("*(const unsigned char *)&one == 0U", {"mips-be"}),
        ("sizeof(void *) == 4U", {"cortex-m4", "mips-be", "wasm32"}),
        ("sizeof(void *) == 8U", {"host"}),
    ],
    ids=["16-bit int", "big-endian", "32-bit pointers", "64-bit pointers"],
)
def test_c_that_depends_on_the_machine_is_caught_there(
    keeper: Path, capsys: pytest.CaptureFixture[str], condition: str, wrong: set[str]
) -> None:
    """Exit status 1; the target, its compiler and level are named, with a smallest input; the others pass."""
    line = "\nkeeper_status_t keeper_hold("
    text = keeper.with_suffix(".c").read_text(encoding="utf-8")
    start = text.index(line)
    end = text.index("return", start)
    change = f"const uint16_t one = 1U; (void)one; if ({condition}) {{ out->y = 3U; }}\n    "
    mine = keeper.with_name("mine.c")
    mine.write_text(text[:end] + change + text[end:], encoding="utf-8")
    targets = ["avr", "mips-be", "cortex-m4", "wasm32", "host"]
    words = ["--target", ",".join(targets), "--levels", "O2", "--c", str(mine), "--only", "hold"]
    status, report = verified(capsys, str(keeper), *words)
    assert status == 1
    failures, records = report["failures"], report["machines"]
    assert isinstance(failures, list)
    assert isinstance(records, list)
    assert {r["target"] for r in records if r["mismatches"]} == wrong
    found = [f for f in failures if f["on"] is not None and f["kind"] == "c"]
    assert {f["on"]["target"] for f in found} == wrong
    for failure in found:
        assert failure["on"]["level"] == "O2"
        assert failure["on"]["compiler"] in failure["message"]
        assert failure["example"]["raws"] == {"x": 0}
        assert [d["what"] for d in failure["differences"]] == ["y"]


def test_a_shift_that_needs_32_bits_of_int_is_caught_on_avr(keeper: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The fault that people make: ``1 << 15`` and more in int. Undefined where int has 16 bits, right elsewhere."""
    text = keeper.with_suffix(".c").read_text(encoding="utf-8")
    start = text.index("\nkeeper_status_t keeper_hold(")
    end = text.index("return", start)
    mine = keeper.with_name("mine.c")
    change = "if ((((int)out->y + 32000) >> 8) < 100) { out->y = 7U; }\n    "
    mine.write_text(text[:end] + change + text[end:], encoding="utf-8")
    words = ["--target", "avr,cortex-m0plus,mips-be", "--levels", "Os", "--c", str(mine), "--only", "hold"]
    status, report = verified(capsys, str(keeper), *words)
    assert status == 1
    records = report["machines"]
    assert isinstance(records, list)
    assert {r["target"] for r in records if r["mismatches"]} == {"avr"}


def test_what_was_compiled_with_options_is_what_is_verified(keeper: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """--bounds, --optimize and --for reach the C that runs: on every machine it is the program of these options."""
    words = ["--target", "cortex-m4", "--levels", "O2", "--compiler", "zig", "--only", "hold"]
    for options in (["--optimize", "size", "--for", "avr"], ["--bounds", "thorough"]):
        status, report = verified(capsys, str(keeper), *words, *options)
        assert status == 0
        assert isinstance(report["machines"], list)
        assert [r["mismatches"] for r in report["machines"]] == [0]


def test_a_missing_tool_is_told_before_anything_runs(
    keeper: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit status 2 and how to get it; with ``all`` the machine is left out, and said to be."""
    monkeypatch.setattr("fuzzyspec.machines.machine.simavr_is_here", lambda: False)
    assert main(["verify", str(keeper), "--target", "avr", "--cases", "10"]) == 2
    assert "apt install simavr" in capsys.readouterr().err
    words = ["--target", "all", "--levels", "O2", "--compiler", "zig", "--only", "hold"]
    status, report = verified(capsys, str(keeper), *words)
    assert status == 0
    assert isinstance(report["notes"], list)
    assert any(note.startswith("not run on avr:") for note in report["notes"])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--levels", "O2"], "give --target too"),
        (["--target-cases", "5"], "give --target too"),
        (["--target", "z80"], "`z80` is none of"),
        (["--target", "host", "--levels", "O7"], "`O7` is none of"),
    ],
)
def test_wrong_words_end_with_2(keeper: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str) -> None:
    """A machine or a level that there is not, and options without what they are about."""
    with pytest.raises(SystemExit) as stopped:
        raise SystemExit(main(["verify", str(keeper), *words]))
    assert stopped.value.code == 2
    assert said in capsys.readouterr().err


def test_the_text_has_a_line_for_levels_that_came_out_alike(keeper: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Machine, compiler, levels, what ran it, cases, mismatches, self-test; the verdict counts machines."""
    words = ["--target", "wasm32", "--levels", "O2,Os", "--cases", "300", "--no-sanitize", "--only", "hold"]
    assert main(["verify", str(keeper), *words]) == 0
    out = capsys.readouterr().out
    (line,) = [line.split() for line in out.splitlines() if line.startswith("  wasm32")]
    assert line[-6:-4] == ["-O2", "-Os"]
    assert line[-4] == "wasmtime"
    assert line[-2:] == ["0", "passed"]
    assert "more on 1 machine" in out


def test_the_page_names_every_key_of_the_data(keeper: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """docs/verify.md tells of the whole report, that of a failure on a machine too."""
    page = (Path(__file__).resolve().parents[2] / "docs" / "verify.md").read_text(encoding="utf-8")
    mine = keeper.with_name("mine.c")
    text = keeper.with_suffix(".c").read_text(encoding="utf-8")
    start = text.index("\nkeeper_status_t keeper_hold(")
    end = text.index("return", start)
    mine.write_text(f"{text[:end]}out->y = 3U;\n    {text[end:]}", encoding="utf-8")
    words = ["--target", "wasm32", "--levels", "O2", "--c", str(mine), "--worst"]
    status, report = verified(capsys, str(keeper), *words)
    assert status == 1
    assert report["machines"]
    assert report["failures"]
    keys: set[str] = set()

    def look(value: object) -> None:
        if isinstance(value, dict):
            # What follows these is named by the spec.
            named = {"raws", "values", "state", "kinds"}
            keys.update(value)
            for key, inner in value.items():
                if key not in named:
                    look(inner)
        elif isinstance(value, list):
            for inner in value:
                look(inner)

    look(report)
    assert {key for key in keys if f"`{key}`" not in page} <= {"where", "kernel", "percent"}


def test_c_that_does_not_compile_for_a_machine_fails_there(keeper: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What one compiler rejects is a failure of that build, with what it said; the others run."""
    mine = keeper.with_name("mine.c")
    refused = '#if defined(__MIPSEB__)\n#error "not for me"\n#endif\n'
    mine.write_text(refused + keeper.with_suffix(".c").read_text(encoding="utf-8"), encoding="utf-8")
    words = ["--target", "mips-be,wasm32", "--levels", "O2", "--compiler", "zig", "--c", str(mine), "--only", "hold"]
    status, report = verified(capsys, str(keeper), *words)
    assert status == 1
    (failure,) = report["failures"]
    assert (failure["kind"], failure["on"]["target"]) == ("build", "mips-be")
    assert "not for me" in failure["output"]
    assert [(r["target"], r["left_out"]) for r in report["machines"]] == [
        ("mips-be", "the compiler rejected the C"),
        ("wasm32", None),
    ]


def test_what_does_not_fit_a_device_is_left_out_and_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A list of more than an ATmega328P's RAM: not run there, no failure, and the other function runs."""
    path = tmp_path / "long.fz"
    path.write_text(
        "module lengthy\n"
        "controller gain { input x in [0, 1] { partition S B } output y in [0, 1] { partition S B }\n"
        "  table y by x { S: S  B: B } }\n"
        "system most { input parts[200] { a in [0, 1], b in [0, 1], c in [0, 1] }\n"
        "  output y = max(p.a * p.b + p.c for p in parts, otherwise 0) }\n",
        encoding="utf-8",
    )
    status, report = verified(capsys, str(path), "--target", "avr", "--levels", "Os")
    assert status == 0
    (record,) = report["machines"]
    left_out = {f["function"]: f["left_out"] for f in record["functions"]}
    assert left_out == {"gain": None, "most": "a case of 1201 bytes does not fit its RAM"}
