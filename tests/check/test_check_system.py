"""Systems: what the model holds, and what is wrong with a step."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest

from fuzzyspec.check import check
from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.model.interval import Intervals
from fuzzyspec.model.system import (
    ActingOutput,
    Call,
    CallOutput,
    Const,
    Div,
    Fold,
    ForEach,
    Let,
    Mul,
    ReadField,
    ReadInput,
    ReadLet,
    System,
    SystemOutput,
)
from fuzzyspec.syntax import parse
from tests.check.checking import DANGER, checked, complaints, fuzzy, sound, step

NAV = Path(__file__).parents[2] / "examples" / "nav.fz"
LIST = "input obstacles[4] { distance in [0, 8] m, bearing in [-180, 180] deg, speed in [0, 2] m/s }\n"
DISTANCE = "input distance in [0, 8] m\n"
BEHAVED = """
controller drive {
    input  e in [0, 1] { partition LOW HIGH }
    output u in [0, 1] { partition LOW HIGH }
    behavior A priority 2 { if e is LOW then u is LOW }
    behavior B priority 1 { if e is HIGH then u is HIGH }
}
"""


@pytest.fixture(scope="module")
def nav() -> System:
    """The step of nav.fz."""
    source = Source("nav.fz", NAV.read_text())
    model, _ = check(parse(source)[0], source)
    assert model is not None
    return model.systems[0]


def test_nav_is_a_loop_a_call_and_five_outputs(nav: System) -> None:
    """The loop computes the gap and calls danger for each obstacle; then one call drives."""
    loop, drive = nav.statements
    assert isinstance(loop, ForEach) and isinstance(drive, Call)
    gap, danger, ddc = loop.body
    assert isinstance(gap, Let) and isinstance(danger, Call) and isinstance(ddc, Let)
    assert (gap.name, danger.id, ddc.name, drive.id) == ("gap", "danger_1", "ddc", "drive")
    assert ddc.value == CallOutput("danger_1", "ddc")
    assert [c.id for c in nav.calls] == ["danger_1", "drive"]
    assert [o.name for o in nav.outputs] == ["v", "w", "acting", "v_left", "v_right"]


def test_navs_quotient_saturates_into_eta_t(nav: System) -> None:
    """The quotient by a speed that can be 0 ends at eta_t's range; the one by D_safe is a constant factor."""
    danger = nav.calls[0]
    eta_t, eta_d = danger.arguments
    assert isinstance(eta_t, Div)
    assert (eta_t.into, eta_t.otherwise) == ((0, 6), Const(Fraction(6)))
    assert eta_t.right == Mul(ReadField("obstacles", "speed"), Const(Fraction(2)))
    assert eta_d == Mul(ReadLet("gap", "obstacles"), Const(Fraction(5, 2)))


def test_navs_outputs(nav: System) -> None:
    """v is velocity's own, acting a code, the wheels have the interval of their expression in the default raw."""
    v, _, acting, v_left, _ = nav.outputs
    assert isinstance(v, SystemOutput) and isinstance(v_left, SystemOutput)
    assert v.bare == ("drive", "v")
    assert v.variable.raw == nav.calls[1].controller.outputs[0].variable.raw
    assert isinstance(acting, ActingOutput) and acting.call == "drive"
    assert (v_left.variable.lo, v_left.variable.hi) == (Fraction(-45, 1000), Fraction(745, 1000))
    assert (v_left.variable.unit.symbol, v_left.variable.raw.ctype, v_left.saturates) == ("m/s", "int16", False)


def test_every_decision_has_its_key(nav: System) -> None:
    """Three sectors of two comparisons each, and one quotient."""
    drive = nav.calls[1]
    folds = [a for a in drive.arguments if isinstance(a, Fold)]
    keys = [c.key for f in folds for c in f.test.operands]  # type: ignore[union-attr]
    assert len(set(keys)) == 6


def only(text: str) -> System:
    """The system of a sound file."""
    return sound(text).systems[0]


def test_aliases_are_not_statements() -> None:
    """Another name for an input, a constant or a controller's output computes nothing, and stays bare."""
    system = only(
        step(DISTANCE + "let d = distance\nlet k = 2 m\nlet r = danger(gap: min(d, k))\nlet x = r.ddc\noutput u = x")
    )
    assert [type(s) for s in system.statements] == [Call]
    assert isinstance(out := system.outputs[0], SystemOutput) and out.bare == ("r", "ddc")


