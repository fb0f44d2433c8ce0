"""Certified bounds: never below what is seen, and small where they have to be."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from fuzzyspec import load
from fuzzyspec.exact import controller_point, dequantise, evaluate_controller
from fuzzyspec.fixed import run
from fuzzyspec.fixed.program import Program
from fuzzyspec.fixed.run import initial_state
from fuzzyspec.lower.bounds import Effort, bound_controller
from fuzzyspec.lower.controller import lower_controller
from fuzzyspec.lower.minors import applies as minors_apply
from fuzzyspec.lower.strategy import Precision, Strategy
from fuzzyspec.model.controller import Controller
from fuzzyspec.model.term import PiecewiseLinear
from tests.random_specs.generator import spec

ROOT = Path(__file__).resolve().parents[2]
SPECS = sorted((*ROOT.glob("examples/*.fz"), *ROOT.glob("benchmarks/*.fz")))
F = Fraction


def percent(name: str, function: str, output: str) -> Fraction:
    """A certified error as a percentage of the output's range."""
    folder = "examples" if name == "nav" else "benchmarks"
    found = load(ROOT / folder / f"{name}.fz").lowered.certificates[function].output(output).percent_of_range
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("name", "function", "outputs"),
    [("w2", "danger", ("ddc",)), ("w3", "velocity", ("v", "w")), ("w3s", "velocity", ("v", "w"))],
)
def test_the_workloads_are_certified_within_two_hundredths_of_a_percent(
    name: str, function: str, outputs: tuple[str, ...]
) -> None:
    """A mark of the project: the errors of W2, W3 and W3s are certified within 0.02 % of each output's range."""
    for output in outputs:
        assert percent(name, function, output) <= F(2, 100)


@pytest.mark.parametrize("output", ["v", "w"])
def test_the_navigation_step_is_certified_within_a_fifth_of_a_percent(output: str) -> None:
    """A mark of the project: the whole step, lists, quotients and two layers, within 0.2 % of each output's range."""
    assert percent("nav", "nav", output) <= F(1, 5)


@pytest.mark.parametrize("path", SPECS, ids=lambda p: p.stem)
def test_every_output_of_the_examples_has_a_bound(path: Path) -> None:
    """No output of an example or a workload goes without a certified error."""
    for certificate in load(path).lowered.certificates.values():
        assert all(o.error is not None for o in certificate.outputs)


# --- inputs that carry an error ----------------------------------------------------------------


WEIGHTED = """
module weighted
controller averaged {
    input  a, b in [0, 1] raw uint8 0..128 { partition L H }
    output y in [0, 1] raw uint16 0..65535 { singletons P Q  otherwise 0 }
    infer { and = product, or = probsum }
    rules {
        if a is L then y is P with 0.07
        if b is H and a is H then y is Q with 0.043
        if b is L or a is H then y is Q with 0.021
    }
}
controller centred {
    input  a, b in [0, 1] raw uint8 0..128 { partition L H }
    output y in [0, 1] raw uint16 0..65535 { partition P Q R  otherwise 0 }
    infer { or = probsum }
    rules {
        if a is L or b is L then y is P with 0.07
        if b is H and a is H then y is R with 0.043
    }
}
controller celled {
    input  a, b, c, d in [0, 1] raw uint8 0..128 { partition L H }
    output y in [0, 1] raw uint16 0..65535 { partition P Q R }
    infer { and = product }
    table y by a, b, c, d {
                   L H
        (L, L, L): P R
        (L, L, H): Q P
        (L, H, L): P P
        (L, H, H): R Q
        (H, L, L): R P
        (H, L, H): Q Q
        (H, H, L): P R
        (H, H, H): R P
    }
}
"""
"""Degrees are exact here, and strengths small: what rules round by is nearly all of the error."""


def controllers() -> list[tuple[str, Controller]]:
    """Those of the examples and workloads, and some random ones of every kind."""
    found = [(f"{p.stem}.{c.name}", c) for p in SPECS if "raw16" not in p.stem for c in load(p).module.controllers]
    found += [(f"weighted.{c.name}", c) for c in load(WEIGHTED).module.controllers]
    for seed in range(800, 812):
        found += [(f"{seed}.{c.name}", c) for c in load(spec(seed)).module.controllers]
    return found


