"""``fuzzyc cost`` as typed."""

from __future__ import annotations

import importlib.util
import json
import shutil
import sys
from pathlib import Path

import pytest

from fuzzyspec.api import Spec
from fuzzyspec.cli.cost import TARGETS as OFFERED
from fuzzyspec.cli.main import main
from fuzzyspec.cost import TARGETS
from fuzzyspec.emit import Plan
from tests.cost.cost_specs import PLAIN, compiler_for, stand_in

FEW = ["--inputs", "20", "--opt", "O2"]


@pytest.fixture
def plain(tmp_path: Path) -> str:
    """A spec on disk."""
    path = tmp_path / "plain.fz"
    path.write_text(PLAIN, encoding="utf-8")
    return str(path)


def test_the_command_offers_every_target() -> None:
    """Its choices are written out, so that starting fuzzyc imports nothing."""
    assert tuple(TARGETS) == OFFERED


def test_text_has_a_table_a_function(plain: str, capsys: pytest.CaptureFixture[str]) -> None:
    """What was measured, and what the figures are not."""
    compiler_for("cortex-m0plus")
    assert main(["cost", plain, "--target", "cortex-m0plus", *FEW]) == 0
    out, err = capsys.readouterr()
    assert "20 inputs that were tried, which is no worst case" in out
    assert "cortex-m0plus  -O2" in out
    assert "bit for bit" in out
    assert err == ""


def test_json_has_a_record_for_target_option_and_function(plain: str, capsys: pytest.CaptureFixture[str]) -> None:
    """With null where nothing honest can be said."""
    compiler_for("cortex-m0plus")
    compiler_for("cortex-m4")
    options = ["--target", "cortex-m4", "--target", "cortex-m0plus", "--inputs", "20", "--format", "json"]
    assert main(["cost", plain, *options]) == 0
    data = json.loads(capsys.readouterr().out)
    assert (data["ok"], data["inputs"], data["seed"]) == (True, 20, 12345)
    assert [(r["target"], r["option"], r["function"]) for r in data["records"]] == [
        ("cortex-m4", "O2", "fan"),
        ("cortex-m4", "Os", "fan"),
        ("cortex-m0plus", "O2", "fan"),
        ("cortex-m0plus", "Os", "fan"),
    ]
    m4, _, m0, _ = data["records"]
    assert m4["cycles_mean"] is None
    assert m0["cycles_mean"] > m0["instructions_mean"] > 0
    assert m0["instructions_max"] >= m0["instructions_mean"]
    assert (m0["ram"], m0["matches"]) == (0, True)
    assert min(m0["flash"], m0["stack"]) > 0


def test_a_wrong_output_ends_with_1(
    plain: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The figures are shown, and so is the case that differs."""
    compiler_for("cortex-m0plus")
    monkeypatch.setattr(Spec, "compile", lambda *_: Plan(stand_in("out->z = 7U; return 0U;")))
    assert main(["cost", plain, "--target", "cortex-m0plus", *FEW]) == 1
    assert "NOT EQUAL: fan on cortex-m0plus -O2" in capsys.readouterr().out


def test_a_missing_compiler_ends_with_2_and_the_way_out(
    plain: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """For a target that was asked for, and where there is none for any."""
    monkeypatch.setattr(shutil, "which", lambda *_, **__: None)
    monkeypatch.setattr(importlib.util, "find_spec", lambda *_: None)
    assert main(["cost", plain, "--target", "cortex-m4"]) == 2
    assert "pip install 'fuzzyc[targets]'" in capsys.readouterr().err
    assert main(["cost", plain, "--target", "avr"]) == 2
    assert "apt install gcc-avr" in capsys.readouterr().err
    assert main(["cost", plain]) == 2
    assert "no compiler for any target" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["unicorn", "elftools.elf.elffile"])
def test_a_missing_package_ends_with_2_and_the_way_out(
    name: str, plain: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The compiler is there, the emulator or the reader of its output is not."""
    compiler_for("cortex-m0plus")
    monkeypatch.setitem(sys.modules, name, None)
    assert main(["cost", plain, "--target", "cortex-m0plus", *FEW]) == 2
    assert "pip install 'fuzzyc[targets]'" in capsys.readouterr().err


def test_zig_is_not_offered_for_avr(plain: str, capsys: pytest.CaptureFixture[str]) -> None:
    """It has no header for tables in flash."""
    assert main(["cost", plain, "--target", "avr", "--compiler", "zig"]) == 2
    assert "zig cannot build for avr" in capsys.readouterr().err


def test_a_function_that_is_not_there_is_wrong_usage(plain: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The names that would do are listed."""
    assert main(["cost", plain, "--only", "pump"]) == 2
    assert "it has fan" in capsys.readouterr().err
