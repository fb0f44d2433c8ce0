"""Systems in float64: the rational meaning, lists of every length, division, decisions."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyspec.exact import (
    dequantise,
    evaluate_controller,
    evaluate_system,
    evaluate_system_exactly,
    system_point,
)
from fuzzyspec.model.controller import Fallback, Is
from fuzzyspec.model.system import (
    Call,
    CallOutput,
    Clamp,
    Compare,
    Const,
    Div,
    Expr,
    Fold,
    ForEach,
    If,
    Let,
    ListInput,
    Mul,
    ReadField,
    ReadInput,
    ReadLet,
    Statement,
    Sub,
    System,
    SystemOutput,
)
from fuzzyspec.model.units import Unit
from fuzzyspec.model.variable import Raw, Variable
from tests.exact.exact_models import NOWHERE, controller, danger, partitioned, partitioned_output, sentence, variable
from tests.exact.exact_systems import CAPACITY, steps, systems


@settings(max_examples=300)
@given(st.data())
def test_float_equals_fraction(data: st.DataObject) -> None:
    """Where float64 rounds nothing every output, decision, margin and state equals the rational one exactly."""
    model = data.draw(systems())
    drawn = data.draw(st.lists(steps(), min_size=1, max_size=3))
    got = evaluate_system(model, _batched(drawn))
    for lane, one in enumerate(drawn):
        point = system_point(model, one)
        assert {n: Fraction(float(v[lane])) for n, v in got.outputs.items()} == point.outputs
        assert {n: Fraction(float(v[lane])) for n, v in got.state.items()} == point.state
        assert _asked(got.decisions, lane, -1) == point.decisions
        assert {k: Fraction(v) for k, v in _asked(got.margins, lane, np.inf).items()} == point.margins


@settings(max_examples=150)
@given(st.data())
def test_float_equals_fraction_along_decisions(data: st.DataObject) -> None:
    """Told to decide anything, anywhere, both meanings go the same way."""
    model = data.draw(systems())
    one = data.draw(steps())
    told: dict[str, Any] = {}
    for key, own in evaluate_system(model, _batched([one])).decisions.items():
        outcomes = st.integers(-1, 1 if "acting" not in key else 2)
        size = own[0].size
        drawn = data.draw(st.lists(outcomes, min_size=size, max_size=size))
        # 0/0 cannot be told to be anything else
        told[key] = [-1] * size if key.startswith("ratio") else drawn
        told[key] = told[key] if own.ndim > 1 else told[key][0]
    got = evaluate_system(model, _batched([one]), {k: np.array([v]) for k, v in told.items()})
    point = system_point(model, one, told)
    assert {n: Fraction(float(v[0])) for n, v in got.outputs.items()} == point.outputs
    assert _asked(got.decisions, 0, -1) == point.decisions


def _batched(drawn: Sequence[dict[str, Any]]) -> dict[str, Any]:
    return {
        name: np.array([[float(v) for v in d[name]] if isinstance(d[name], list) else float(d[name]) for d in drawn])
        for name in drawn[0]
    }


def _asked(found: dict[str, Any], lane: int, unasked: float) -> dict[tuple[str, tuple[int, ...]], Any]:
    """Key and element numbers to value, of what was asked."""
    return {
        (key, at): value
        for key, array in found.items()
        for at, value in np.ndenumerate(array[lane])
        if value != unasked
    }


def _system(
    inputs: Sequence[Variable | ListInput], value: Expr, statements: Sequence[Statement] = (), unit: Unit | None = None
) -> System:
    out = variable("out", -100, 100, unit or Unit(""))
    return System("s", tuple(inputs), tuple(statements), (SystemOutput(out, value, None, True),), NOWHERE)


def _ratio(divisor: Variable) -> System:
    into = (Fraction(-3), Fraction(5))
    quotient = Div(ReadInput("x"), ReadInput(divisor.name), into, Const(Fraction(2)), "ratio", NOWHERE)
    return _system([variable("x", -8, 8), divisor], Clamp(quotient, *into))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("side", [1, -1])
def test_division_by_zero(side: int) -> None:
    """x/0 is the end of the place on x's side as the divisor comes to 0 from its range; 0/0 is ``otherwise``."""
    divisor = variable("d", 0, 4) if side > 0 else variable("d", -4, 0)
    x = np.array([1.0, -1.0, 0.0, 0.0, 1.0, 8.0, 1.0])
    d = side * np.array([0.0, 0.0, 0.0, 1.0, 2.0, 1.0, 1e-320])
    got = evaluate_system(_ratio(divisor), {"x": x, "d": d})
    expected = {1: [5, -3, 2, 0, 0.5, 5, 5], -1: [-3, 5, 2, 0, -0.5, -3, -3]}[side]
    assert got.outputs["out"].tolist() == expected
    assert got.decisions["ratio"].tolist() == [0, 0, 1, 0, 0, 0, 0]
    assert got.margins["ratio"].tolist() == np.maximum(np.abs(x), np.abs(d)).tolist()


