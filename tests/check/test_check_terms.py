"""Terms: partitions, shapes, and what is wrong with them."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyspec.check.shapes import degree, even_peaks, first_gap, has_area, partition, reaches, shaped
from fuzzyspec.model.controller import Inference, Input, Output
from fuzzyspec.model.term import PiecewiseLinear, Singleton
from tests.check.checking import complaints, fuzzy, sound

PEAKS = st.lists(st.fractions(-100, 100, max_denominator=50), min_size=2, max_size=7, unique=True).map(sorted)
VALUES = st.fractions(-120, 120, max_denominator=97)


def half(n: int) -> Fraction:
    """n / 2."""
    return Fraction(n, 2)


@given(PEAKS, VALUES)
def test_partitions_are_strong(peaks: list[Fraction], x: Fraction) -> None:
    """The degrees of a partition's terms add up to 1 everywhere, and at most two are active."""
    degrees = [degree(t.points, x) for t in partition(peaks, full=False)]
    assert sum(degrees) == 1
    assert sum(d > 0 for d in degrees) <= 2


@given(PEAKS, VALUES)
def test_full_end_terms_are_symmetric(peaks: list[Fraction], distance: Fraction) -> None:
    """With `full` the end terms fall outwards as they fall inwards; between the end peaks nothing changes."""
    full, plain = partition(peaks, full=True), partition(peaks, full=False)
    for term, peak in ((full[0], peaks[0]), (full[-1], peaks[-1])):
        assert degree(term.points, peak + distance) == degree(term.points, peak - distance)
    inside = min(max(distance, peaks[0]), peaks[-1])
    assert [degree(t.points, inside) for t in full] == [degree(t.points, inside) for t in plain]


@given(PEAKS, VALUES)
def test_every_partition_reaches_everywhere(peaks: list[Fraction], end: Fraction) -> None:
    """A partition leaves no gap."""
    lo, hi = sorted((peaks[0], end))
    assert first_gap([t.points for t in partition(peaks, full=False)], lo, max(hi, lo + 1)) is None


@given(st.lists(st.tuples(VALUES, VALUES, VALUES).map(sorted), min_size=1, max_size=4), PEAKS)
def test_a_gap_is_where_no_term_has_any_degree(corners: list[list[Fraction]], ends: list[Fraction]) -> None:
    """What is called a gap has degree 0 throughout; where none is found, no probe finds one."""
    terms = [shaped("triangle", c) for c in corners if c[0] < c[2]]
    points = [t.points for t in terms if isinstance(t, PiecewiseLinear)]
    lo, hi = ends[0], ends[-1]
    gap = first_gap(points, lo, hi)
    if gap is None:
        probes = [lo + (hi - lo) * k / 64 for k in range(65)]
        assert all(any(degree(p, x) > 0 for p in points) for x in probes)
    else:
        assert lo <= gap[0] <= gap[1] <= hi
        probes = [gap[0] + (gap[1] - gap[0]) * k / 8 for k in range(1, 8)]
        assert all(degree(p, x) == 0 for p in points for x in probes)


def test_a_jump_has_the_larger_value() -> None:
    """Two points at one place: the larger value holds there."""
    points = tuple((Fraction(x), Fraction(y, 4)) for x, y in [(0, 0), (1, 1), (1, 4), (1, 2), (2, 0)])
    assert degree(points, Fraction(1)) == 1
    assert degree(points, Fraction(1, 2)) == Fraction(1, 8)
    assert degree(points, Fraction(3, 2)) == Fraction(1, 4)


def test_a_spike_has_no_area() -> None:
    """A term that is above 0 at a single place can be met, but has no area."""
    points = tuple((Fraction(x), Fraction(y)) for x, y in [(0, 0), (1, 0), (1, 1), (1, 0), (2, 0)])
    assert reaches(points, Fraction(0), Fraction(2))
    assert not has_area(points, Fraction(0), Fraction(2))


