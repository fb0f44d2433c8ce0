"""nav.fz says what the paper's printed rules say, counted and computed anew from them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from itertools import product
from pathlib import Path

import pytest

from firmware_sim.parameters import PERIOD, Parameters
from fuzzyspec.check import check
from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.model.controller import Controller
from fuzzyspec.model.system import Module
from fuzzyspec.syntax import parse, tree

NAV = Path(__file__).parents[2] / "examples" / "nav.fz"
MB = {"M", "B"}
LEFT_TURNS, RIGHT_TURNS = {"NS", "NM", "NB"}, {"PS", "PM", "PB"}


@pytest.fixture(scope="module")
def nav() -> tuple[tree.Module, Module]:
    """The example as a tree and as a checked model."""
    source = Source("nav.fz", NAV.read_text(encoding="utf-8"))
    parsed, found = parse(source)
    module, found = check(parsed, source, found)
    assert module is not None, [d.message for d in found]
    return parsed, module


@pytest.fixture(scope="module")
def velocity(nav: tuple[tree.Module, Module]) -> Controller:
    """The second layer."""
    return next(c for c in nav[1].controllers if c.name == "velocity")


Cell = tuple[str, ...]


def cells(velocity: Controller) -> Iterator[tuple[int, Cell]]:
    """Flat index and the names of left's, front's, right's and target's terms."""
    assert [i.name for i in velocity.inputs] == ["left", "front", "right", "target"]
    names = [[t.name for t in i.terms] for i in velocity.inputs]
    yield from enumerate(product(*names))


def started(cell: Cell) -> list[str]:
    """The behaviors whose printed conditions (Rules 1.1 to 1.3) a cell meets, highest priority first."""
    left, front, right, target = cell
    fo = {"C": front, "L": left, "R": right}[target] in MB
    ao = (target == "C" and left in MB and right in MB) or (target != "C" and front in MB)
    mg = front == "S"
    return [name for name, starts in (("FO", fo), ("AO", ao), ("MG", mg)) if starts]


def test_danger_is_table_1(nav: tuple[tree.Module, Module]) -> None:
    """The danger layer holds Table 1, read as printed."""
    danger = next(c for c in nav[1].controllers if c.name == "danger")
    printed = {"DS": "B B B", "DM": "B M M", "DB": "B M S"}
    assert danger.cells is not None
    assert [i.name for i in danger.inputs] == ["eta_t", "eta_d"]
    for flat, (t, d) in enumerate(product(("TS", "TM", "TB"), ("DS", "DM", "DB"))):
        term = danger.outputs[0].terms[danger.cells.consequents[0][flat]].name
        assert term == printed[d].split()[("TS", "TM", "TB").index(t)], (t, d)


def test_every_cell_goes_to_the_behavior_that_the_paper_starts(velocity: Controller) -> None:
    """Each of the 81 cells is owned by the highest priority that Rules 1.1 to 1.3 start there."""
    assert velocity.cells is not None
    names = {b.code: b.name for b in velocity.behaviors}
    won = {cell: names[velocity.cells.owner[flat]] for flat, cell in cells(velocity)}
    assert won == {cell: started(cell)[0] for cell in won}
    assert Counter(won.values()) == {"FO": 54, "AO": 16, "MG": 11}


def claims(nav: tuple[tree.Module, Module], behavior: str) -> Counter[Cell]:
    """How many rules of a behavior, as written, claim each cell."""
    velocity = next(d for d in nav[0].items if isinstance(d, tree.ControllerDecl) and d.name.text == "velocity")
    block = next(b for b in velocity.items if isinstance(b, tree.BehaviorDecl) and b.name.text == behavior)
    counted: Counter[Cell] = Counter()
    for rule in block.rules:
        assert {c.output.text for c in rule.consequents} == {"v", "w"}
        asked = {"left": set("SMB"), "front": set("SMB"), "right": set("SMB"), "target": set("LCR")}
        condition = rule.condition
        parts = condition.operands if isinstance(condition, tree.Antecedent) else (condition,)
        for part in parts:
            assert isinstance(part, tree.Is)
            asked[part.variable.text] &= {t.text for t in part.terms}
        counted.update(product(*asked.values()))
    return counted


@pytest.mark.parametrize(("behavior", "count"), [("FO", 54), ("AO", 48), ("MG", 27)])
def test_behaviors_start_where_the_paper_starts_them(
    nav: tuple[tree.Module, Module], velocity: Controller, behavior: str, count: int
) -> None:
    """A behavior's rules claim exactly the cells of its printed conditions, those it then loses included, each once."""
    claimed = claims(nav, behavior)
    assert claimed == Counter(cell for _, cell in cells(velocity) if behavior in started(cell))
    assert claimed.total() == count