@pytest.mark.filterwarnings("error")
def test_what_lies_beyond_the_count_does_not_matter() -> None:
    """Records beyond the count or the capacity may hold anything, and lists may be shorter than the capacity."""
    fields = (variable("n", -8, 8), variable("d", 0, 4))
    quotient = Div(
        ReadField("items", "n"), ReadField("items", "d"), (Fraction(-3), Fraction(5)), Const(Fraction(2)), "q", NOWHERE
    )
    model = _system([ListInput("items", 3, fields, NOWHERE)], Fold("sum", "items", quotient, None, None))
    n = np.array([1.0, 0.0, 4.0, np.nan])
    d = np.array([0.0, 0.0, 2.0, np.inf])
    sums = [0.0, 5.0, 7.0, 9.0, 9.0]
    for count, total in enumerate(sums):
        polluted = {"items.count": count, "items.n": np.where(np.arange(4) < count, n, np.nan), "items.d": d}
        got = evaluate_system(model, polluted)
        assert got.outputs["out"].tolist() == [total]
        asked = min(count, 3)
        assert got.decisions["q"].tolist() == [[0, 1, 0][:asked] + [-1] * (3 - asked)]
        assert np.isinf(got.margins["q"][0, asked:]).all()
        if count <= 2:
            short = {"items.count": [count], "items.n": n[None, :2], "items.d": d[None, :2]}
            assert evaluate_system(model, short).outputs["out"].tolist() == [total]
    with pytest.raises(ValueError, match="2 records"):
        evaluate_system(model, {"items.count": 3, "items.n": n[:2], "items.d": d[:2]})


def test_whole_batches_of_lists() -> None:
    """A batch of lists of every length gives what each gives alone."""
    fields = (variable("gap", 0, 8), variable("speed", 0, 2))
    gap, speed = (ReadField("items", f.name) for f in fields)
    near = Div(gap, Mul(speed, Const(Fraction(2))), (Fraction(0), Fraction(6)), Const(Fraction(6)), "near", NOWHERE)
    call = Call("one", danger(), (near, gap), NOWHERE)
    loop = ForEach("items", (call, Let("d", CallOutput("one", "ddc"), NOWHERE)), NOWHERE)
    test = Compare(">", gap, Const(Fraction(1)), "far", NOWHERE)
    worst = Fold("max", "items", ReadLet("d", "items"), test, Const(Fraction(0)))
    model = _system([ListInput("items", 5, fields, NOWHERE)], worst, [loop])
    rng = np.random.default_rng(7)
    cases = 200
    inputs = {
        "items.count": rng.integers(0, 8, cases),
        "items.gap": rng.uniform(0, 8, (cases, 7)),
        "items.speed": rng.uniform(0, 2, (cases, 7)),
    }
    whole = evaluate_system(model, inputs)
    for lane in range(cases):
        expected = 0.0
        for k in range(min(int(inputs["items.count"][lane]), 5)):
            g, s = inputs["items.gap"][lane, k], inputs["items.speed"][lane, k]
            alone = evaluate_controller(danger(), {"eta_t": min(g / (s * 2.0), 6.0), "eta_d": min(g, 4.0)})
            if g > 1:
                expected = max(expected, float(alone.outputs["ddc"][0]))
        assert whole.outputs["out"][lane] == expected