def test_declared_ranges_saturate_where_they_must() -> None:
    """`saturates` is told where the interval of the value is not inside of the declared range."""
    system = only(
        step(
            DISTANCE
            + "output a in [0, 5] m = distance\noutput b in [0, 9] m = distance\noutput c in [0, 800] cm = distance"
        )
    )
    assert [o.saturates for o in system.outputs if isinstance(o, SystemOutput)] == [True, False, False]


def test_a_raw_of_an_output() -> None:
    """A raw may be given with a range or alone; a controller's output is then converted."""
    body = (
        DISTANCE
        + "let r = danger(gap: distance)\noutput a raw uint8 = r.ddc\noutput b in [0, 2] raw uint16 0..65535 = r.ddc"
    )
    a, b = (o for o in only(step(body)).outputs if isinstance(o, SystemOutput))
    assert (a.bare, a.variable.raw.ctype, a.variable.raw.step) == (None, "uint8", Fraction(1, 128))
    assert (b.bare, b.variable.raw.hi) == (None, 65535)


def test_chains_of_controllers() -> None:
    """Calls feed calls, nested or through lets, in the order that they are needed in."""
    deep = fuzzy("[0, 1] { partition NEAR FAR }") + DANGER
    system = only(step(DISTANCE + "let a = c(e: danger(gap: distance).ddc).u + 0\noutput u = c(e: c(e: a).u).u", deep))
    assert [c.id for c in system.calls] == ["danger_1", "c_1", "c_2", "c_3"]
    intervals = Intervals.of_system(system)
    assert intervals.of(ReadLet("a", None)) == (0, 1)


def test_ids_of_calls_avoid_names() -> None:
    """A generated id is never the name of a `let`."""
    system = only(step(DISTANCE + "let danger_1 = distance / 2\noutput u = danger(gap: danger_1).ddc"))
    assert [c.id for c in system.calls] == ["danger_2"]


def test_one_controller_may_hold() -> None:
    """A controller that remembers gives the system a state."""
    hold = DANGER.replace("LOW HIGH }", "LOW HIGH  otherwise hold initial 0 }")
    assert only(step(DISTANCE + "output u = danger(gap: distance).ddc", hold)).holds


def test_the_count_of_a_list() -> None:
    """`obstacles.count` is a fold without a test."""
    system = only(step(LIST + "output n = obstacles.count\noutput m = count(o for o in obstacles if o.distance < 1 m)"))
    values = [o.value for o in system.outputs if isinstance(o, SystemOutput)]
    assert values[0] == Fold("count", "obstacles", None, None, None)
    assert [(o.variable.lo, o.variable.hi) for o in system.outputs if isinstance(o, SystemOutput)] == [(0, 4), (0, 4)]


def test_literals_stand_on_the_right() -> None:
    """A comparison with a literal reads the same whichever side it is written on."""
    one = only(step(DISTANCE + "output u = 1 if 3 m > distance else 0")).outputs[0]
    other = only(step(DISTANCE + "output u = 1 if distance < 3 m else 0")).outputs[0]
    assert isinstance(one, SystemOutput) and isinstance(other, SystemOutput)
    assert one.value.test.op == other.value.test.op == "<"  # type: ignore[union-attr]
    assert one.value.test.left == other.value.test.left == ReadInput("distance")  # type: ignore[union-attr]


def test_bare_numbers_take_the_unit_of_their_place() -> None:
    """`otherwise 6`, a branch and a whole argument are in the input's unit, here mm."""
    controllers = fuzzy("[0, 4] mm { partition NEAR FAR }")
    body = DISTANCE + "output a = c(e: 3).u\noutput b = c(e: distance if distance > 1 m else 2).u"
    calls = only(step(body, controllers)).calls
    assert calls[0].arguments == (Const(Fraction(3, 1000)),)
    assert calls[1].arguments[0].other == Const(Fraction(2, 1000))  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("body", "code", "marked"),
    [
        ("output d = danger(gap: danger).ddc", "FZ201", "danger"),
        ("output d = danger(gap: distance(3)).ddc", "FZ202", "distance"),
        ("output d = max(distance, 1 m).x", "FZ203", "x"),
        ("output d = distance.x", "FZ203", "x"),
        ("output d = danger(gap: distance)", "FZ246", "danger(gap: distance)"),
        ("let a = danger(gap: distance)\noutput d = a.acting + 1", "FZ245", "acting"),
        ("let distance = 3 m\noutput d = distance", "FZ210", "distance"),
        ("output distance = 2 * distance", "FZ210", "distance"),
        ("output d = 2 * distance\noutput d = distance", "FZ210", "d"),
        ("output d = 2 * distance\noutput D = distance", "FZ212", "D"),
        ("output int = distance", "FZ211", "int"),
        ("output bool = distance", "FZ211", "bool"),
        ("output _d = distance", "FZ211", "_d"),
        ("output d = abs(x: distance)", "FZ216", "x: distance"),
        ("output d = max(distance)", "FZ217", "max(distance)"),
        ("output d = sum(distance)", "FZ252", "sum(distance)"),
        ("output d = 1 if distance else 0", "FZ247", "distance"),
        ("output d = 1 + (distance > 1 m)", "FZ247", "distance > 1 m"),
        ("output d = clamp(distance, 3 m, 1 m)", "FZ401", "3 m, 1 m"),
        ("output d = 1 if distance in [3, 1] m else 0", "FZ401", "3, 1"),
        ("let o.x = 3\noutput d = distance", "FZ244", "o.x"),
        ("param p = distance\noutput d = distance", "FZ248", "distance"),
        ("let a = a + 1\noutput d = a", "FZ240", "a"),
        ("param p = q\nparam q = 2 * p\noutput d = distance", "FZ240", "p"),
        ("output d = distance / (distance - distance)", "FZ430", "distance - distance"),
        ("output d in [4, 0] m = distance", "FZ401", "[4, 0] m"),
        ("output d in [0, 4] s = distance", "FZ220", "distance"),
        ("output d raw uint8 step 0 = distance", "FZ403", "0"),
    ],
)
def test_steps_that_are_refused(body: str, code: str, marked: str) -> None:
    """Each slip is reported once, at its place."""
    assert [c for c in complaints(step(DISTANCE + body)) if c[0] != "FZ242"] == [(code, marked)]


