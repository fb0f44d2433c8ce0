"""Controllers against scikit-fuzzy and pyfuzzylite, which sample: they must agree within what sampling can miss."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fuzzyspec.exact import Point, controller_point, evaluate_controller
from fuzzyspec.model.controller import And, Antecedent, Controller, Fallback, Inference, Is, Not, Or, Output
from fuzzyspec.model.term import PiecewiseLinear, Singleton
from tests.conftest import required_package
from tests.exact.exact_models import (
    controller,
    grid,
    inputs_of,
    output_of,
    partitioned_output,
    peak_lists,
    points_of,
    shape,
    table,
)
from tests.exact.exact_models import controllers as any_controllers
from tests.exact.exact_rounding import U, output_error

CELLS = 100_001
"""Parts that the oracles cut the output axis into."""


def sampling_error(of: Controller, output: Output, point: Point) -> Fraction:
    """What trapezoids or midpoints over ``CELLS`` parts of width h can miss of a centroid.

    Where the envelope is a line over a part, trapezoids are exact, and midpoints are so but for slope h^3 / 12 in the
    moment. Where it bends, both miss at most L h^2 / 2 of the area (L bounds the slope) and W times that of the moment
    about the low end, W the width. A set of p points has, clipped, at most 2 p bends; between the bends of all K sets
    their maximum bends K - 1 times more, their sum does not.
    """
    width = output.integrate_hi - output.integrate_lo
    h = width / CELLS
    sets = _sets(of, output)
    slopes = [max((abs((d - b) / (c - a)) for (a, b), (c, d) in pairwise(s.points)), default=Fraction(0)) for s in sets]
    bends = 2 * sum(len(s.points) for s in sets)
    if of.infer.aggregate == "max":
        slope, kinks = max(slopes), bends + (bends + 1) * (len(sets) - 1)
    else:
        slope, kinks = sum(slopes, Fraction(0)), bends
    area_error = kinks * slope * h * h / 2
    moment_error = width * (kinks + 1) * slope * h * h / 2
    area = point.areas[output.name]
    assume(area > area_error)
    return (moment_error + width * area_error) / (area - area_error)


def _sets(of: Controller, output: Output) -> list[PiecewiseLinear]:
    """The sets that are joined: one a term for a maximum, one a rule for a sum."""
    shapes = [t.shape for t in output.terms if isinstance(t.shape, PiecewiseLinear)]
    if of.infer.aggregate == "max":
        return shapes
    number = of.outputs.index(output)
    cells = of.cells.consequents[number] if of.cells else ()
    rules = [t for r in of.sentences for o, t in r.consequents if o == number]
    return [shapes[t] for t in (*cells, *rules) if t >= 0]


def _allowed(of: Controller, output: Output, point: Point) -> float:
    """Sampling, our rounding, theirs of the same kind, and theirs in adding up ``CELLS`` numbers twice."""
    rounding = output_error(of, output, point)
    assume(rounding is not None)
    assert rounding is not None
    ends = max(abs(output.integrate_lo), abs(output.integrate_hi))
    sampling = Fraction(0) if isinstance(output.terms[0].shape, Singleton) else sampling_error(of, output, point)
    return float(sampling + 2 * rounding + 4 * CELLS * U * ends)


# --- scikit-fuzzy ------------------------------------------------------------------------------


@st.composite
def tables_of_traps(draw: st.DrawFn) -> Controller:
    """One or two inputs of strong partitions, a table, an output of any triangles and trapezoids."""
    inputs = [draw(inputs_of(f"x{k}", strong=True)) for k in range(draw(st.integers(1, 2)))]
    fallback = Fallback(Fraction(0), False)
    if draw(st.booleans()):
        output = partitioned_output("y", draw(peak_lists()), draw(st.booleans()), fallback)
    else:
        corners = st.lists(grid(0, 8, 16), min_size=4, max_size=4, unique=True).map(sorted)
        traps = [shape(*zip(draw(corners), (0, 1, 1, 0), strict=True)) for _ in range(draw(st.integers(1, 4)))]
        output = output_of("y", 0, 8, traps, fallback)
    count = int(np.prod([len(i.terms) for i in inputs]))
    cells = draw(st.lists(st.integers(0, len(output.terms) - 1), min_size=count, max_size=count))
    infer = Inference(draw(st.sampled_from(["min", "product"])), "max", draw(st.sampled_from(["min", "product"])))
    return controller(inputs, [output], table(inputs, cells), infer=infer)


@settings(max_examples=20)
@given(st.data())
def test_scikit_fuzzy(data: st.DataObject) -> None:
    """scikit-fuzzy's membership functions, np.fmin, np.fmax and centroid give the same."""
    skfuzzy = required_package("skfuzzy")
    model = data.draw(tables_of_traps())
    drawn = data.draw(points_of(model))
    point = controller_point(model, drawn)
    assume(point.decisions["fires.y"])
    (output,) = model.outputs
    x = [np.array([float(min(max(drawn[i.name], i.variable.lo), i.variable.hi))]) for i in model.inputs]
    degrees = [
        [skfuzzy.trapmf(value, _corners(t.shape))[0] for t in i.terms] for i, value in zip(model.inputs, x, strict=True)
    ]
    axis = np.linspace(float(output.integrate_lo), float(output.integrate_hi), CELLS + 1)
    union = np.zeros_like(axis)
    join = np.fmin if model.infer.and_ == "min" else np.multiply
    imply = np.fmin if model.infer.implies == "min" else np.multiply
    assert model.cells is not None
    for cell, fired in zip(model.cells.consequents[0], product(*degrees), strict=True):
        implied = imply(join.reduce(fired), skfuzzy.trapmf(axis, _corners(output.terms[cell].shape)))
        union = np.fmax(union, implied)
    theirs = skfuzzy.defuzz(axis, union, "centroid")
    ours = evaluate_controller(model, {n: float(v) for n, v in drawn.items()}).outputs["y"][0]
    assert abs(ours - theirs) <= _allowed(model, output, point)


