"""Units: the algebra, what is built in, and what a file declares."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyspec.check.units import BUILT_IN, PI, Units, coherent, describe, dims, times
from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.model.units import Unit
from fuzzyspec.syntax import tree
from tests.check.checking import complaints, fuzzy, sound, step

SYMBOLS = sorted(s for s, u in BUILT_IN.items() if not u.offset)
FACTORS = st.lists(st.tuples(st.sampled_from(SYMBOLS), st.sampled_from([-2, -1, 1, 2])), min_size=1, max_size=4)


def resolved(factors: tuple[tuple[str, int], ...]) -> Unit:
    """The unit of these factors, all of which are known."""
    unit = Units().resolve(tree.UnitExpr(factors, Span(0, 1)), pytest.fail)
    assert unit is not None
    return unit


@given(FACTORS, FACTORS)
def test_units_multiply(a: list[tuple[str, int]], b: list[tuple[str, int]]) -> None:
    """The unit of a product has the product of the scales and the sum of the exponents, in any order."""
    both = resolved((*a, *b))
    assert both.scale == resolved(tuple(a)).scale * resolved(tuple(b)).scale
    assert both.dims == times(resolved(tuple(a)).dims, resolved(tuple(b)).dims)
    assert both.dims == resolved((*b, *a)).dims


@given(FACTORS)
def test_a_unit_by_itself_is_one(a: list[tuple[str, int]]) -> None:
    """Dividing a unit by itself leaves a plain number."""
    unit = resolved((*a, *((s, -e) for s, e in a)))
    assert (unit.dims, unit.scale) == ((), 1)


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ((("W", 1),), (("V", 1), ("A", 1))),
        ((("W", 1),), (("N", 1), ("m", 1), ("s", -1))),
        ((("Pa", 1),), (("N", 1), ("m", -2))),
        ((("N", 1),), (("kg", 1), ("m", 1), ("s", -2))),
        ((("Hz", 1),), (("s", -1),)),
        ((("km", 1),), (("m", 1),)),
        ((("rad", 1), ("s", -1)), (("rpm", 1),)),
    ],
)
def test_derived_units_agree(left: tuple[tuple[str, int], ...], right: tuple[tuple[str, int], ...]) -> None:
    """A derived unit has the dimensions of its definition."""
    assert resolved(left).dims == resolved(right).dims


def test_pi_is_closer_than_a_float_can_tell() -> None:
    """The rational pi rounds to the float pi."""
    assert float(PI) == math.pi


def test_scales_of_what_is_built_in() -> None:
    """Prefixes, percent, revolutions a minute and degrees Celsius are worth what they should be."""
    assert BUILT_IN["mm"].to_coherent(Fraction(5)) == Fraction(1, 200)
    assert BUILT_IN["min"].to_coherent(Fraction(2)) == 120
    assert BUILT_IN["%"].to_coherent(Fraction(50)) == Fraction(1, 2)
    assert BUILT_IN["rpm"].to_coherent(Fraction(30)) == PI
    assert BUILT_IN["degC"].to_coherent(Fraction(20)) == Fraction(29315, 100)
    assert BUILT_IN["degC"].from_coherent(Fraction(29315, 100)) == 20


def test_dimensions_are_told_in_the_readers_words() -> None:
    """Messages name derived units where there is one, powers where there is none."""
    assert describe(()) == "a plain number"
    assert describe(dims(m=1, s=-1)) == "in m/s"
    assert describe(dims(s=-2)) == "in 1/s^2"
    assert coherent(dims(kg=1, m=1, s=-2)).symbol == "N"


def test_a_unit_of_the_file() -> None:
    """`unit tick = 0.012 rad` is worth that much, and can be built upon."""
    model = sound(
        "unit tick = 0.012 rad\nunit turn = 100 * 0.012 rad\n" + fuzzy("[0, 4] tick/s { partition NEAR FAR }")
    )
    unit = model.controllers[0].inputs[0].variable.unit
    assert (unit.symbol, unit.scale, unit.dims) == ("tick/s", Fraction(12, 1000), (("s", -1),))


def test_a_failed_unit_is_reported_once() -> None:
    """Uses of a unit whose declaration failed say nothing more."""
    text = "unit tick = 0 rad\n" + fuzzy("[0, 4] tick { partition NEAR FAR }", "[0, 1] tick/s { partition LOW HIGH }")
    assert complaints(text) == [("FZ222", "0 rad")]


@pytest.mark.parametrize(
    ("expression", "code", "marked"),
    [
        ("distance + speed", "FZ220", "speed"),
        ("distance - 3", "FZ220", "3"),
        ("max(1, distance)", "FZ220", "distance"),
        ("bearing", "FZ220", "bearing"),
        ("to_rad(bearing)", "FZ220", "to_rad(bearing)"),
        ("distance if bearing > 30 else 1 m", "FZ220", "30"),
        ("distance if bearing in [0, 30] else 1 m", "FZ220", "30"),
        ("distance if bearing in [0, 30] m else 1 m", "FZ220", "0"),
        ("distance if speed > 1 m/s else speed", "FZ220", "speed"),
        ("clamp(distance, 0, 3)", "FZ220", "3"),
        ("distance / (2 s - 1 m)", "FZ220", "1 m"),
    ],
)
def test_units_that_do_not_agree(expression: str, code: str, marked: str) -> None:
    """Every place that needs one unit says so, at the operand that differs."""
    inputs = "input distance in [0, 8] m  input speed in [0, 2] m/s  input bearing in [-180, 180] deg\n"
    assert complaints(step(inputs + f"output d = danger(gap: {expression}).ddc")) == [(code, marked)]


@pytest.mark.parametrize(
    "expression",
    ["distance + 20 cm", "max(0, distance)", "2 * distance", "speed * 3 s", "distance / speed * 1 m/s", "3",
     "distance if bearing in [0, 30] deg else 2", "min(distance, 1 km) if 0 < bearing else 0", "distance * 50 %"],
)  # fmt: skip
def test_units_that_agree(expression: str) -> None:
    """Prefixes, a bare 0, and bare numbers that are the whole value fit."""
    inputs = "input distance in [0, 8] m  input speed in [1, 2] m/s  input bearing in [-180, 180] deg\n"
    assert not [c for c in complaints(step(inputs + f"output d = danger(gap: {expression}).ddc")) if c[0] != "FZ242"]


def test_degrees_and_radians_do_not_mix() -> None:
    """An angle in degrees for one in radians is refused, with the way out; `to_rad` mends it."""
    controllers = fuzzy("[-3, 3] rad { partition NEAR FAR }")
    body = "input a in [-90, 90] deg\noutput u = c(e: {}).u"
    assert complaints(step(body.format("a"), controllers)) == [("FZ220", "a")]
    sound(step(body.format("to_rad(a)"), controllers))


def test_units_and_params_are_defined_before_their_use() -> None:
    """What a file declares further down is pointed at, also where two need each other."""
    assert complaints("unit a = 3 b\nunit b = 2 m\n" + fuzzy("[0, 4] a { partition NEAR FAR }")) == [("FZ241", "b")]
    assert complaints("param p = 2 * q\nparam q = 2 * p\n" + fuzzy("[0, p] { partition NEAR FAR }")) == [("FZ241", "q")]