@pytest.mark.parametrize(
    ("body", "code", "marked"),
    [
        ("output d = obstacles", "FZ243", "obstacles"),
        ("output d = max(o for o in obstacles, otherwise 0)", "FZ243", "o"),
        ("output d = max(o.gap for o in obstacles, otherwise 0)", "FZ203", "gap"),
        ("output d = max(o.distance for o in obstcles, otherwise 0)", "FZ201", "obstcles"),
        ("output d = max(p.distance for o in obstacles, otherwise 0)", "FZ201", "p"),
        ("output d = max(o.distance for obstacles in obstacles, otherwise 0)", "FZ210", "obstacles"),
        ("output d = max(o.distance for o in obstacles, otherwise 8)", "FZ220", "8"),
        ("output d = count(o.distance for o in obstacles)", "FZ252", "o.distance"),
        ("output d = sum(o.distance for o in obstacles, otherwise 8 m)", "FZ433", "8 m"),
        ("for each o in obstacles { let o.distance = 3 m }\noutput d = 2 * obstacles.count", "FZ210", "distance"),
        ("for each o in obstacles { let p.x = o.distance / 2 }\noutput d = 2 * obstacles.count", "FZ244", "p.x"),
        ("for each o in obstacles { let o.a = o.b  let o.b = o.a }\noutput d = obstacles.count", "FZ240", "o.a"),
        ("for each o in obstacles { let o.a = o.b  let o.b = o.speed }\n"
         "output d = max(o.a for o in obstacles, otherwise 0)", "FZ241", "b"),
        ("for each o in obstacles { let o.a = danger(gap: o.distance) }\n"
         "output d = max(o.a for o in obstacles, otherwise 0)", "FZ246", "danger(gap: o.distance)"),
        ("for each o in obstacles { let o.a = max(p.speed for p in obstacles, otherwise 0) }\n"
         "output d = max(o.a for o in obstacles, otherwise 0)", "FZ250",
         "max(p.speed for p in obstacles, otherwise 0)"),
        ("output d = sum(max(p.speed for p in obstacles, otherwise 0) for o in obstacles)", "FZ250",
         "max(p.speed for p in obstacles, otherwise 0)"),
    ],
)  # fmt: skip
def test_lists_that_are_misused(body: str, code: str, marked: str) -> None:
    """Each slip with a list is reported once, at its place."""
    assert complaints(step(LIST + body)) == [(code, marked)]


@pytest.mark.parametrize(
    ("declaration", "code", "marked"),
    [
        ("input l[300] { a in [0, 1] }", "FZ406", "300"),
        ("input l[2.5] { a in [0, 1] }", "FZ406", "2.5"),
        ("input l[4 m] { a in [0, 1] }", "FZ220", "4 m"),
        ("input l[4] { count in [0, 1] }", "FZ211", "count"),
        ("input l[4] { a in [0, 1], a in [0, 2] }", "FZ210", "a"),
        ("input l[4] { a in [0, 1], A in [0, 2] }", "FZ212", "A"),
        ("input l[4] { class in [0, 1] }", "FZ211", "class"),
        ("input l_count in [0, 1]\ninput l[4] { a in [0, 1] }", "FZ210", "l"),
    ],
)
def test_lists_that_are_refused(declaration: str, code: str, marked: str) -> None:
    """Capacities, fields and the members that a list gives the C struct."""
    assert complaints(step(f"{declaration}\noutput n = l.count")) == [(code, marked)]