def test_even_peaks_go_from_end_to_end() -> None:
    """Seven terms over [-0.3, 0.3] stand 0.1 apart, exactly."""
    peaks = even_peaks(Fraction(-3, 10), Fraction(3, 10), 7)
    assert peaks == tuple(Fraction(k, 10) for k in range(-3, 4))


def given_input(text: str) -> Input:
    """The input of a controller whose declaration is sound."""
    rules = "rules { if e is NEAR then u is HIGH  if not e is NEAR then u is LOW }"
    return sound(fuzzy(text, rules=rules)).controllers[0].inputs[0]


def given_output(text: str) -> Output:
    """The output of a controller whose declaration is sound."""
    return sound(fuzzy(taken=text)).controllers[0].outputs[0]


def test_a_placed_partition() -> None:
    """Peaks may stand anywhere inside of the range; the end terms are shouldered."""
    i = given_input("[0, 10] m { partition NEAR at 1, MID at 250 cm, FAR at 9 }")
    assert i.peaks == (1, Fraction(5, 2), 9)
    assert i.terms[0].shape == PiecewiseLinear(((Fraction(1), Fraction(1)), (Fraction(5, 2), Fraction(0))))


def test_a_full_partition_widens_the_integral() -> None:
    """`full` integrates over the mirrored halves too; the range stays what it is."""
    o = given_output("[0, 1] { partition LOW MID HIGH full }")
    assert (o.full, o.integrate_lo, o.integrate_hi) == (True, half(-1), half(3))
    assert (o.variable.lo, o.variable.hi) == (0, 1)
    plain = given_output("[0, 1] { partition LOW MID HIGH }")
    assert (plain.full, plain.integrate_lo, plain.integrate_hi) == (False, 0, 1)


def test_shapes_become_points() -> None:
    """Triangles, trapezoids, ramps and points become piecewise-linear memberships; there is no partition then."""
    i = given_input(
        "[0, 10] { term NEAR = triangle(-1, 0, 1)  term FAR = points((0, 0.25), (5, 1))  term A = ramp_up(1, 2)"
        "  term B = ramp_down(1, 2)  term C = trapezoid(1, 1, 2, 3) }"
    )
    assert i.peaks is None
    assert [t.name for t in i.terms] == ["NEAR", "FAR", "A", "B", "C"]
    assert all(isinstance(t.shape, PiecewiseLinear) for t in i.terms)


def test_singletons_call_for_the_weighted_average() -> None:
    """`singletons` spreads evenly, and without `infer` the average with sums is taken."""
    model = sound(fuzzy(taken="[0, 1] { singletons LOW MID HIGH }"))
    c = model.controllers[0]
    assert [t.shape for t in c.outputs[0].terms] == [Singleton(Fraction(0)), Singleton(half(1)), Singleton(Fraction(1))]
    assert c.infer == Inference(aggregate="sum", defuzzify="weighted_average")


def test_aggregation_can_be_asked_for() -> None:
    """`aggregate = max` per singleton, and product with any of them."""
    model = sound(fuzzy(taken="[0, 1] { singletons LOW HIGH }", more="infer { and = product, aggregate = max }"))
    assert model.controllers[0].infer == Inference(and_="product", defuzzify="weighted_average")


