"""Every code has a fixture that triggers it; sound files trigger nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzzyspec.check import check
from fuzzyspec.diagnostics.codes import REGISTRY
from fuzzyspec.diagnostics.diagnostic import Diagnostic
from fuzzyspec.syntax import parse, source_from_bytes
from tests.syntax.specs import FIXTURES, SOUND

BROKEN = sorted(FIXTURES.glob("fz*.fz"))
WITHOUT_FILE = {"FZ120", "FZ901"}
"""A file of a size that no repository needs (tested elsewhere), and our own bugs."""


def everything_found(path: Path) -> tuple[Diagnostic, ...]:
    """What reading, parsing and checking a file tell."""
    source, unread = source_from_bytes(path.name, path.read_bytes())
    module, found = parse(source)
    _, more = check(module, source, (*unread, *found))
    return (*unread, *found, *more)


@pytest.mark.parametrize("path", BROKEN, ids=lambda p: p.stem)
def test_a_fixture_triggers_the_code_in_its_name(path: Path) -> None:
    """The code that a file is named for is among its findings, with the severity that the registry gives."""
    code = path.name[:5].upper()
    severities = {d.severity for d in everything_found(path) if d.code == code}
    assert severities == {REGISTRY[code].severity}


@pytest.mark.parametrize("path", [p for p in BROKEN if p.name.startswith("fz1")], ids=lambda p: p.stem)
def test_one_slip_is_told_once(path: Path) -> None:
    """A syntax error does not draw others behind it, and the checker adds nothing: all findings share one code."""
    codes = {d.code for d in everything_found(path)}
    if "fz123" not in path.name:
        assert codes == {path.name[:5].upper()}


@pytest.mark.parametrize("path", SOUND, ids=lambda p: p.name)
def test_a_sound_file_has_no_findings(path: Path) -> None:
    """Files that are meant to be right have no errors."""
    assert [d for d in everything_found(path) if d.severity == "error"] == []


def test_every_code_has_a_fixture() -> None:
    """The registry and the fixtures tell of the same codes."""
    assert {p.name[:5].upper() for p in BROKEN} | WITHOUT_FILE >= {c for c in REGISTRY if c[2] in "19"}


@pytest.mark.parametrize("code", sorted(REGISTRY))
def test_a_code_has_a_page(code: str) -> None:
    """Each code is spelt FZ and three digits, has a short title, and a page that says more and fits a terminal."""
    entry = REGISTRY[code]
    assert code == entry.code and len(code) == 5 and code[2:].isdigit()
    assert 0 < len(entry.title) <= 72 and entry.title not in entry.page.splitlines()
    assert len(entry.page) > len(entry.title) and max(map(len, entry.page.splitlines())) <= 120
