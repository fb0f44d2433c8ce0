"""Controllers in float64: known values, the rational meaning, symmetries."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyspec.exact import controller_point, evaluate_controller, evaluate_controller_exactly
from fuzzyspec.model.controller import Behavior, Controller, Fallback, Inference, Input, Is, Not
from fuzzyspec.model.term import Singleton
from tests.exact.exact_models import (
    controller,
    controllers,
    danger,
    even,
    output_of,
    partitioned,
    partitioned_output,
    points_of,
    sentence,
    shape,
    table,
    term,
    variable,
    w3,
)
from tests.exact.exact_rounding import output_error, strength_error


def _hand_worked(full: bool, eta_t: str, eta_d: str, ddc: str) -> Any:
    return pytest.param(full, Fraction(eta_t), Fraction(eta_d), Fraction(ddc), id=f"{full}-{eta_t}-{eta_d}")


@pytest.mark.parametrize(
    ("full", "eta_t", "eta_d", "ddc"),
    [
        # one rule fires fully: the centroid of a whole triangle is its peak, of a half one a third from it
        _hand_worked(True, "0", "0", "1"),
        _hand_worked(False, "0", "0", "5/6"),
        _hand_worked(True, "6", "4", "0"),
        _hand_worked(False, "6", "4", "1/6"),
        _hand_worked(True, "3", "2", "1/2"),
        _hand_worked(False, "3", "2", "1/2"),
        # eta_t halfway from TM to TB with DB: M and S at 1/2. In units of the spacing 1/2, S | M clipped at 1/2 are
        # 1/2 over [0, 3/2] falling to 0 at 2: area 3/4 + 1/8, moment 9/16 + (3/2 + 1/6) / 8
        _hand_worked(False, "9/2", "4", "37/84"),
        # full: the same with the outer half of S is symmetric about the middle of the two peaks
        _hand_worked(True, "9/2", "4", "1/4"),
        # eta_t a quarter from TM to TB with DB: M at 3/4, S at 1/4: 1/4 up to y = 1/4, rising to 3/4 at 3/4, level to
        # 5/4, falling to 0 at 2: area (2 + 8 + 12 + 9) / 32, moment (3 + 52 + 144 + 162) / 384
        _hand_worked(False, "15/4", "4", "361/744"),
    ],
)
def test_danger_by_hand(full: bool, eta_t: Fraction, eta_d: Fraction, ddc: Fraction) -> None:
    """The paper's danger controller gives what its definition gives on paper, in both number systems."""
    inputs = {"eta_t": eta_t, "eta_d": eta_d}
    assert evaluate_controller_exactly(danger(full), inputs) == {"ddc": ddc}
    got = evaluate_controller(danger(full), {k: float(v) for k, v in inputs.items()}).outputs["ddc"]
    assert got.shape == (1,)
    point = controller_point(danger(full), inputs)
    error = output_error(danger(full), danger(full).outputs[0], point)
    assert error is not None
    assert abs(Fraction(float(got[0])) - ddc) <= error


@settings(max_examples=300)
@given(st.data())
def test_float_equals_fraction(data: st.DataObject) -> None:
    """For any controller float64 is within its rounding of the rationals, decisions and margins included."""
    model = data.draw(controllers())
    points = data.draw(st.lists(points_of(model), min_size=1, max_size=6))
    exact = [controller_point(model, p) for p in points]
    arrays = {i.name: np.array([float(p[i.name]) for p in points]) for i in model.inputs}
    taken = {key: [p.decisions[key] for p in exact] for key in exact[0].decisions}
    got = evaluate_controller(model, arrays, taken)
    assert set(got.decisions) == set(got.margins) == set(taken)
    strength = strength_error(model)
    for lane, point in enumerate(exact):
        for key, decision in point.decisions.items():
            margin = point.margins[key]
            # a difference of two strengths (or of one and a rounded constant), and the subtraction itself
            if got.decisions[key][lane] == decision:
                assert abs(Fraction(float(got.margins[key][lane])) - margin) <= 2 * strength + 2**-52
            else:
                assert margin <= 2 * strength
        for output in model.outputs:
            error = output_error(model, output, point)
            if error is not None:
                value = Fraction(float(got.outputs[output.name][lane]))
                assert abs(value - point.outputs[output.name]) <= error