def test_acting_is_handed_on_only() -> None:
    """A controller with behaviors has a code; computing with it is refused, and so is giving it a range."""
    body = "input x in [0, 1]\nlet d = drive(e: x)\noutput acting {} = d.acting{}\noutput u = d.u"
    assert isinstance(only(step(body.format("", ""), BEHAVED)).outputs[0], ActingOutput)
    assert complaints(step(body.format("", " + 1"), BEHAVED)) == [("FZ245", "acting")]
    assert complaints(step(body.format("in [0, 2]", ""), BEHAVED)) == [("FZ245", "acting")]


def test_an_output_called_acting() -> None:
    """Where behaviors report under that name, no output can have it."""
    text = BEHAVED.replace("output u", "output acting").replace("u is", "acting is")
    assert complaints(text) == [("FZ211", "acting")]


def test_names_of_functions_are_taken() -> None:
    """No controller is called like a built-in function; no two functions of a file share a name."""
    assert complaints(fuzzy().replace("controller c", "controller max")) == [("FZ211", "max")]
    assert complaints(fuzzy() + fuzzy()) == [("FZ210", "c")]
    assert complaints(fuzzy() + "system C { input x in [0, 1]\noutput u = c(e: x).u }") == [("FZ212", "C")]


def test_every_problem_in_one_run() -> None:
    """Problems of units, controllers and systems are all told, in the order of the text, each once."""
    text = (
        "unit tick = 0\n"
        + fuzzy("[4, 0] { partition NEAR FAR }", "[0, 1] { partition LOW HIGH  otherwise 7 }")
        + DANGER.replace("NEAR: HIGH", "NAER: HIGH")
        + "system s { input x in [0, 1] metres\ninput y in [0, 4] m\n"
        "let a = danger(gap: x)\nlet b = danger(gap: y + 1 s)\n"
        "output u = a.ddc + b.ddd + c(e: 3).u\noutput u = y * undefined }"
    )
    assert [c for c, _ in complaints(text)] == [
        "FZ222", "FZ401", "FZ422", "FZ313", "FZ204", "FZ220", "FZ203", "FZ210", "FZ201",
    ]  # fmt: skip


def test_what_failed_is_not_reported_where_it_is_used() -> None:
    """A broken variable, let or param is reported at its definition alone."""
    body = "param p = 2 quux\nlet a = p * 2\nlet b = max(a, p)\ninput x in [3, 1] m\noutput u = b + x\n"
    body += "output v = danger(gap: x).ddc"
    assert [c for c, _ in complaints(step(body))] == ["FZ204", "FZ401"]


def test_a_broken_controller_can_still_be_called() -> None:
    """Arguments and outputs of a controller with an error in its rules are checked as usual."""
    broken = DANGER.replace("FAR: LOW", "FAR: LWO")
    assert complaints(step(DISTANCE + "output u = danger(gap: distance).ddc", broken)) == [("FZ313", "LWO")]
    assert [c for c, _ in complaints(step(DISTANCE + "output u = danger(gap: distance).dcd", broken))] == [
        "FZ313",
        "FZ203",
    ]


def test_help_shows_the_other_place() -> None:
    """A mismatch of units labels both operands; a duplicate labels the first declaration."""
    _, found, source = checked(step(DISTANCE + "input speed in [0, 2] m/s\noutput d = distance + speed"))
    (label,) = found[0].labels
    assert source.text[label.span.start : label.span.end] == "distance"
    assert source.position(label.span.start)[0] == source.position(found[0].span.start)[0]


@pytest.mark.parametrize(
    ("test", "marked"),
    [
        ("distance < 9 m", "distance < 9 m"),
        ("9 m <= distance", "9 m <= distance"),
        ("distance != 9 m", "distance != 9 m"),
        ("distance in [9, 10] m", "distance in [9, 10] m"),
        ("2 m < distance < -1 m", "2 m < distance < -1 m"),
        ("distance in [-1, 3] m", None),
        ("distance <= 0", None),
        ("distance in [8, 9] m", None),
    ],
)
def test_conditions_that_never_change(test: str, marked: str | None) -> None:
    """A comparison that the ranges decide is told of; a sector that sticks out at one end is not."""
    found = complaints(step(DISTANCE + f"output d = 1 if {test} else 0"))
    assert found == ([] if marked is None else [("FZ436", marked)])