REFUSED = [
    ("[0, 4] { partition NEAR FAR full }", "FZ413", "partition NEAR FAR full"),
    ("[0, 4] { partition NEAR at -1, FAR at 4 }", "FZ411", "-1"),
    ("[0, 4] { partition NEAR at 1, FAR at 1 }", "FZ412", "FAR"),
    ("[0, 4] m { partition NEAR at 1 s, FAR at 4 }", "FZ220", "1 s"),
    ("[0, 4] { partition NEAR FAR  term NEAR = ramp_up(0, 1) }", "FZ210", "NEAR"),
    ("[0, 4] { partition NEAR NEAR FAR }", "FZ210", "NEAR"),
    ("[0, 4] { term NEAR = triangle(0, 1)  term FAR = ramp_up(0, 4) }", "FZ217", "term NEAR = triangle(0, 1)"),
    ("[0, 4] { term NEAR = ramp_up(1, 1)  term FAR = ramp_up(0, 4) }", "FZ414", "1, 1"),
    ("[0, 4] { term NEAR = trapezoid(0, 2, 1, 4)  term FAR = ramp_up(0, 4) }", "FZ414", "0, 2, 1, 4"),
    ("[0, 4] { term NEAR = singleton(1)  term FAR = ramp_up(0, 4) }", "FZ416", "term NEAR = singleton(1)"),
    ("[0, 4] { singletons NEAR FAR }", "FZ416", "singletons NEAR FAR"),
    ("[0, 4] { term NEAR = gaussian(0, 1)  term FAR = ramp_up(0, 4) }", "FZ206", "gaussian"),
    ("[0, 4] { term NEAR = points((0, 1.5), (1, 0))  term FAR = ramp_up(0, 4) }", "FZ415", "1.5"),
    (
        "[0, 4] { term NEAR = points((0, 0), (1, 0))  term FAR = ramp_up(0, 4) }",
        "FZ410",
        "term NEAR = points((0, 0), (1, 0))",
    ),
    ("[0, 4] { term NEAR = triangle(4, 5, 6)  term FAR = ramp_up(0, 4) }", "FZ410", "term NEAR = triangle(4, 5, 6)"),
]


@pytest.mark.parametrize(("text", "code", "marked"), REFUSED)
def test_input_terms_that_are_refused(text: str, code: str, marked: str) -> None:
    """Each slip in an input's terms is reported once; the rules that use the term say nothing more."""
    assert complaints(fuzzy(text)) == [(code, marked)]


@pytest.mark.parametrize(
    ("text", "code", "marked"),
    [
        ("[0, 1] { partition LOW at 0.1, HIGH at 1 full }", "FZ413", "LOW"),
        ("[0, 1] { partition LOW HIGH full  term MID = triangle(0, 1, 2) }", "FZ413", "partition LOW HIGH full"),
        ("[0, 1] { singletons LOW at 0, HIGH at 2 }", "FZ411", "2"),
        ("[0, 1] { term LOW = singleton(-1)  term HIGH = singleton(1) }", "FZ411", "-1"),
        (
            "[0, 1] { term LOW = triangle(-1, -1, 0)  term HIGH = ramp_up(0, 1) }",
            "FZ410",
            "term LOW = triangle(-1, -1, 0)",
        ),
        ("[0, 1] { partition LOW HIGH  otherwise hold initial 3 }", "FZ422", "3"),
        ("[0, 1] { partition LOW HIGH  otherwise 3 s }", "FZ220", "3 s"),
        ("[0, 1] { partition LOW HIGH  otherwise 0  otherwise 1 }", "FZ210", "otherwise 1"),
    ],
)
def test_output_terms_that_are_refused(text: str, code: str, marked: str) -> None:
    """The same for an output's terms and its `otherwise`."""
    assert complaints(fuzzy(taken=text)) == [(code, marked)]


@pytest.mark.parametrize(
    ("more", "code", "marked"),
    [
        ("infer { defuzzify = bisector }", "FZ207", "bisector"),
        ("infer { und = min }", "FZ207", "und"),
        ("infer { and = min, and = product }", "FZ210", "and = product"),
        ("infer { aggregate = sum }", "FZ420", "aggregate = sum"),
        ("infer { defuzzify = weighted_average }", "FZ421", "u"),
        ("fires at 2", "FZ423", "2"),
        ("fires at 1/4 fires at 1/8", "FZ210", "fires at 1/8"),
        ("fires at 1 s", "FZ220", "1 s"),
    ],
)
def test_settings_that_are_refused(more: str, code: str, marked: str) -> None:
    """Each wrong setting is reported once."""
    assert complaints(fuzzy(more=more)) == [(code, marked)]


def test_a_centroid_of_singletons_is_refused() -> None:
    """The method must go with the terms, also where it is asked for."""
    found = complaints(fuzzy(taken="[0, 1] { singletons LOW HIGH }", more="infer { defuzzify = centroid }"))
    assert found == [("FZ421", "u")]
