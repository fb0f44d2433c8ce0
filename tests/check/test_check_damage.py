"""Files with syntax errors: what is left of them is checked, and nothing that the damage may explain is reported."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyspec.check import check
from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.syntax import parse
from tests.check.checking import DANGER, checked, complaints, fuzzy, step

NAV = (Path(__file__).parents[2] / "examples" / "nav.fz").read_text()
WORDS = [
    m.span()
    for m in re.finditer(r"[A-Za-z_]\w*|\d+(?:\.\d+)?|[^\w\s]", re.sub(r"#[^\n]*", lambda m: " " * len(m[0]), NAV))
]
PLACES = st.integers(0, len(WORDS) - 1)


@settings(max_examples=150)
@given(PLACES, PLACES, st.integers(0, 3))
def test_no_edit_of_a_file_is_too_much(at: int, other: int, kind: int) -> None:
    """Words of nav.fz deleted, doubled, or exchanged for others: never a traceback, no model unless all is well."""
    (a, b), (c, d) = WORDS[at], WORDS[other]
    put = ["", NAV[a:b] * 2, NAV[c:d], "quux"][kind]
    source = Source("nav.fz", NAV[:a] + put + NAV[b:])
    tree, found = parse(source)
    model, more = check(tree, source, found)
    assert (model is None) == any(d.severity == "error" for d in (*found, *more))


@pytest.mark.parametrize(
    "text",
    [
        fuzzy().replace("[0, 4]", "[0 4]"),
        fuzzy().replace("NEAR: HIGH", "NEAR HIGH"),
        fuzzy().replace("table u by e", "table u e"),
        fuzzy("[0, 4] { partition NEAR FAR, }"),
        DANGER.replace("input", "inptu") + step("input x in [0, 1] m\noutput d = danger(gap: x).ddc", ""),
        DANGER.replace("controller danger", "controler danger") + step("output d = danger(gap: 3).ddc", ""),
        step("input x [0, 1] m\nlet r = danger(gap: x)\noutput d = r.ddc"),
        step("input l[4] { a in [0, 1] m b in [0, 2] m }\noutput d = max(o.b for o in l, otherwise 0)"),
        step("input x in [0, 1] m\nlet r = danger(gap: x))\noutput d = r.ddc"),
    ],
)
def test_a_syntax_error_stands_alone(text: str) -> None:
    """One slip in the syntax gives no other complaint than the parser's."""
    found = complaints(text)
    assert found and all(code.startswith("FZ1") for code, _ in found)


def test_the_rest_of_a_torn_file_is_checked() -> None:
    """Problems away from the syntax error are told in the same run."""
    text = fuzzy().replace("[0, 4]", "[0 4]") + step("input x in [3, 1] m\nlet r = danger(gap: 2 s)\noutput d = r.dcc")
    assert [c for c, _ in complaints(text)][-3:] == ["FZ401", "FZ220", "FZ203"]


def test_an_unknown_name_is_told_of_once() -> None:
    """The same unknown name in many places gives one diagnostic, which says so."""
    _, found, _ = checked(step("input x in [0, 1] m\noutput a = y + x\noutput b = y - x\noutput c = 2 * y"))
    (diagnostic,) = found
    assert diagnostic.notes == ("the same in 2 other places",)


def test_numbers_do_not_grow_without_end() -> None:
    """Squares of squares end in a diagnostic, or in intervals of bounded length, not in a run without end."""
    squares = "".join(f"let a{i + 1} = a{i} * a{i}\n" for i in range(40))
    grows = complaints(step("input x in [0, 4] m\nlet a0 = x / 1 m\n" + squares + "output y = a40"))
    assert [c for c, _ in grows] == ["FZ443"]
    shrinks = complaints(step("input x in [0, 1] m\nlet a0 = x / 3 m\n" + squares + "output y in [0, 1] = a40"))
    assert shrinks == []
