"""Reachable intervals hold every output, and their attained parts are attained."""

from __future__ import annotations

import itertools
from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fuzzyspec.check.degrees import core
from fuzzyspec.check.reachable import reach
from fuzzyspec.exact import evaluate_controller_exactly
from tests.check_rules.specs import from_text, the_controller

PLACES = st.integers(-2, 12)


@st.composite
def specs(draw):
    """One or two inputs, cells that are all set, output terms of any shape under any inference."""
    inputs = draw(st.integers(1, 2))
    names = ", ".join(f"x{i}" for i in range(inputs))
    kind = draw(st.sampled_from(["even", "full", "placed", "shapes", "singletons"]))
    count = draw(st.integers(2, 4))
    outs = [f"Y{k}" for k in range(count)]
    infer = ""
    match kind:
        case "even" | "full":
            body = f"partition {' '.join(outs)} {'full' if kind == 'full' else ''}"
        case "placed":
            peaks = sorted(draw(st.sets(st.integers(0, 10), min_size=count, max_size=count)))
            body = "partition " + ", ".join(f"{n} at {p}" for n, p in zip(outs, peaks, strict=True))
        case "singletons":
            body = f"singletons {' '.join(outs)}"
            infer = "infer { defuzzify = weighted_average }"
        case "shapes":
            body = ""
            for name in outs:
                a, b, c, d = sorted(draw(st.lists(PLACES, min_size=4, max_size=4)))
                shape = draw(
                    st.sampled_from([f"trapezoid({a}, {b}, {c}, {d})", f"points(({a}, 1), ({c}, 0), ({d}, 1/2))"])
                )
                body += f" term {name} = {shape}"
    rows = []
    for key in itertools.product("SMB", repeat=inputs):
        asked = " and ".join(f"x{i} is {t}" for i, t in enumerate(key))
        rows.append(f"if {asked} then y is {draw(st.sampled_from(outs))}")
    return (
        f"controller c {{ input {names} in [0, 1] {{ partition S M B }} output y in [0, 10] {{ {body} }}\n"
        f"{infer} behavior A priority 1 {{ {chr(10).join(rows)} }} }}"
    )


@settings(max_examples=100)
@given(specs(), st.data())
def test_outputs_lie_in_the_reachable_interval(text, data):
    """The exact output at any input lies in the enclosure; both ends of the attained hull are values at peaks."""
    model, _ = from_text(text)
    assume(model is not None)
    (controller,) = model.controllers
    # Not every combination can be compiled, but all have a meaning.
    implies, aggregate = data.draw(st.sampled_from(["min", "product"])), data.draw(st.sampled_from(["max", "sum"]))
    controller = replace(controller, infer=replace(controller.infer, implies=implies, aggregate=aggregate))
    found = reach(controller, 0)
    assert found.lo <= found.hi
    for _ in range(12):
        at = {v.name: Fraction(data.draw(st.integers(0, 40)), 40) for v in controller.inputs}
        assert found.lo <= evaluate_controller_exactly(controller, at)["y"] <= found.hi
    if found.attained is not None:
        peaks = itertools.product(*([core(v, t) for t in range(len(v.terms))] for v in controller.inputs))
        values = {
            evaluate_controller_exactly(controller, dict(zip([v.name for v in controller.inputs], at, strict=True)))[
                "y"
            ]
            for at in peaks
        }
        assert set(found.attained) <= values
        assert found.lo <= found.attained[0] <= found.attained[1] <= found.hi


@pytest.mark.parametrize(
    ("output", "inference", "interval"),
    [
        ("partition S M B", "", ("1/6", "5/6")),
        ("partition S M B full", "", ("0", "1")),
        ("singletons S M B", "infer { defuzzify = weighted_average }", ("0", "1")),
        ("partition S at 0, M at 1/4, B at 1", "", ("1/12", "3/4")),
    ],
)
def test_known_intervals(output, inference, interval):
    """Without `full` a centroid over [0, 1] spans [1/6, 5/6]; with it, or with singletons, the whole range."""
    controller = the_controller(
        f"controller c {{ input x in [0, 1] {{ partition A B C }} output y in [0, 1] {{ {output} }} {inference}\n"
        "table y by x { A: S B: M C: B } }"
    )
    found = reach(controller, 0)
    assert (found.lo, found.hi) == tuple(Fraction(x) for x in interval)
    assert found.exact
    assert found.unused == ()


def test_terms_that_no_rule_uses_do_not_count():
    """Where no rule says B, the output does not reach it, and the report says so."""
    controller = the_controller(
        "controller c { input x in [0, 1] { partition A B C } output y in [0, 1] { singletons S M B }\n"
        "infer { defuzzify = weighted_average } table y by x { A: S B: M C: M } }"
    )
    found = reach(controller, 0)
    assert (found.lo, found.hi, found.unused) == (0, Fraction(1, 2), ("B",))


def test_a_column_inside_a_wide_term_is_not_taken_for_ordered():
    """A residual can lie right of both centroids, so the hull of single centroids is not claimed where terms nest."""
    controller = the_controller(
        "controller c { input x in [0, 1] { partition A B } output y in [0, 1] {\n"
        "term R = ramp_up(0, 1)\n"
        "term T = points((0.3, 0), (0.3, 0.3), (0.7, 0.3), (0.7, 1), (0.75, 1), (0.75, 0)) }\n"
        "table y by x { A: R B: T } }"
    )
    found = reach(controller, 0)
    assert found.means == "level sets"
    both = evaluate_controller_exactly(controller, {"x": Fraction(1, 2)})["y"]
    assert found.lo <= both <= found.hi
