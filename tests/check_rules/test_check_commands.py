"""`fuzzyc check` and `fuzzyc explain` from the outside: what they print where, and their exit status."""

from __future__ import annotations

import json

import pytest

from fuzzyspec.cli.main import main
from fuzzyspec.diagnostics.codes import REGISTRY
from tests.check_rules.specs import EXAMPLES, FIXTURES

NAV = str(EXAMPLES / "nav.fz")


def test_check_reports_on_standard_output(capsys):
    """A sound spec has its report on standard output, nothing on standard error, and status 0."""
    assert main(["check", NAV]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("module nav\n")
    assert "32 to FO" in out
    assert err == ""


def test_check_complains_on_standard_error(capsys):
    """A broken spec has its diagnostics on standard error, no report, and status 1."""
    assert main(["check", str(FIXTURES / "fz303_rules_disagree.fz")]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert "error[FZ303]" in err


def test_check_of_several_files_fails_if_one_does(capsys):
    """Every file is looked at, as data too; one broken file makes the status 1."""
    files = [NAV, str(FIXTURES / "fz301_unclaimed_cells.fz"), str(FIXTURES / "fz306_rule_never_wins.fz")]
    assert main(["check", "--format", "json", *files]) == 1
    data = json.loads(capsys.readouterr().out)
    assert [f["ok"] for f in data["files"]] == [True, False, True]
    assert [[d["code"] for d in f["diagnostics"]] for f in data["files"]] == [[], ["FZ301"], ["FZ306"]]
    assert data["files"][1]["report"] is None
    assert data["files"][0]["report"]["controllers"][1]["cells"]["claimed"] == 81


def test_check_of_a_missing_file_is_misuse(capsys):
    """A file that is not there gives one line and status 2."""
    assert main(["check", "no_such.fz"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("code", sorted(REGISTRY))
def test_every_code_is_explained(code, capsys):
    """`fuzzyc explain` prints each code's page, whatever its case."""
    assert main(["explain", code.lower()]) == 0
    out = capsys.readouterr().out
    assert out.startswith(f"{REGISTRY[code].severity}[{code}]: ")
    assert REGISTRY[code].page.strip() in out


def test_explain_of_an_unknown_code_is_misuse(capsys):
    """A code that there is not names those near it."""
    assert main(["explain", "FZ399"]) == 2
    assert "FZ301" in capsys.readouterr().err


def test_explain_tells_which_cells_fire(capsys):
    """At the middle of an edge of the danger table, four cells fire, and the output is exact."""
    assert main(["explain", NAV, "--controller", "danger", "eta_t=1.5", "eta_d=1", "--format", "json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["inputs"][0]["degrees"] == {"TS": 0.5, "TM": 0.5, "TB": 0.0}
    assert [f["strength"] for f in data["firings"]] == [0.5] * 4
    assert {f["sets"]["ddc"] for f in data["firings"]} == {"B", "M"}
    assert data["outputs"] == [{"name": "ddc", "value": 0.75, "unit": "", "fires": True}]


def test_explain_names_the_acting_behavior(capsys):
    """With the target ahead and big danger there, FO acts, and values may carry units."""
    assert main(["explain", NAV, "left=0", "front=1", "right=0", "target=0deg", "--controller", "velocity"]) == 0
    out = capsys.readouterr().out
    assert "FO  left is S and front is B and right is S and target is C  -> v is VS, w is NB" in out
    assert "acting = FO" in out


def test_explain_saturates_and_says_so(capsys):
    """An input beyond its range counts as the range's end."""
    assert main(["explain", str(EXAMPLES / "temperature.fz"), "error=300", "rate=-0.2"]) == 0
    out = capsys.readouterr().out
    assert "saturated from 300 K" in out
    assert "if error is hot and rate is not falling then duty is high" in out


def test_explain_tells_when_nothing_fires(capsys):
    """At the set point the fan holds."""
    assert main(["explain", str(EXAMPLES / "temperature.fz"), "error=0", "rate=0"]) == 0
    assert "nothing reaches 1/8: its first value is held" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([NAV, "eta_t=1"], "several controllers"),
        ([NAV, "--controller", "dangr"], "did you mean `danger`"),
        ([NAV, "--controller", "danger", "eta_t=1"], "no value for eta_d"),
        ([NAV, "--controller", "danger", "eta_t=1", "eta=2"], "did you mean"),
        ([NAV, "--controller", "danger", "eta_t=1", "eta_t=2"], "twice"),
        ([NAV, "--controller", "danger", "eta_t"], "no name=value"),
        ([NAV, "--controller", "danger", "eta_t=1", "eta_d=2 m"], "m"),
        (["FZ301", "eta_t=1"], "takes no values"),
        (["nope"], "neither a diagnostic code nor a file"),
    ],
)
def test_explain_refuses_what_it_cannot_mean(arguments, words, capsys):
    """Wrong usage is one line with a way out, and status 2."""
    assert main(["explain", *arguments]) == 2
    err = capsys.readouterr().err
    assert words in err
    assert err.count("\n") == 1


def test_explain_of_a_broken_spec_shows_its_errors(capsys):
    """Status 1 and the diagnostics, as everywhere."""
    assert main(["explain", str(FIXTURES / "fz303_rules_disagree.fz"), "a=0", "b=0"]) == 1
    assert "error[FZ303]" in capsys.readouterr().err
