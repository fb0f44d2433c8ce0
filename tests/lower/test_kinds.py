"""Blocks of cells that share code, and inputs that are fuzzified zone by zone."""

from __future__ import annotations

import pytest

from fuzzyspec import load
from fuzzyspec.exact.rational import membership
from fuzzyspec.lower.choice import rules_of
from fuzzyspec.lower.controller import lower_controller
from fuzzyspec.lower.strategy import Strategy
from fuzzyspec.lower.zones import groups_of, zones_of
from fuzzyspec.model.controller import Controller
from tests.lower.test_strategies import same_integers

IRREGULAR = """
    input a in [0, 10] {
        term a0 = ramp_down(0.7, 1.9)  term a1 = triangle(0.3, 2.2, 3.1)  term a2 = trapezoid(1.7, 2.9, 4.4, 5.2)
        term a3 = triangle(3.7, 5.9, 8.3)  term a4 = points((6.1, 0), (7, 0.8), (8.8, 1))
    }
    input b in [0, 4] raw uint16 4095..0 { term b0 = triangle(-1, 0.5, 2.2)  term b1 = triangle(1, 2, 3.3) }
"""
STRONG = """
    input a in [-1, 2] { partition a0 a1 a2 a3 a4 }
    input b in [0, 1] raw int8 step 0.01 { partition b0 at 0, b1 at 0.3, b2 at 0.4, b3 at 0.6, b4 at 0.9, b5 at 1 }
"""
EVEN = "output z in [0, 6] { partition o0 o1 o2 o3 o4 o5 o6  otherwise 1 }"
UNEVEN = """output z in [0, 10] {
    term o0 = triangle(-1, 1, 3)  term o1 = triangle(2, 5, 6)  term o2 = trapezoid(4, 7, 8, 11)
    otherwise hold initial 3
}"""


def controller_of(inputs: str, output: str, terms: int, rows: list[int], columns: int) -> Controller:
    """A table of these rows whose consequents follow the sum of the indices; cells of other rows set nothing."""
    head = " ".join(f"b{j}" for j in range(columns))
    lines = [f"a{i}: " + " ".join(f"o{(i + j) % terms}" for j in range(columns)) for i in rows]
    table = "\n".join([f"table z by a, b {{ {head}", *lines, "}"])
    (controller,) = load(f"module m\ncontroller c {{ {inputs}\n{output}\n{table} }}").module.controllers
    return controller


@pytest.mark.parametrize("rows", [[0, 1, 2, 3, 4], [0, 1, 4], [2]], ids=["all", "holes", "one"])
@pytest.mark.parametrize(("output", "terms"), [(EVEN, 7), (UNEVEN, 3)], ids=["even", "uneven"])
@pytest.mark.parametrize(("inputs", "columns"), [(IRREGULAR, 2), (STRONG, 6)], ids=["irregular", "strong"])
def test_kinds_compute_what_loops_compute(inputs: str, columns: int, output: str, terms: int, rows: list[int]) -> None:
    """With any terms, even outputs or not, cells that set nothing, and outputs that hold: every raw of the inputs'
    types comes to the same integers."""
    controller = controller_of(inputs, output, terms, rows, columns)
    assert rules_of(controller)[-1] == "kinds"
    same_integers(controller, 3000)
    same_integers(controller, 3000, "short")


SENTENCES = """
    if a is a0 and b is b0 then z is o0
    if a is a1 or (b is b1 and not a is a2) then z is o1
    if (a is a3 or a is a4) and not (b is b0 or a is a4) then z is o2
    if not (a is a3 or b is b1) then z is o0
"""


def of_sentences(inputs: str, output: str, sentences: str, infer: str = "") -> Controller:
    """A controller of sentence rules."""
    text = f"module m\ncontroller c {{ {infer}\n{inputs}\n{output}\nrules {{ {sentences} }} }}"
    (controller,) = load(text).module.controllers
    return controller


@pytest.mark.parametrize("output", [EVEN, UNEVEN], ids=["even", "uneven"])
@pytest.mark.parametrize("inputs", [IRREGULAR, STRONG], ids=["irregular", "strong"])
def test_kinds_of_sentences_compute_what_loops_compute(inputs: str, output: str) -> None:
    """With not and or, strengths of 1 whatever the degrees are, and places where no rule can fire."""
    controller = of_sentences(inputs, output, SENTENCES)
    assert "kinds" in rules_of(controller)
    same_integers(controller, 3000)
    same_integers(controller, 3000, "short")


@pytest.mark.parametrize(
    ("sentences", "infer"),
    [
        ("if a is a0 and b is b0 then z is o0 with 0.5", ""),
        ("if a is a0 then z is o0", ""),
        ("if a is a0 and b is b0 then z is o0", "infer { and = product }"),
        ("if a is a0 or b is b0 then z is o0", "infer { or = probsum }"),
    ],
    ids=["weight", "an input that is not asked for", "product", "probsum"],
)
def test_other_sentences_stay_in_loops(sentences: str, infer: str) -> None:
    """What kinds do not compute, or would declare and never read."""
    assert "kinds" in rules_of(of_sentences(IRREGULAR, UNEVEN, "if a is a0 and b is b0 then z is o0"))
    assert "kinds" not in rules_of(of_sentences(IRREGULAR, UNEVEN, sentences, infer))


@pytest.mark.parametrize("which", [0, 1])
def test_zones_hold_all_raws_and_every_term_that_is_active(which: int) -> None:
    """Zones follow one another over all legal raws, and where a zone leaves a term out its membership is 0."""
    item = controller_of(IRREGULAR, UNEVEN, 3, [0], 2).inputs[which]
    raw, zones = item.variable.raw, zones_of(item)
    assert [z.start for z in zones] == [0, *(z.end + 1 for z in zones[:-1])]
    assert zones[-1].end == raw.hi - raw.lo
    assert sum(groups_of(item).values()) == raw.hi - raw.lo + 1
    for zone in zones:
        for at in {zone.start, (zone.start + zone.end) // 2, zone.end}:
            value = raw.origin + raw.step * (raw.lo + at if raw.step > 0 else raw.hi - at)
            active = {k for k, term in enumerate(item.terms) if membership(term.shape, value) > 0}
            assert active <= set(zone.terms)


def test_kinds_are_fewer_than_blocks() -> None:
    """Seven terms by the sum of the indices: 36 blocks of 7 kinds at most, and one table tells where they lie."""
    rows = "\n".join(f"a{i}: " + " ".join(f"o{max(0, min(6, i + j - 3))}" for j in range(7)) for i in range(7))
    names = {n: " ".join(f"{n}{k}" for k in range(7)) for n in "abo"}
    text = f"""module m
        controller c {{
            input a in [-1, 1] {{ partition {names["a"]} }}  input b in [-1, 1] {{ partition {names["b"]} }}
            output z in [0, 1] {{ partition {names["o"]} }}
            table z by a, b {{ {names["b"]}
                {rows} }}
        }}"""
    (controller,) = load(text).module.controllers
    function, _ = lower_controller(controller, Strategy("kinds"))
    tables = {t.name: t.values for t in function.tables}
    assert len(tables["kinds"]) == len(tables["z_places"]) == 36
    assert len(set(tables["kinds"])) == 7
