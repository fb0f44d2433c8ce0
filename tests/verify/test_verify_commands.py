"""``fuzzyc verify`` and ``fuzzyc eval`` as typed: output, exit status, complaints."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fuzzyspec import api
from fuzzyspec.cli.main import main
from fuzzyspec.emit import write
from fuzzyspec.lower import Options
from tests.verify import verify_specs

FEW = ["--cases", "500"]


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A spec on disk, in a folder with a space in its name, and its C beside it, of loops and tables."""
    folder = tmp_path / "my specs"
    folder.mkdir()
    path = folder / "small.fz"
    path.write_text(verify_specs.DANGER, encoding="utf-8")
    write(api.load(path).compile(Options(optimize="size", target="avr")), folder)
    return path


def test_verify_prints_a_table_and_ends_with_0(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Cases, mismatches, largest error and certified bound of every output; nothing on standard error."""
    assert main(["verify", str(small), *FEW]) == 0
    out, err = capsys.readouterr()
    assert "certified bound" in out
    assert "small: verified" in out
    assert "seed 20240229" in out
    assert err == ""


def test_verify_shows_where_errors_are_largest(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With --worst, an input for each output."""
    assert main(["verify", str(small), *FEW, "--no-sanitize", "--worst"]) == 0
    lines = capsys.readouterr().out.splitlines()
    at = lines.index("  largest error of ddc at")
    assert [line.split()[0] for line in lines[at + 1 : at + 3]] == ["near", "gap"]


def test_verify_gives_json(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The report as data, with the seed that was asked for."""
    assert main(["verify", str(small), *FEW, "--seed", "7", "--no-sanitize", "--format", "json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert (data["ok"], data["seed"], data["sanitizers"]) == (True, 7, [])
    assert data["notes"] == ["the sanitizers were not asked for"]


def test_verify_takes_the_users_c(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The file itself passes; with a changed table it fails with 1 and shows an input."""
    mine = small.with_name("small.c")
    assert main(["verify", str(small), *FEW, "--c", str(mine)]) == 0
    source = mine.read_text(encoding="utf-8")
    at = source.index("2U", source.index("_rules[9]"))
    mine.write_text(source[:at] + "0U" + source[at + 2 :], encoding="utf-8")
    capsys.readouterr()
    assert main(["verify", str(small), *FEW, "--c", str(mine)]) == 1
    out = capsys.readouterr().out
    assert "small: NOT verified" in out
    assert "smallest input found" in out
    assert "(raw " in out


def test_a_header_of_another_spec_is_told(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The header beside the C is what it is compiled with: one that does not belong stops the build."""
    header = small.with_name("small.h")
    text = header.read_text(encoding="utf-8")
    at = text.index("0x", text.index("SPEC_DIGEST"))
    header.write_text(text[:at] + "0x00000001U" + text[text.index("\n", at) :], encoding="utf-8")
    assert main(["verify", str(small), *FEW, "--c", str(small.with_name("small.c"))]) == 1
    assert "#error" in capsys.readouterr().out


def test_verify_replays_a_scenario(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Recorded rows, and a complaint with exit status 2 about a recording that cannot be read."""
    log = small.with_name("log.csv")
    log.write_text("near,gap\n1.5,0.2\n7,1\n", encoding="utf-8")
    assert main(["verify", str(small), "--scenario", str(log)]) == 0
    assert "controller danger: 2 cases" in capsys.readouterr().out
    log.write_text("near,gap\n1.5,x\n", encoding="utf-8")
    assert main(["verify", str(small), "--scenario", str(log)]) == 2
    assert "log.csv:2: gap: `x` is no number" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--only", "nobody"], "no controller or system `nobody`"),
        (["--raw"], "--raw says how to read a scenario"),
        (["--c", "nothing.c"], "nothing.c"),
    ],
)
def test_wrong_usage_ends_with_2(
    arguments: list[str], message: str, small: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line says what is wrong."""
    assert main(["verify", str(small), *arguments]) == 2
    assert message in capsys.readouterr().err


def test_no_compiler_ends_with_2(
    small: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A missing compiler is a missing tool, and the line says how to get one."""
    monkeypatch.setenv("CC", "no-such-compiler")
    assert main(["verify", str(small)]) == 2
    assert "CC names `no-such-compiler`" in capsys.readouterr().err


def test_a_broken_spec_ends_with_1(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Diagnostics, as from every command."""
    small.write_text("module small\ncontroller c {\n", encoding="utf-8")
    assert main(["verify", str(small)]) == 1
    assert "FZ1" in capsys.readouterr().err


# --- eval ------------------------------------------------------------------------------------------


@pytest.fixture
def keeper(tmp_path: Path) -> Path:
    """A system with a list."""
    path = tmp_path / "keeper.fz"
    path.write_text(verify_specs.HOLDING, encoding="utf-8")
    return path


def test_eval_shows_both_meanings(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The inputs as understood, exact and fixed values, the raw, the status."""
    assert main(["eval", str(small), "near=1.5", "gap=20cm"]) == 0
    out = capsys.readouterr().out
    assert "gap = 0.200012 m (raw 3277)" in out
    row = next(line.split() for line in out.splitlines() if line.startswith("ddc"))
    bound = api.load(small).certificate("danger").output("ddc").error
    assert bound is not None
    assert float(row[1]) == pytest.approx(float(row[2]), abs=float(bound))
    assert out.endswith("status: OK\n")


def test_eval_takes_lists_and_gives_json(keeper: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Elements by index; the only system is what is evaluated; saturation is told."""
    values = ["x=-3", "parts.0.size=100 cm", "parts.0.kind=5", "parts.1.size=1.5", "parts.1.kind=1"]
    assert main(["eval", str(keeper), *values, "--format", "json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["function"] == "both"
    assert data["inputs"]["parts.count"] == 2
    assert data["inputs"]["parts.size"][0] == {"value": 1.0, "raw": 16384, "unit": "m"}
    assert data["outputs"]["big"]["exact"] == 1.0
    assert data["outputs"]["some"]["exact"] == 2.5
    assert data["outputs"]["many"]["fixed"] == 1.0
    assert data["status"] == ["SATURATED_X"]


def test_eval_takes_a_controller(keeper: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By name, although there is a system."""
    assert main(["eval", str(keeper), "--controller", "hold", "x=1"]) == 0
    assert "5 V" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["x"], "`x` is no NAME=VALUE"),
        (["y=1"], "both has no input `y`; it takes x, parts.0.size, parts.0.kind"),
        (["x=1", "x=2"], "`x` is given twice"),
        ([], "`x` is missing"),
        (["x=one"], "x: `one` is no number"),
        (["x=1 m"], "x is not measured in m"),
        (["x=1", "parts.0.size=1 furlong", "parts.0.kind=1"], "parts.0.size: unknown unit `furlong`"),
        (["x=1", "parts.0.size=1"], "`parts.0.kind` is missing"),
        (["x=1", "parts.1.size=1", "parts.1.kind=1"], "`parts.0.size` is missing"),
        (["x=1", "parts.size=1"], "both has no input `parts.size`"),
        (["--controller", "both", "x=1"], "keeper has no controller `both`; it has hold"),
    ],
)
def test_eval_complains_in_one_line(
    arguments: list[str], message: str, keeper: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit status 2, and what to write instead."""
    assert main(["eval", str(keeper), *arguments]) == 2
    assert message in capsys.readouterr().err