def _corners(of: object) -> list[float]:
    """The four corners of a triangle, trapezoid or shoulder; shoulders reach far out."""
    assert isinstance(of, PiecewiseLinear)
    points = [(float(x), y) for x, y in of.points]
    left = [points[0][0] - 1000.0] * 2 if points[0][1] else []
    right = [points[-1][0] + 1000.0] * 2 if points[-1][1] else []
    inner = [x for x, _ in points if not (left and x == points[0][0] and len(points) == 1)]
    corners = [*left, *inner, *right]
    return corners if len(corners) == 4 else [corners[0], corners[1], corners[1], corners[2]]


# --- pyfuzzylite -------------------------------------------------------------------------------


def _plain(antecedent: Antecedent) -> bool:
    """Whether fuzzylite's language has it: its ``not`` stands before one term only."""
    match antecedent:
        case Is():
            return True
        case Not(operand):
            return isinstance(operand, Is) and len(operand.terms) == 1
        case And(operands) | Or(operands):
            return all(_plain(o) for o in operands)


def _text(antecedent: Antecedent) -> str:
    match antecedent:
        case Is(number, terms):
            return "(" + " or ".join(f"x{number} is T{t}" for t in terms) + ")"
        case Not(operand):
            assert isinstance(operand, Is)
            return f"x{operand.input} is not T{operand.terms[0]}"
        case And(operands):
            return "(" + " and ".join(_text(o) for o in operands) + ")"
        case Or(operands):
            return "(" + " or ".join(_text(o) for o in operands) + ")"


@settings(max_examples=60)
@given(st.data())
def test_pyfuzzylite(data: st.DataObject) -> None:
    """An engine of pyfuzzylite with the same rules, norms and defuzzifier gives the same."""
    fl = pytest.importorskip("fuzzylite")
    model = data.draw(any_controllers(jumps=False))
    assume(all(_plain(r.antecedent) for r in model.sentences))
    drawn = data.draw(points_of(model))
    point = controller_point(model, drawn)
    engine = _engine(fl, model)
    for variable in engine.input_variables:
        variable.value = float(drawn[variable.name])
    engine.process()
    ours = evaluate_controller(model, {n: float(v) for n, v in drawn.items()}).outputs
    for output in model.outputs:
        if point.decisions[f"fires.{output.name}"] and point.areas[output.name]:
            theirs = np.asarray(engine.output_variable(output.name).value).item()
            assert abs(ours[output.name][0] - theirs) <= _allowed(model, output, point)


def _engine(fl, model):  # type: ignore[no-untyped-def]
    """The same controller for fuzzylite; its terms are lists of points, its singletons constants."""
    sums = {"max": fl.Maximum(), "probsum": fl.AlgebraicSum(), "sum": fl.UnboundedSum()}
    products = {"min": fl.Minimum(), "product": fl.AlgebraicProduct()}

    def term(t, lo, hi):  # type: ignore[no-untyped-def]
        if isinstance(t.shape, Singleton):
            return fl.Constant(t.name, float(t.shape.at))
        points = [(float(x), float(y)) for x, y in t.shape.points]
        # it wants two points or more, and values are constant beyond them
        points = [(min(points[0][0], lo) - 1.0, points[0][1]), *points, (max(points[-1][0], hi) + 1.0, points[-1][1])]
        return fl.Discrete(t.name, fl.Discrete.to_xy(*zip(*points, strict=True)))

    infer = model.infer
    weighted = infer.defuzzify == "weighted_average"
    inputs = [
        fl.InputVariable(
            name=i.name, minimum=float(i.variable.lo), maximum=float(i.variable.hi), lock_range=True,
            terms=[term(t, float(i.variable.lo), float(i.variable.hi)) for t in i.terms],
        )
        for i in model.inputs
    ]  # fmt: skip
    outputs = [
        fl.OutputVariable(
            name=o.name, minimum=float(o.integrate_lo), maximum=float(o.integrate_hi),
            terms=[term(t, float(o.integrate_lo), float(o.integrate_hi)) for t in o.terms],
            aggregation=sums[infer.aggregate],
            defuzzifier=fl.WeightedAverage("TakagiSugeno") if weighted else fl.Centroid(CELLS),
        )
        for o in model.outputs
    ]  # fmt: skip
    texts = []
    if model.cells is not None:
        for number, cell in enumerate(product(*(range(n) for n in model.cells.shape))):
            then = [f"y{o} is T{row[number]}" for o, row in enumerate(model.cells.consequents) if row[number] >= 0]
            if then:
                when = " and ".join(f"x{k} is T{t}" for k, t in enumerate(cell))
                texts.append(f"if {when} then {' and '.join(then)}")
    for rule in model.sentences:
        then = [f"y{o} is T{t}" for o, t in rule.consequents]
        texts.append(f"if {_text(rule.antecedent)} then {' and '.join(then)} with {float(rule.weight)!r}")
    block = fl.RuleBlock(
        conjunction=products[infer.and_], disjunction=sums[infer.or_], implication=products[infer.implies],
        activation=fl.General(), rules=[fl.Rule.create(text) for text in texts],
    )  # fmt: skip
    engine = fl.Engine(input_variables=inputs, output_variables=outputs, rule_blocks=[block])
    block.load_rules(engine)
    return engine