CONTROLLERS = controllers()


def raws_of(controller: Controller, dice: np.random.Generator, n: int) -> dict[str, np.ndarray]:
    """Legal raws: any, the ends, and those around breakpoints."""
    found = {}
    for item in controller.inputs:
        raw = item.variable.raw
        bends = {raw.nearest(x) for t in item.terms if isinstance(t.shape, PiecewiseLinear) for x, _ in t.shape.points}
        special = sorted({min(max(b + d, raw.lo), raw.hi) for b in (*bends, raw.lo, raw.hi) for d in (-2, -1, 0, 1, 2)})
        some = dice.integers(raw.lo, raw.hi + 1, n)
        found[item.name] = np.where(dice.random(n) < 0.4, dice.choice(special, n), some)
    return found


@pytest.mark.parametrize(
    ("coarse", "precision"),
    [(0, "full"), (1 << 14, "full"), (100, "full"), (0, "short")],
    ids=["exact inputs", "fine errors", "coarse errors", "few bits"],
)
@pytest.mark.parametrize("name", [name for name, _ in CONTROLLERS])
def test_bounds_hold_for_inputs_that_are_off(name: str, coarse: int, precision: Precision) -> None:
    """Whatever the inputs really are, within their errors: the result is within the bound, decisions in their bands."""
    controller = dict(CONTROLLERS)[name]
    strategy = Strategy("minors" if minors_apply(controller) else "loops")
    function, numbers = lower_controller(controller, strategy, precision)
    errors = tuple(
        (i.variable.hi - i.variable.lo) / (coarse * (1 + k)) if coarse else F(0)
        for k, i in enumerate(controller.inputs)
    )
    bounds = bound_controller(numbers, errors, Effort(4000))
    dice = np.random.default_rng(3)
    n = 600
    raws = raws_of(controller, dice, n)
    program = Program("p", (function,))
    state = {k: np.full(n, v) for k, v in initial_state(program, function).items()}
    found = run(program, controller.name, raws, state, record=True, checked=True)
    values = {}
    for item, error in zip(controller.inputs, errors, strict=True):
        off = float(error) * dice.choice([-1.0, 1.0, 0.0, 0.5], n) * (1 - 1e-12)
        low, high = float(item.variable.lo), float(item.variable.hi)
        values[item.name] = np.clip(dequantise(item.variable, raws[item.name]) + off, low, high)
    holding = {o.name: o.variable for o in controller.outputs if o.name in state}
    held = {k: dequantise(v, state[k]) for k, v in holding.items()}
    exact = evaluate_controller(controller, values, found.decisions, held)
    for output in controller.outputs:
        mine = dequantise(output.variable, found.outputs[output.name])
        beyond = np.abs(mine - exact.outputs[output.name]) - float(bounds.errors[output.name])
        for at in np.argsort(-beyond)[:20]:
            if beyond[at] > 0:
                # float64 may tip a bound that is met to the last digit: rationals decide.
                point = controller_point(
                    controller,
                    {k: F(float(v[at])) for k, v in values.items()},
                    {k: int(v[at]) for k, v in found.decisions.items()},
                    {
                        o.name: o.variable.raw.value(int(state[o.name][at]))
                        for o in controller.outputs
                        if o.name in state
                    },
                )
                true = output.variable.raw.value(int(found.outputs[output.name][at]))
                assert abs(true - point.outputs[output.name]) <= bounds.errors[output.name], output.name
    widths = {b.key: float(b.width) for b in bounds.bands}
    for key, mine in found.decisions.items():
        otherwise = mine != exact.decisions[key]
        allowed = widths.get(key, 0.0) + 2.0**-40
        assert (exact.margins[key][otherwise] <= allowed).all(), key


def test_wider_errors_never_shrink_a_bound() -> None:
    """The bound grows with what the inputs are off by."""
    (controller,) = load(ROOT / "benchmarks" / "w2.fz").module.controllers
    _, numbers = lower_controller(controller, Strategy("minors" if minors_apply(controller) else "loops"))
    last = F(0)
    for bits in (30, 16, 12, 8):
        errors = tuple((i.variable.hi - i.variable.lo) / 2**bits for i in controller.inputs)
        bound = bound_controller(numbers, errors, Effort(8000)).errors["ddc"]
        assert bound >= last
        last = bound
