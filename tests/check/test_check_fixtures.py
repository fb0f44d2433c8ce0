"""Every code about names, units and numbers has a page and a fixture that triggers it, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzzyspec.check import check
from fuzzyspec.diagnostics.codes import REGISTRY
from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.syntax import parse

ROOT = Path(__file__).parents[2]
OURS = sorted(c for c in REGISTRY if "FZ200" <= c < "FZ300" or "FZ400" <= c < "FZ450")
FIXTURES = {
    p.name[:5].upper(): p for p in sorted((ROOT / "tests" / "fixtures").glob("fz*.fz")) if p.name[:5].upper() in OURS
}

MARKED = {
    "FZ201": "distnace", "FZ202": "dnager", "FZ203": "dcc", "FZ204": "metre", "FZ206": "traingle",
    "FZ207": "lukasiewicz", "FZ208": "uint32", "FZ209": "gpa", "FZ210": "limit", "FZ211": "default", "FZ212": "A",
    "FZ213": "distance_to_the_nearest_obstacle_on_the_left", "FZ214": "c", "FZ215": "gap", "FZ216": "distance",
    "FZ217": "clamp(distance, 3 m)", "FZ220": "speed", "FZ221": "degC/s", "FZ222": "0 rad", "FZ223": "distance",
    "FZ231": "c", "FZ232": "s", "FZ233": "e", "FZ234": "broken", "FZ240": "a", "FZ241": "rest", "FZ242": "rest",
    "FZ243": "obstacles.distance", "FZ244": "gap", "FZ245": "acting", "FZ246": "drive", "FZ247": "distance > 3 m",
    "FZ248": "distance", "FZ249": "danger", "FZ250": "danger", "FZ251": "min(o.distance for o in obstacles)",
    "FZ252": "mean", "FZ253": "3 m", "FZ260": "falsh", "FZ261": "cortex-m0", "FZ262": "us",
    "FZ263": "flash <= 2 KiB on avr", "FZ264": "cortex-m4", "FZ265": "<", "FZ444": "0",
    "FZ401": "[4, 0]", "FZ402": "uint16", "FZ403": "0", "FZ404": "raw uint16 7..7",
    "FZ405": "[0.2, 0.8]", "FZ406": "0", "FZ410": "term FAR = triangle(5, 6, 7)", "FZ411": "5", "FZ412": "FAR",
    "FZ413": "HIGH", "FZ414": "0, 3, 2", "FZ415": "2", "FZ416": "LOW", "FZ417": "partition NEAR", "FZ418": "e",
    "FZ419": "partition COLD HOT", "FZ420": "implies = product", "FZ421": "u", "FZ422": "2", "FZ423": "0",
    "FZ424": "otherwise 1", "FZ430": "x", "FZ431": "x", "FZ432": "distance / x", "FZ433": "0", "FZ434": "0",
    "FZ435": "3 m", "FZ442": "s", "FZ436": "load > 50", "FZ443": "4000000000000000000",
}  # fmt: skip
"""What each fixture's carets stand under."""


@pytest.mark.parametrize("code", OURS)
def test_a_fixture_triggers_its_code_alone(code: str) -> None:
    """One diagnostic, at its place, with the registered severity; unless it is an error, a model comes out."""
    source = Source(FIXTURES[code].name, FIXTURES[code].read_text())
    tree, found = parse(source)
    model, more = check(tree, source, found)
    (diagnostic,) = (*found, *more)
    assert diagnostic.code == code
    assert diagnostic.severity == REGISTRY[code].severity
    assert source.text[diagnostic.span.start : diagnostic.span.end] == MARKED[code]
    assert (model is None) == (diagnostic.severity == "error")
    assert all(0 <= at.span.start <= at.span.end <= len(source.text) for at in diagnostic.labels)


@pytest.mark.parametrize("code", OURS)
def test_a_page_says_what_and_how(code: str) -> None:
    """Each page is more than its title and fits a terminal."""
    page = REGISTRY[code].page
    assert len(page) > len(REGISTRY[code].title)
    assert max(map(len, page.splitlines())) <= 120


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.fz")) + sorted((ROOT / "benchmarks").glob("*.fz")))
def test_examples_and_benchmarks_are_sound(path: Path) -> None:
    """Not even a warning."""
    source = Source(path.name, path.read_text())
    tree, found = parse(source)
    model, more = check(tree, source, found)
    assert (found, more) == ((), ())
    assert model is not None


@pytest.mark.parametrize("name", ["stdint", "Math"])
def test_a_module_is_not_called_as_a_header_of_c(name: str) -> None:
    """Its own header would be read instead, on some file systems whatever the case."""
    controller = "input e in [0, 4] { partition A B } output u in [0, 1] { partition A B } table u by e { A: B  B: A }"
    source = Source("x.fz", f"module {name} controller c {{ {controller} }}")
    tree, found = parse(source)
    model, more = check(tree, source, found)
    assert model is None
    assert [(d.code, source.text[d.span.start : d.span.end]) for d in (*found, *more)] == [("FZ211", name)]
