"""Every code about rules has a fixture that triggers it, at the right place."""

from __future__ import annotations

import pytest

from fuzzyspec.diagnostics import codes_rules
from fuzzyspec.diagnostics.codes import REGISTRY
from tests.check_rules.specs import FIXTURES, from_file, from_text

BROKEN = sorted(FIXTURES.glob("fz3*.fz"))


@pytest.mark.parametrize("path", BROKEN, ids=lambda path: path.stem)
def test_fixture_triggers_its_code_alone(path):
    """A fixture has one thing wrong with it, reported once, in the line that says so in a comment."""
    model, found, source = from_file(path)
    code = path.stem[:5].upper()
    (line,) = [n for n, text in enumerate(source.text.splitlines(), start=1) if "# here" in text]
    assert [(d.code, source.position(d.span.start)[0]) for d in found] == [(code, line)]
    assert found[0].severity == REGISTRY[code].severity
    assert (model is None) == (found[0].severity == "error")


@pytest.mark.parametrize("path", BROKEN, ids=lambda path: path.stem)
def test_fixture_has_help(path):
    """Whatever is reported about rules says a way out, and its spans lie in the text."""
    _, found, source = from_file(path)
    for diagnostic in found:
        assert diagnostic.help
        assert diagnostic.label
        for span in (diagnostic.span, *(label.span for label in diagnostic.labels)):
            assert 0 <= span.start < span.end <= len(source.text)


def test_every_code_about_rules_has_a_fixture():
    """No code is without an example that shows it."""
    assert {path.stem[:5].upper() for path in BROKEN} == {code.code for code in codes_rules.CODES}


def test_sound_rules_are_left_alone():
    """All the ways to write rules pass without a word."""
    model, found, _ = from_file(FIXTURES / "ok_rules.fz")
    assert found == ()
    assert model is not None


@pytest.mark.parametrize(
    ("lost", "told"), [("b is S", "1 cell"), ("b in {S, M}", "2 cells"), ("b is not S", "2 cells")]
)
def test_cells_that_are_lost_are_counted(lost, told):
    """A rule that never wins is told to which behavior it lost, and how many cells: one is not many."""
    text = (FIXTURES / "fz306_rule_never_wins.fz").read_text(encoding="utf-8").replace("b is S", lost)
    _, (found,) = from_text(text.removeprefix("module broken"))
    assert found.label == f"lost to STOP ({told})"
