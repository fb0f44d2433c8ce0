"""The grammar file, the table made from it, and lark's own reading of the language."""

from __future__ import annotations

from pathlib import Path

import pytest
from lark import Lark, LarkError

from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.resources import read_text
from fuzzyspec.syntax import build_crisp, build_fuzzy, generate, parse, table, tokens
from tests.syntax.specs import EVERYTHING, SOUND


@pytest.fixture(scope="module")
def lark() -> Lark:
    """The grammar as lark reads it, in strict mode."""
    return Lark(read_text("grammar", "fuzzy.lark"), parser="lalr", strict=True)


def test_the_grammar_is_lalr_without_conflicts(lark: Lark) -> None:
    """Lark's strict mode, which refuses conflicts that it else resolves silently, takes the grammar."""
    assert lark.options.strict and lark.options.parser == "lalr"


def test_strict_mode_would_notice() -> None:
    """A grammar with a conflict is refused, so that the test above can fail."""
    with pytest.raises(LarkError):
        Lark('start: a | b\na: "x"\nb: "x"', parser="lalr", strict=True)


def test_the_table_is_that_of_the_grammar() -> None:
    """``table.json`` is what ``python -m fuzzyspec.syntax.generate`` writes for today's grammar."""
    assert Path(tokens.__file__).with_name("table.json").read_text(encoding="utf-8") == generate.table_text()


@pytest.mark.parametrize("path", SOUND, ids=lambda p: p.name)
def test_lark_reads_what_we_read(lark: Lark, path: Path) -> None:
    """Sound files are sound to lark's own lexer and parser as well as to ours."""
    text = path.read_text(encoding="utf-8")
    lark.parse(text)
    assert parse(Source(path.name, text))[1] == ()


def test_every_construct_is_read_by_both(lark: Lark) -> None:
    """A spec with every construct of the language has no syntax error for either."""
    lark.parse(EVERYTHING)
    assert parse(Source("all.fz", EVERYTHING))[1] == ()


@pytest.mark.parametrize("extra", ["}", "let", "[", "1.5", "is", "x:", "=="])
def test_both_refuse_a_token_too_many(lark: Lark, extra: str) -> None:
    """What does not belong behind a spec is an error to both."""
    text = EVERYTHING + extra
    with pytest.raises(LarkError):
        lark.parse(text)
    assert parse(Source("all.fz", text))[1] != ()


def test_every_rule_has_a_builder() -> None:
    """What the table may ask to build can be built, and nothing else is kept."""
    actions = {action.action for state in table.load().states for _, action in state.values() if action is not None} - {
        "*",
        "^",
    }
    assert actions == set(build_fuzzy.BUILDERS) | set(build_crisp.BUILDERS)