def test_speed_rules(velocity: Controller) -> None:
    """Rule 3: FO takes v from {S, VS}, AO from {S, VS, Z}, MG from {VF, F}."""
    allowed = {"FO": {"S", "VS"}, "AO": {"S", "VS", "Z"}, "MG": {"VF", "F"}}
    assert velocity.cells is not None
    v = [o.name for o in velocity.outputs].index("v")
    for flat, cell in cells(velocity):
        term = velocity.outputs[v].terms[velocity.cells.consequents[v][flat]].name
        assert term in allowed[started(cell)[0]], cell


def test_steering_rules(velocity: Controller) -> None:
    """Rule 2, cell by cell: which way each behavior turns."""
    assert velocity.cells is not None
    w = [o.name for o in velocity.outputs].index("w")
    for flat, cell in cells(velocity):
        term = velocity.outputs[w].terms[velocity.cells.consequents[w][flat]].name
        towards = {"L": LEFT_TURNS, "C": {"Z"}, "R": RIGHT_TURNS}[cell[3]]
        away = {"L": RIGHT_TURNS, "C": LEFT_TURNS, "R": LEFT_TURNS}[cell[3]]
        assert term in (away if started(cell)[0] == "FO" else towards), cell


def test_more_danger_turns_no_less_and_drives_no_faster(velocity: Controller) -> None:
    """Within what a behavior executes, raising one danger never softens the turn and never raises the speed."""
    assert velocity.cells is not None
    speeds, turns = ("Z", "VS", "S", "F", "VF"), ("Z", "NS", "NM", "NB", "PS", "PM", "PB")
    table: dict[Cell, tuple[int, int]] = {}
    for flat, cell in cells(velocity):
        v, w = (velocity.outputs[o].terms[velocity.cells.consequents[o][flat]].name for o in (0, 1))
        table[cell] = (speeds.index(v), (turns.index(w) + 2) % 3 + 1 if w != "Z" else 0)
    for cell, (speed, turn) in table.items():
        for at in range(3):
            worse = (*cell[:at], {"S": "M", "M": "B", "B": "B"}[cell[at]], *cell[at + 1 :])
            if started(worse)[0] == started(cell)[0]:
                assert table[worse][0] <= speed, (cell, worse)
                assert table[worse][1] >= turn, (cell, worse)


def test_the_world_and_the_spec_agree(nav: tuple[tree.Module, Module]) -> None:
    """Sampling period, safety distance and robot radius are the same in nav.fz and in the robots' world."""
    system = next(d for d in nav[0].items if isinstance(d, tree.SystemDecl))
    written = {p.name.text: p.value for p in system.items if isinstance(p, tree.Param)}
    numbers = {name: value.value for name, value in written.items() if isinstance(value, tree.Number)}
    world = Parameters()
    assert numbers == {
        "T": Fraction(PERIOD),
        "D_safe": Fraction(str(world.safe_distance)),
        "R_robot": Fraction(str(world.robot_radius)),
        "track": Fraction("0.3"),
    }
