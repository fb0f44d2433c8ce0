"""A slip in a keyword, whichever and wherever, is told of at that keyword."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from fuzzyspec.check import check
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source
from fuzzyspec.syntax import parse
from fuzzyspec.syntax.table import load

ROOT = Path(__file__).resolve().parents[2]
SOUND = [p for pattern in ("examples/*.fz", "tests/fixtures/ok_*.fz") for p in sorted(ROOT.glob(pattern))]
KEYWORDS = load().keywords


def errors(text: str) -> list[Diagnostic]:
    """Everything that is wrong with a text."""
    source = Source("spec.fz", text)
    tree, torn = parse(source)
    _, found = check(tree, source, torn)
    return [d for d in (*torn, *found) if d.severity == "error"]


def keywords(text: str) -> list[re.Match[str]]:
    """Where keywords stand, outside of comments."""
    blank = re.sub(r"#[^\n]*", lambda comment: " " * len(comment[0]), text)
    return [word for word in re.finditer(r"\b[a-z]+\b", blank) if word[0] in KEYWORDS]


@pytest.mark.parametrize("path", SOUND, ids=lambda path: path.name)
def test_a_misspelt_keyword_is_the_only_thing_told_of(path: Path) -> None:
    """With two letters in the wrong order, each keyword is the one diagnostic, at its place.

    Where a keyword's text is a name (a setting, a controller that is called so), the name is what is unknown.
    """
    text = path.read_text(encoding="utf-8")
    for word in keywords(text):
        slip = word[0][:-2] + word[0][-1] + word[0][-2]
        if slip == word[0]:
            continue
        (found,) = errors(text[: word.start()] + slip + text[word.end() :])
        if found.code not in ("FZ202", "FZ207"):
            assert (found.code, found.span.start) == ("FZ102", word.start()), (word, found)


@pytest.mark.parametrize("path", SOUND, ids=lambda path: path.name)
def test_keywords_in_capitals_are_one_habit(path: Path) -> None:
    """A file that shouts its keywords hears it once, with their number."""
    text = path.read_text(encoding="utf-8")
    shouted = text
    for word in keywords(text):
        if word[0] != "points":
            shouted = shouted[: word.start()] + word[0].upper() + shouted[word.end() :]
    told = [d for d in errors(shouted) if d.code == "FZ102"]
    assert len(told) == 1 and "more keywords in capitals" in told[0].notes[0]
