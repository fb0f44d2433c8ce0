"""Certificates: what they hold, that they can be checked again, and that what is not so in them is found."""

from __future__ import annotations

import copy
import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from fuzzyspec import load
from fuzzyspec.certify import certify, recheck
from fuzzyspec.cli.main import main
from fuzzyspec.diagnostics.refusal import Refusal
from fuzzyspec.verify.evidence import Asked, tool_hash

TIPPER = Path(__file__).resolve().parents[2] / "examples" / "tipper.fz"
ASKED = Asked(seed=1, cases=200, sanitize=False, targets=("host",), levels=("O0",), target_cases=500)


@pytest.fixture(scope="module")
def certificate() -> dict[str, Any]:
    """Of a short verification of the tipper, as it is read from its file."""
    report, found = certify(load(TIPPER), ASKED)
    assert report.ok
    return json.loads(json.dumps(found))  # type: ignore[no-any-return]


def test_a_certificate_says_what_of_and_how(certificate: dict[str, Any]) -> None:
    """It has the hashes of spec, C and tool, and a claim for the bits, the bound, and each machine."""
    spec = load(TIPPER)
    assert certificate["spec"]["sha256"] in spec.compile().files["tipper.h"].decode()
    assert certificate["tool"]["sha256"] == tool_hash()
    for name, content in spec.compile().files.items():
        assert certificate["c"][name] == {"sha256": hashlib.sha256(content).hexdigest()}
    bound = spec.certificate("tip").output("tip").error
    (derived,) = [c for c in certificate["shown"] if c["bound"] is not None]
    assert derived["bound"] == str(bound) and "every input" in derived["claim"]
    assert all(c["cases"] > 0 for c in certificate["shown"] if c["bound"] is None)
    assert any("for host" in c["claim"] for c in certificate["shown"])


def test_what_holds_is_found_to_hold(certificate: dict[str, Any]) -> None:
    """The same tool on the same machine shows every claim again, and has nothing to note."""
    assert recheck(certificate) == ([], [])


def _stronger(found: dict[str, Any]) -> None:
    claim = next(c for c in found["shown"] if c["bound"] is not None)
    claim["bound"] = f"{claim['bound']}0"  # a denominator of ten times as much


def _more_cases(found: dict[str, Any]) -> None:
    found["shown"][0]["cases"] += 1


def _more_machines(found: dict[str, Any]) -> None:
    found["shown"].append({**found["shown"][0], "claim": "built by gcc -O2 for pdp11 it returns the same"})


def _other_c(found: dict[str, Any]) -> None:
    found["c"]["tipper.c"]["sha256"] = "0" * 64


def _other_spec(found: dict[str, Any]) -> None:
    text = found["spec"]["text"].replace("in [0, 30] %", "in [0, 29] %")
    found["spec"] |= {"text": text, "sha256": hashlib.sha256(text.encode()).hexdigest()}


@pytest.mark.parametrize(
    ("alter", "said"),
    [
        (_stronger, "shown with the bound"),
        (_more_cases, "shown over fewer cases"),
        (_more_machines, "not shown again"),
        (_other_c, "tipper.c is not what was verified"),
        (_other_spec, "tipper.c is not what was verified"),
    ],
)
def test_what_is_not_so_is_found(
    certificate: dict[str, Any], alter: Callable[[dict[str, Any]], None], said: str
) -> None:
    """A claim stronger than what can be shown, or of another spec or C, does not pass."""
    altered = copy.deepcopy(certificate)
    alter(altered)
    broken, _ = recheck(altered)
    assert any(line.startswith(said) for line in broken), broken


def test_another_tool_is_noted(certificate: dict[str, Any]) -> None:
    """A certificate of another version of the compiler may hold; that it is one is told."""
    broken, notes = recheck({**certificate, "tool": {**certificate["tool"], "sha256": "0" * 64}})
    assert broken == [] and len(notes) == 1 and "another fuzzyc" in notes[0]


@pytest.mark.parametrize(
    ("place", "value", "said"),
    [
        (("certificate",), 0, "no certificate"),
        (("spec", "text"), "module m\n", "altered"),
        (("asked", "optimize"), "beauty", "altered"),
        (("asked", "cases"), -1, "altered"),
        (("asked", "tolerance"), "1/", "altered"),
        (("asked",), {}, "lacks"),
        (("spec",), 3, "lacks"),
    ],
)
def test_what_is_no_certificate_is_refused(
    certificate: dict[str, Any], place: tuple[str, ...], value: object, said: str
) -> None:
    """What is of another kind, incomplete or altered is refused in a sentence, whatever is wrong with it."""
    altered = copy.deepcopy(certificate)
    inner = altered
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    with pytest.raises(Refusal, match=said):
        recheck(altered)


def test_the_command_writes_and_rechecks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`--certificate` writes what `--recheck` passes; a spec or C named beside must be the one that it is of."""
    monkeypatch.chdir(tmp_path)
    short = ["--cases", "100", "--no-sanitize"]
    assert main(["compile", str(TIPPER), "-o", "c"]) == 0
    assert main(["verify", str(TIPPER), "--c", "c/tipper.c", "--certificate", "out.json", *short]) == 0
    assert main(["verify", "--recheck", "out.json", str(TIPPER), "--c", "c/tipper.c"]) == 0
    assert "holds" in capsys.readouterr().out
    Path("tipper.fz").write_text(TIPPER.read_text(encoding="utf-8") + "# more\n", encoding="utf-8")
    Path("c/tipper.c").write_text(Path("c/tipper.c").read_text(encoding="utf-8") + "\n", encoding="utf-8")
    assert main(["verify", "--recheck", "out.json", "tipper.fz", "--c", "c/tipper.c", "--format", "json"]) == 1
    said = json.loads(capsys.readouterr().out)
    assert said["broken"] == [
        "tipper.fz is not the spec that was verified",
        "c/tipper.c is not the C that was verified",
    ]


def test_every_input_is_told_of(tmp_path: Path) -> None:
    """Where every input is swept the certificate says so, with how many they are; a recheck sweeps them again."""
    spec = tmp_path / "small.fz"
    spec.write_text(
        "module small\ncontroller c {\n    input x in [0, 1] raw uint8 { partition A B }\n"
        "    output y in [0, 1] { partition S B }\n    table y by x { A: S  B: B }\n}\n",
        encoding="utf-8",
    )
    report, found = certify(load(spec), Asked(cases=10, sanitize=False, exhaustive=True))
    assert report.ok
    (every,) = [c for c in found["shown"] if "every input there is" in c["claim"]]
    assert every["cases"] >= 256
    assert recheck(found) == ([], [])


def test_nothing_is_certified_of_what_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A verification that fails writes no certificate and leaves an older one as it was."""
    monkeypatch.chdir(tmp_path)
    assert main(["compile", str(TIPPER), "-o", "."]) == 0
    text = Path("tipper.c").read_text(encoding="utf-8")
    wrong = text.replace("32768U", "32767U")
    assert wrong != text
    Path("tipper.c").write_text(wrong, encoding="utf-8")
    Path("out.json").write_text("old", encoding="utf-8")
    asked = ["--c", "tipper.c", "--cases", "100", "--no-sanitize"]
    assert main(["verify", str(TIPPER), "--certificate", "out.json", *asked]) == 1
    assert Path("out.json").read_text(encoding="utf-8") == "old"
