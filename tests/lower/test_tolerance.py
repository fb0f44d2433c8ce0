"""An error that the user can live with lets controllers be of few bits, as far as it is certified."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import pytest

from fuzzyspec import load
from fuzzyspec.cli.main import main
from fuzzyspec.diagnostics.diagnostic import SpecError
from fuzzyspec.lower import Options
from fuzzyspec.lower.module import Lowered

ROOT = Path(__file__).resolve().parents[2]
W3 = ROOT / "benchmarks" / "w3.fz"


def largest(lowered: Lowered) -> Fraction:
    """The largest certified error, in percent of the range."""
    found = [o.percent_of_range for c in lowered.certificates.values() for o in c.outputs]
    return max(p for p in found if p is not None)


@pytest.mark.parametrize("percent", ["0.5", "0.1", "0.02"])
def test_what_is_certified_keeps_to_the_tolerance(percent: str) -> None:
    """Whatever precision is taken, every output is certified within what was asked for."""
    assert largest(load(W3).within(percent).lowered) <= Fraction(percent)


def test_few_bits_are_taken_where_they_do() -> None:
    """A wide tolerance gives another program than a narrow one, which is that of full precision."""
    full = load(W3).lowered.program
    assert load(W3).within("0.02").lowered.program == full
    assert load(W3).within("0.5").lowered.program != full


@pytest.mark.gate
def test_every_target_gets_the_same_integers(tmp_path: Path) -> None:
    """Which precision is taken does not depend on the target: one program's integers verify every C."""
    spec = load(W3).within("0.5")
    for target in ("avr", "cortex-m4"):
        files = spec.compile(Options(optimize="speed", target=target)).files
        assert b"tolerance 0.5 %" in files["w3.c"]
        for name, content in files.items():
            (tmp_path / name).write_bytes(content)
        assert spec.verify(c=tmp_path / "w3.c", cases=300, sanitize=False).ok


def test_systems_count_what_their_controllers_are_off() -> None:
    """nav's system is certified to 0.41 %: 0.45 % leaves its controllers' full precision, 2 % does not."""
    nav = load(ROOT / "examples" / "nav.fz")
    assert largest(nav.within("0.45").lowered) <= Fraction("0.45")
    assert largest(nav.within(2).lowered) > largest(nav.lowered)


def test_a_tolerance_that_nothing_keeps_to_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each output that is beyond is told of with what is certified, and nothing is written."""
    with pytest.raises(SpecError) as caught:
        load(W3).within("0.001").compile()
    assert [d.code for d in caught.value.diagnostics] == ["FZ452", "FZ452"]
    assert main(["compile", str(W3), "--tolerance", "0.001%", "-o", str(tmp_path / "out")]) == 1
    assert "within 0.001 %" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_eval_computes_what_the_c_of_that_tolerance_does(capsys: pytest.CaptureFixture[str]) -> None:
    """The integers are those of the spec within it, and differ from full precision somewhere."""
    spec = load(W3)
    inputs = {"lddc": 0.3, "fddc": 0.45, "rddc": 0.1, "theta": 31.0}
    given = [f"{name}={value}" for name, value in inputs.items()]
    found = []
    for percent in ("0.5", "0.02"):
        assert main(["eval", str(W3), *given, "--tolerance", percent, "--format", "json"]) == 0
        outputs = json.loads(capsys.readouterr().out)["outputs"]
        run = spec.within(percent).fixed("velocity", inputs)
        assert {k: o["raw"] for k, o in outputs.items()} == {k: int(v[0]) for k, v in run.raws.items()}
        found.append(outputs)
    assert found[0] != found[1]


def test_check_tells_what_no_program_keeps_to(capsys: pytest.CaptureFixture[str]) -> None:
    """A spec that is sound by itself is not within a tolerance that cannot be certified."""
    assert main(["check", str(W3), "--tolerance", "0.5"]) == 0
    assert main(["check", str(W3), "--tolerance", "0.001"]) == 1
    assert "FZ452" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["x", "0", "-1", "1e-3", "", "nan", "0.5 %"])
def test_what_is_no_percentage_is_wrong_usage(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Anything but a positive decimal is told of before the spec is read."""
    with pytest.raises(SystemExit) as ended:
        main(["compile", str(W3), f"--tolerance={text}"])
    assert ended.value.code == 2
    assert "no percentage" in capsys.readouterr().err