def test_any_length_and_scalars_together() -> None:
    """No cases, one case, and more than a chunk: each is the case alone, and a scalar goes with an array."""
    model = w3()
    many = np.linspace(0, 1, 40_001)
    fixed = {"l": 0.25, "r": 0.75, "t": np.array([12.0])}
    whole = evaluate_controller(model, {**fixed, "f": many}).outputs
    for lane in (0, 16_383, 16_384, 40_000):
        alone = evaluate_controller(model, {**fixed, "f": many[lane]}).outputs
        assert all(alone[name].tolist() == [whole[name][lane]] for name in ("v", "w"))
    none = evaluate_controller(model, {**fixed, "f": many[:0]})
    assert none.outputs["v"].shape == none.outputs["w"].shape == (0,)


def test_inputs_saturate() -> None:
    """Beyond its range an input counts as the range's end."""
    model = danger()
    outside = evaluate_controller(model, {"eta_t": [-1.0, 99.0], "eta_d": [-7.0, 1e300]}).outputs["ddc"]
    ends = evaluate_controller(model, {"eta_t": [0.0, 6.0], "eta_d": [0.0, 4.0]}).outputs["ddc"]
    assert outside.tolist() == ends.tolist()


def test_the_larger_value_holds_at_a_jump() -> None:
    """At a jump of an input term the larger value holds, on either side it does not."""
    jumping = shape((2, 0), (2, "1/2"), (2, "1/4"), (6, "1/4"), (6, 1))
    x = Input(variable("x", 0, 8), (term("J", jumping),), None)
    infer = Inference(aggregate="sum", defuzzify="weighted_average")
    y = output_of("y", 0, 1, [Singleton(Fraction(0)), Singleton(Fraction(1))])
    # y = J / (J + (1 - J)) = J
    rules = [sentence(Not(Is(0, (0,))), (0, 0)), sentence(Is(0, (0,)), (0, 1))]
    model = controller([x], [y], sentences=rules, infer=infer)
    at = np.array([0.0, np.nextafter(2, 0), 2.0, np.nextafter(2, 3), 4.0, np.nextafter(6, 0), 6.0, 8.0])
    assert evaluate_controller(model, {"x": at}).outputs["y"].tolist() == [0, 0, 0.5, 0.25, 0.25, 0.25, 1, 1]


def _sentences(fires_at: str, hold: bool) -> Controller:
    x = partitioned("x", [0, 4, 8])
    y = partitioned_output("y", [0, 1, 2], full=True, fallback=Fallback(Fraction(5, 4), hold))
    rules = [sentence(Is(0, (0,)), (0, 0)), sentence(Is(0, (2,)), (0, 2), weight="1/2")]
    return controller([x], [y], sentences=rules, fires_at=Fraction(fires_at))


def test_firing_at_the_threshold() -> None:
    """A controller fires where its strongest weighted strength reaches the threshold, ``otherwise`` holds below."""
    # strengths at x: T0 1 - x/4 up to 4, T2 (x - 4)/8 beyond
    got = evaluate_controller(_sentences("1/4", False), {"x": [0.0, 3.0, 3.5, 4.0, 5.0, 6.0, 8.0]})
    assert got.decisions["fires.y"].tolist() == [1, 1, 0, 0, 0, 1, 1]
    assert got.margins["fires.y"].tolist() == [0.75, 0, 0.125, 0.25, 0.125, 0, 0.25]
    assert got.outputs["y"].tolist() == [0, 0, 1.25, 1.25, 1.25, 2, 2]
    assert got.state == {}


def test_holding() -> None:
    """An output that holds gives its last value where nothing fires, at first the initial one."""
    model = _sentences("1/4", True)
    first = evaluate_controller(model, {"x": [0.0, 4.0]})
    assert first.outputs["y"].tolist() == first.state["y"].tolist() == [0, 1.25]
    second = evaluate_controller(model, {"x": [4.0, 8.0]}, state=first.state)
    assert second.outputs["y"].tolist() == second.state["y"].tolist() == [0, 2]


def test_decisions_are_taken_where_given() -> None:
    """A given decision is taken, while what exact would have decided is still reported."""
    got = evaluate_controller(_sentences("1/4", False), {"x": [3.0, 3.5]}, {"fires.y": [0, 1]})
    assert got.outputs["y"].tolist() == [1.25, 0]
    assert got.decisions["fires.y"].tolist() == [1, 0]


def _behaviors() -> Controller:
    x = partitioned("x", [0, 1, 2])
    y = partitioned_output("y", [0, 1, 2], fallback=Fallback(Fraction(0), False))
    behaviors = tuple(Behavior(n, c, 9 - c, y.terms[0].span) for c, n in enumerate(("A", "B", "C"), start=1))
    return controller([x], [y], table([x], [0, 1, 2], owner=[2, 1, 3]), behaviors=behaviors, fires_at=Fraction(5, 8))


