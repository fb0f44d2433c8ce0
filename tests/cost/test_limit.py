"""The counted limit, against counting by hand and against what the generated C takes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from fuzzyspec import load
from fuzzyspec.cost.limit import limit
from fuzzyspec.model.controller import Controller
from scripts.limits import PAGE, SPECS, counted, prices, taken
from tests.cost.cost_specs import KEEPING, PLAIN, compiler_for

NEAR = 1.5
"""What the build for speed is expected within on a Cortex-M."""
FARTHER = {("w3", "cortex-m0plus"): 1.65}
"""Where it is not yet, and what it keeps to: take a spec out, or a number down, as passes get better."""


def controller(text: str, name: str) -> Controller:
    """One of a spec's controllers."""
    found = load(text).functions[name]
    assert isinstance(found, Controller)
    return found


def test_the_limit_of_two_inputs_of_two_terms_is_counted_by_hand() -> None:
    """On a Cortex-M4: one piece an input, parted at its middle, which is a short threshold as the ends are.

    x can pass its range at one end, y at both, each in one half. One block, of two end terms: two squares, area and
    moment, two cubes.
    """
    x = 1 + (1 + 1 / 2) * 2 + 4
    y = 1 + (1 + 2 / 2) * 2 + 4
    fired = 2 + 1
    centroid = 2 * 2 + (2 + 2) * 1 + 4 * 1 + 2 * 3
    assert limit(controller(PLAIN, "fan"), "cortex-m4") == 3 + x + y + fired + centroid + 6 + 2 + 1


def test_products_of_even_pieces_are_counted_by_hand() -> None:
    """On a Cortex-M4, 7 terms each: a raw counted from the low end tells by its sign that it was beyond it, and is
    compared with the length of the range, a short constant; a line, parted, and an addition to the cell. Then the
    weights, the corners of a table that has an address, and a line to raws."""
    (path,) = (p for p in SPECS if p.stem == "seven_singletons")
    each = 1 + 2 + 2 + 4 + 2 + 1
    assert counted(path, "cortex-m4") == 3 + 2 * each + 6 + 8 + 1 + 4 + 1


def test_sentence_rules_count_what_can_fire_in_a_block() -> None:
    """Five pieces, two of them sloped; a lone singleton is known, and none has company: a threshold for `otherwise`."""
    widths = (0.1, 0.25, 0.25, 0.35, 0.05)
    assert limit(controller(KEEPING, "hold"), "cortex-m7") == limit(controller(KEEPING, "hold"), "cortex-m4")
    found = {target: limit(controller(KEEPING, "hold"), target) for target in ("cortex-m0plus", "cortex-m4", "avr")}
    tests = 2.0 + widths[0] + widths[-1]
    assert 3 + 1 + tests * 2 + 0.6 * 4 + 3 + 1 < found["cortex-m4"] < 3 + 1 + (tests + 0.5) * 3 + 0.6 * 4 + 3 + 1 + 1
    assert found["cortex-m4"] <= found["cortex-m0plus"] < found["avr"]


def test_the_page_has_todays_prices_and_limits() -> None:
    """docs/limit.md, as `make limits` writes it; the measured halves of its ratios are held by the next test."""
    page = PAGE.read_text(encoding="utf-8")
    assert prices() in page
    for path in SPECS:
        (row,) = re.findall(rf"^\| \[{path.stem}\].*$", page, re.MULTILINE)
        told = [int(n.replace(",", "")) for n in re.findall(r"/ ([\d,]+) =", row)]
        assert told == [counted(path, core) for core in ("cortex-m0plus", "cortex-m4", "rv32imc", "avr")]


@pytest.mark.parametrize("target", ["cortex-m0plus", "cortex-m4"])
@pytest.mark.parametrize("path", SPECS, ids=lambda p: p.stem)
def test_the_build_for_speed_is_near_its_limit(path: Path, target: str) -> None:
    """Never below it, else it would be none; at most half as much again, or what is stated."""
    compiler_for(target, "gcc")
    ratio = taken(path, target) / counted(path, target)
    assert 1 <= ratio <= FARTHER.get((path.stem, target), NEAR)
