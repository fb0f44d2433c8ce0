"""The examples of docs/language.md are specs: they parse, and whole ones compile to a model."""

from __future__ import annotations

import re

import pytest

from fuzzyspec.check import check, findings, sizes
from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.syntax import limits, parse, parser, tokens
from fuzzyspec.syntax.table import load
from tests.syntax.specs import ROOT

PAGE = (ROOT / "docs" / "language.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"^```fz ?(\w*)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)

FRAMES = {
    "": "{}",
    "top": "module m\n{}",
    "controller": "module m\ncontroller c {{\n{}}}\n",
    "terms": "module m\ncontroller c {{\ninput x in [0, 1] {{\n{}}}\n}}\n",
}


@pytest.mark.parametrize(("frame", "text"), EXAMPLES, ids=[f"{i}{f}" for i, (f, _) in enumerate(EXAMPLES)])
def test_an_example_is_a_spec(frame: str, text: str) -> None:
    """Every example parses; one that is whole has no findings at all."""
    source = Source("example.fz", FRAMES[frame].format(text))
    module, found = parse(source)
    assert found == ()
    if not frame:
        model, told = check(module, source)
        assert told == () and model is not None


def test_there_are_examples_of_every_kind() -> None:
    """The pattern that finds the examples finds them."""
    assert {frame for frame, _ in EXAMPLES} == set(FRAMES) and len(EXAMPLES) == PAGE.count("```fz")


def test_the_page_lists_every_keyword() -> None:
    """The list of keywords is the grammar's."""
    listed = PAGE[PAGE.index("The keywords are") :].split("\n\n")[0]
    assert set(re.findall(r"`(\w+)`", listed)) == set(load().keywords)


def test_the_page_states_the_limits() -> None:
    """The numbers in the table of limits are those of the code."""
    table = PAGE[PAGE.index("## Limits") :]
    texts = (limits.MAX_CHARACTERS, limits.MAX_NESTING, limits.MAX_DEPTH, tokens.MAX_DIGITS, parser.MAX_ERRORS)
    held = (sizes.MOST_VARIABLES, sizes.MOST_BEHAVIORS, sizes.MOST_CELL_RULES, sizes.MOST_SENTENCES, sizes.MOST_TERMS)
    for number in (*texts, *held, findings.MOST):
        assert f"| {number:,} |" in table