def test_acting_behavior() -> None:
    """The owner of the strongest cell acts; ties go to the lower code; below the threshold nobody acts."""
    got = evaluate_controller(_behaviors(), {"x": [0.0, 0.25, 0.5, 0.75, 1.0, 2.0]})
    assert got.decisions["acting"].tolist() == [2, 2, 0, 1, 1, 3]
    assert got.outputs["acting"].tolist() == [2, 2, 0, 1, 1, 3]
    # to the next owner 1 - 2x, or to nobody at 5/8: the nearer
    assert got.margins["acting"].tolist() == [0.375, 0.125, 0.125, 0.125, 0.375, 0.375]
    told = evaluate_controller(_behaviors(), {"x": [0.25, 0.25, 0.5]}, {"acting": [1, 0, 1]})
    assert told.outputs["acting"].tolist() == [1, 0, 1]
    assert told.decisions["acting"].tolist() == [2, 2, 0]
    assert told.margins["acting"].tolist() == [0.5, 0.125, 0.125]


def test_acting_tie() -> None:
    """On equal strength the higher priority (lower code) acts, and the margin is 0."""
    model = _behaviors()
    tied = controller(model.inputs, model.outputs, model.cells, behaviors=model.behaviors)
    got = evaluate_controller(tied, {"x": [0.5, 1.5]})
    assert got.decisions["acting"].tolist() == [1, 1]
    assert got.margins["acting"].tolist() == [0, 0]


@given(st.lists(st.fractions(0, 1), min_size=4, max_size=4))
def test_mirror(values: list[Fraction]) -> None:
    """W3 turns the other way when left and right and the target's side change places: w mirrors, v stays."""
    left, front, right, target = values
    mirrored = [2 - a for a in (0, 1, 2)]
    model = w3()
    assert model.cells is not None
    size = (3, 3, 3, 3)
    index = np.arange(81).reshape(size)
    swapped = index.transpose(2, 1, 0, 3)[..., mirrored].ravel()
    v, w = (np.array(c) for c in model.cells.consequents)
    twin = controller(model.inputs, model.outputs, table(model.inputs, v[swapped].tolist(), (6 - w[swapped]).tolist()))
    here = evaluate_controller_exactly(model, {"l": left, "f": front, "r": right, "t": 180 * target - 90})
    there = evaluate_controller_exactly(twin, {"l": right, "f": front, "r": left, "t": 90 - 180 * target})
    assert there == {"v": here["v"], "w": -here["w"]}


@settings(max_examples=60)
@given(st.data())
def test_order_of_inputs_does_not_matter(data: st.DataObject) -> None:
    """With its inputs in another order and its table transposed a controller is the same."""
    infer = data.draw(st.sampled_from([Inference(), Inference(and_="product", implies="product", aggregate="sum")]))
    a, b = partitioned("a", [0, 1, 3]), partitioned("b", [-2, 5])
    y = partitioned_output("y", even(0, 4, 3))
    cells = data.draw(st.lists(st.integers(0, 2), min_size=6, max_size=6))
    turned = np.array(cells).reshape(3, 2).T.ravel().tolist()
    one = controller([a, b], [y], table([a, b], cells), infer=infer)
    two = controller([b, a], [y], table([b, a], turned), infer=infer)
    point = data.draw(points_of(one))
    assert evaluate_controller_exactly(one, point) == evaluate_controller_exactly(two, point)


@settings(max_examples=60)
@given(st.data())
def test_output_lies_in_the_hull_of_what_fires(data: st.DataObject) -> None:
    """A centroid lies between the lowest and the highest point of the terms that fire."""
    peaks = even(0, 4, 5)
    a, b = partitioned("a", even(0, 1, 4)), partitioned("b", even(0, 1, 3))
    cells = data.draw(st.lists(st.integers(0, 4), min_size=12, max_size=12))
    model = controller([a, b], [partitioned_output("y", peaks)], table([a, b], cells))
    i, j = data.draw(st.integers(0, 2)), data.draw(st.integers(0, 1))
    x = (np.arange(1, 16) / 16 + i) / 3
    z = (np.arange(1, 16) / 16 + j) / 2
    fires = [cells[3 * p + q] for p in (i, i + 1) for q in (j, j + 1)]
    y = evaluate_controller(model, {"a": x[:, None].repeat(15, 1).ravel(), "b": np.tile(z, 15)}).outputs["y"]
    assert y.min() > max(0, min(fires) - 1)
    assert y.max() < min(4, max(fires) + 1)