MM = Unit("mm", (("m", 1),), Fraction(1, 1000))


@pytest.mark.parametrize("op", ["<", "<=", ">", ">=", "==", "!="])
@pytest.mark.parametrize("factor", [Fraction(1), Fraction(-7, 3)])
def test_comparisons_with_literals_are_exact(op: Any, factor: Fraction) -> None:
    """At every raw a signal compares with a literal as its exact value does, whatever the conversions round."""
    tenths = Raw("uint16", Fraction(1, 10), Fraction(0), 0, 1000)
    signal = Variable("x", Fraction(0), Fraction(100), MM, tenths, NOWHERE)
    raws = np.arange(1001)
    for literal in (Fraction(123, 10000), Fraction(3, 10000), Fraction(1, 30)):
        scaled = Sub(Mul(ReadLet("again", None), Const(factor)), Const(Fraction(1, 3)))
        test = Compare(op, scaled, Const(literal * factor - Fraction(1, 3)), "key", NOWHERE)
        choice = If(test, Const(Fraction(1)), Const(Fraction(0)))
        model = _system([signal], choice, [Let("again", ReadInput("x"), NOWHERE)])
        got = evaluate_system(model, {"x": dequantise(signal, raws)})
        exact = [evaluate_system_exactly(model, {"x": tenths.value(int(r))})["out"] for r in raws]
        assert got.outputs["out"].tolist() == exact
        point = system_point(model, {"x": literal * 1000})
        assert point.margins["key", ()] == 0


def test_inputs_handed_on_keep_their_value() -> None:
    """A signal handed on in its own unit arrives as the very same float."""
    x = Variable("x", Fraction(0), Fraction(100), MM, Raw("uint16", Fraction(1, 10), Fraction(0), 0, 1000), NOWHERE)
    model = _system([x], ReadInput("x"), unit=MM)
    values = dequantise(x, np.arange(1001))
    assert evaluate_system(model, {"x": values}).outputs["out"].tolist() == values.tolist()


def test_state_goes_around() -> None:
    """What a call holds comes out under its id, and is what the next step falls back on."""
    x = partitioned("x", [0, 4])
    y = partitioned_output("y", [0, 2], full=True, fallback=Fallback(Fraction(3, 2), True))
    holder = controller([x], [y], sentences=[sentence(Is(0, (0,)), (0, 0))], fires_at=Fraction(1, 2))
    model = _system([x.variable], CallOutput("h", "y"), [Call("h", holder, (ReadInput("x"),), NOWHERE)])
    first = evaluate_system(model, {"x": [0.0, 4.0]})
    assert first.state["h.y"].tolist() == first.outputs["out"].tolist() == [0, 1.5]
    second = evaluate_system(model, {"x": [4.0, 4.0]}, state=first.state)
    assert second.outputs["out"].tolist() == [0, 1.5]
    assert second.decisions["h.fires.y"].tolist() == [0, 0]
    told = evaluate_system(model, {"x": [4.0, 2.5]}, {"h.fires.y": [0, 1]}, first.state)
    assert told.outputs["out"].tolist() == [0, 0]
    assert told.decisions["h.fires.y"].tolist() == [0, 0]


def test_capacity_is_the_limit_of_the_list() -> None:
    """Counting a list never exceeds its capacity."""
    model = _system([ListInput("items", CAPACITY, (), NOWHERE)], Fold("count", "items", None, None, None))
    got = evaluate_system(model, {"items.count": np.arange(-1, 6)})
    assert got.outputs["out"].tolist() == [0, 0, 1, 2, 3, 3, 3]
