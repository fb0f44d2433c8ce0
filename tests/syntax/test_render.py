"""Diagnostics as text and as data."""

from __future__ import annotations

import re

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Source, Span
from fuzzyspec.diagnostics.render import as_json, render

TEXT = """\
module nav

controller danger {
\tinput  größe in [0, 6]  { partition TS TM TB }
    output 速度 in [0, 1]   { partition S M B full }
    table ddc by a {
        S: B
    }
}
"""
SOURCE = Source("nav.fz", TEXT)


def at(piece: str, nth: int = 0) -> Span:
    """Where a piece of the text stands."""
    start = -1
    for _ in range(nth + 1):
        start = TEXT.index(piece, start + 1)
    return Span(start, start + len(piece))


def test_a_diagnostic_looks_like_this() -> None:
    """Code, message, place, line, carets, other places, point, help and notes, each where rustc has it."""
    found = Diagnostic(
        "FZ210",
        "output `ddc` is declared twice",
        at("ddc"),
        "declared again here",
        (Label(at("danger"), "in this controller"),),
        "choose another name",
        ("names are compared\nby their letters",),
        point={"a": "3 m", "b": "0.5"},
    )
    assert render([found], SOURCE) == (
        "error[FZ210]: output `ddc` is declared twice\n"
        " --> nav.fz:6:11\n"
        "  |\n"
        "3 | controller danger {\n"
        "  |            ------ in this controller\n"
        "...\n"
        "6 |     table ddc by a {\n"
        "  |           ^^^ declared again here\n"
        "  = at: a = 3 m, b = 0.5\n"
        "  = help: choose another name\n"
        "  = note: names are compared\n"
        "          by their letters\n"
        "\n"
        "1 error; `fuzzyc explain FZ210` says more"
    )


def carets(found: Diagnostic) -> list[str]:
    """The rows of an excerpt behind the gutter, source lines and underlines alike."""
    rows = render([found], SOURCE).splitlines()
    return [row.partition("| ")[2] for row in rows if "|" in row]


def test_carets_line_up_under_tabs_and_wide_characters() -> None:
    """A tab takes four columns and an ideograph two, so carets stand under their text in a terminal."""
    _, line, marks = carets(Diagnostic("FZ101", "m", at("TM")))
    assert line.index("TM") == marks.index("^^") == 4 + len("input  größe in [0, 6]  { partition TS ")
    _, line, marks = carets(Diagnostic("FZ101", "m", at("速度")))
    assert marks == " " * line.index("速") + "^^^^"
    _, line, marks = carets(Diagnostic("FZ101", "m", at("full")))
    assert marks.index("^") == line.index("full") + 2


def test_two_labels_of_a_line_hang_below_one_another() -> None:
    """The rightmost text stands beside its mark, the others below theirs."""
    found = Diagnostic("FZ101", "m", at("TS"), "one", (Label(at("TM"), "two"), Label(at("TB"), "three")))
    _, line, first, bar, second, last, third = carets(found)
    column = line.index("TS")
    assert first == " " * column + "^^ -- -- three"
    assert bar == " " * column + "|  |" and second == " " * column + "|  two"
    assert last == " " * column + "|" and third == " " * column + "one"


def test_overlapping_labels_have_rows_of_their_own() -> None:
    """A mark within another is drawn in a row of its own."""
    found = Diagnostic("FZ101", "m", at("partition TS TM TB"), "all", (Label(at("TM"), "part"),))
    _, line, first, second = carets(found)
    assert first.strip() == "^" * len("partition TS TM TB") + " all"
    assert second == " " * line.index("TM") + "-- part"


def test_a_span_of_many_lines_shows_its_first() -> None:
    """A block is marked on the line where it begins, and the text says where it ends."""
    found = Diagnostic("FZ101", "m", Span(at("table").start, at("}", 2).end), "this block")
    _, line, marks = carets(found)
    assert line.strip() == "table ddc by a {"
    assert marks.strip() == "^" * len("table ddc by a {") + " this block (to line 8)"


def test_places_without_extent_are_shown() -> None:
    """The end of a file, of a line, and of an empty file can be pointed at."""
    for source, offset in ((SOURCE, len(TEXT)), (SOURCE, TEXT.index("\n")), (Source("e.fz", ""), 0)):
        assert "^" in render([Diagnostic("FZ104", "m", Span(offset, offset))], source)


def test_long_lines_are_cut_around_the_mark() -> None:
    """A line of thousands of characters is shown in part, the carets still under their text."""
    source = Source("long.fz", "a " * 2000 + "here " + "b " * 2000)
    start = source.text.index("here")
    rows = render([Diagnostic("FZ101", "m", Span(start, start + 4), "this")], source).splitlines()
    line, marks = rows[3], rows[4]
    assert len(line) < 160 and line.index("here") == marks.index("^^^^")


def test_findings_stand_in_the_order_of_the_text() -> None:
    """Diagnostics are sorted by place and counted by severity; the same one twice is shown once."""
    late = Diagnostic("FZ101", "late", at("full"))
    early = Diagnostic("FZ301", "early", at("danger"), severity="warning")
    text = render([late, early, late], SOURCE)
    assert re.findall(r"^(\w+)\[", text, re.MULTILINE) == ["warning", "error"]
    assert text.endswith("\n1 error, 1 warning; `fuzzyc explain FZ101` says more")
    assert render([], SOURCE) == ""


def test_colour_adds_nothing_but_colour() -> None:
    """Without its escape sequences the coloured text is the plain one."""
    found = Diagnostic("FZ101", "m", at("TS"), "one", (Label(at("TM"), "two"),), "help", ("note",))
    colored = render([found], SOURCE, color=True)
    assert "\x1b[1;31m" in colored
    assert re.sub(r"\x1b\[[0-9;]*m", "", colored) == render([found], SOURCE)


def test_data_says_the_same() -> None:
    """JSON has code, words and places: lines and columns from 1, offsets from 0."""
    found = Diagnostic(
        "FZ210", "m", at("ddc"), "here", (Label(at("danger"), "there"),), "help", ("note",), point={"a": "1"}
    )
    (data,) = as_json([found], SOURCE)
    start = TEXT.index("ddc")
    assert data == {
        "code": "FZ210",
        "severity": "error",
        "message": "m",
        "file": "nav.fz",
        "start": {"line": 6, "column": 11, "offset": start},
        "end": {"line": 6, "column": 14, "offset": start + 3},
        "label": "here",
        "labels": [
            {
                "start": {"line": 3, "column": 12, "offset": at("danger").start},
                "end": {"line": 3, "column": 18, "offset": at("danger").end},
                "text": "there",
            }
        ],
        "help": "help",
        "notes": ["note"],
        "point": {"a": "1"},
    }
