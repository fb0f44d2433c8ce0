"""Interpolation between places: all its programs, against the weighted average in rationals."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyspec import load
from fuzzyspec.exact import dequantise, evaluate_controller
from fuzzyspec.fixed.build import LIMITS
from fuzzyspec.fixed.program import Element, Program, Table, Window
from fuzzyspec.fixed.prune import expressions, nodes
from fuzzyspec.fixed.run import Run, run
from fuzzyspec.lower.bounds import Effort, bound_controller
from fuzzyspec.lower.choice import strategies
from fuzzyspec.lower.controller import lower_controller
from fuzzyspec.lower.corners import REACH
from fuzzyspec.lower.formats import TOLERATED, format_of
from fuzzyspec.lower.multilinear import applies, ways
from fuzzyspec.lower.strategy import Strategy
from fuzzyspec.model.controller import CellRules, Controller, Inference, Input, Output
from fuzzyspec.model.term import PiecewiseLinear, Singleton
from fuzzyspec.model.units import ONE
from fuzzyspec.model.variable import Raw, Variable
from tests.lower.lower_models import NOWHERE, input_of, membership, output_of, peaks, variables

ROOT = Path(__file__).resolve().parents[2]
F = Fraction


def interpolation(inputs: list[Input], outputs: list[Output], consequents: list[tuple[int, ...]]) -> Controller:
    """A controller of full tables, product and weighted average."""
    shape = tuple(len(i.terms) for i in inputs)
    cells = CellRules(shape, tuple(consequents), (0,) * math.prod(shape))
    infer = Inference(and_="product", aggregate="sum", defuzzify="weighted_average")
    sure = tuple(True for _ in outputs)
    return Controller("c", tuple(inputs), tuple(outputs), infer, F(1, 64), cells, (), (), sure, NOWHERE)


@st.composite
def controllers(draw: st.DrawFn) -> Controller:
    """One to four inputs, evenly spaced or not, one to three outputs with even or scattered places."""
    inputs: list[Input] = []
    for i in range(draw(st.integers(1, 4))):
        variable = draw(variables(f"x{i}"))
        if draw(st.booleans()):
            count = draw(st.integers(2, 8))
            span = variable.hi - variable.lo
            at = tuple(variable.lo + span * k / (count - 1) for k in range(count))
        else:
            at = draw(peaks(variable))
        inputs.append(input_of(variable, at))
    cells = math.prod(len(i.terms) for i in inputs)
    outputs: list[Output] = []
    consequents: list[tuple[int, ...]] = []
    smooth = draw(st.booleans())
    for o in range(draw(st.integers(1, 3))):
        variable = draw(variables(f"y{o}"))
        if draw(st.integers(0, 3)):
            count = draw(st.integers(1, 8))
            parts = [F(k, max(count - 1, 1)) for k in range(count)]
        else:
            parts = sorted(draw(st.sets(st.fractions(0, 1, max_denominator=997), min_size=1, max_size=6)))
        places = [variable.lo + (variable.hi - variable.lo) * p for p in parts]
        outputs.append(output_of(variable, [Singleton(p) for p in places]))
        seed = draw(st.integers(0, 10**6))
        dice = np.random.default_rng(seed)
        if smooth:
            index = np.indices([len(i.terms) for i in inputs]).sum(axis=0).reshape(-1)
            named = np.clip(index - seed % 3, 0, len(parts) - 1)
        else:
            named = dice.integers(0, len(parts), cells)
        consequents.append(tuple(int(t) for t in named))
    return interpolation(inputs, outputs, consequents)


def raws_of(controller: Controller, cases: int, seed: int) -> dict[str, np.typing.NDArray[np.int64]]:
    """Raws of the whole C types: ends, peaks, what lies beyond the range and anything between."""
    dice = np.random.default_rng(seed)
    found: dict[str, np.typing.NDArray[np.int64]] = {}
    for item in controller.inputs:
        raw = item.variable.raw
        assert item.peaks is not None
        at = [math.floor(raw.position(p)) + d for p in item.peaks for d in (0, 1)]
        marks = np.clip([raw.lo, raw.hi, *at, *LIMITS[raw.ctype]], *LIMITS[raw.ctype])
        anywhere = dice.integers(raw.lo, raw.hi + 1, cases)
        found[item.name] = np.where(dice.random(cases) < 0.4, dice.choice(marks, cases), anywhere)
    return found


def computed(controller: Controller, strategy: Strategy, inputs: dict[str, np.typing.NDArray[np.int64]]) -> Run:
    """One strategy's program, every value held against its interval."""
    function, _ = lower_controller(controller, strategy)
    return run(Program("p", (function,)), controller.name, inputs, checked=True)


def exactly(controller: Controller, raws: dict[str, int]) -> list[Fraction]:
    """The outputs by the definition: every cell's product of degrees, times its place, summed."""
    cells = controller.cells
    assert cells is not None
    degrees: list[list[Fraction]] = []
    for item in controller.inputs:
        raw = item.variable.raw
        x = raw.value(min(max(raws[item.name], raw.lo), raw.hi))
        row: list[Fraction] = []
        for term in item.terms:
            assert isinstance(term.shape, PiecewiseLinear)
            row.append(membership(term.shape, x))
        degrees.append(row)
    totals = [F(0)] * len(controller.outputs)
    for cell, at in enumerate(itertools.product(*(range(n) for n in cells.shape))):
        strength = math.prod((row[k] for row, k in zip(degrees, at, strict=True)), start=F(1))
        if strength:
            for o, output in enumerate(controller.outputs):
                shape = output.terms[cells.consequents[o][cell]].shape
                assert isinstance(shape, Singleton)
                totals[o] += strength * shape.at
    return totals


@settings(max_examples=60, deadline=None)
@given(controllers(), st.integers(0, 10**6))
def test_every_program_is_within_its_certificate_of_the_definition(controller: Controller, seed: int) -> None:
    """Packed, written out and in loops give the same raws, and none is farther from the rational weighted average than
    the certified bound."""
    assert applies(controller)
    inputs = raws_of(controller, 24, seed)
    every = strategies(controller)
    results = [computed(controller, s, inputs) for s in every]
    for other in results[1:]:
        assert np.array_equal(other.status, results[0].status)
        for name, raws in results[0].outputs.items():
            assert np.array_equal(other.outputs[name], raws), name
    _, numbers = lower_controller(controller, every[0])
    bounds = bound_controller(numbers, tuple(F(0) for _ in controller.inputs), Effort(64))
    for case in range(24):
        legal = {
            i.name: min(max(int(inputs[i.name][case]), i.variable.raw.lo), i.variable.raw.hi) for i in controller.inputs
        }
        wanted = exactly(controller, legal)
        for output, value in zip(controller.outputs, wanted, strict=True):
            got = output.variable.raw.value(int(results[0].outputs[output.name][case]))
            assert abs(got - value) <= bounds.errors[output.name], (case, output.name)


@settings(max_examples=60, deadline=None)
@given(controllers(), st.integers(0, 10**6))
def test_only_a_raw_outside_its_range_sets_its_bit(controller: Controller, seed: int) -> None:
    """The status tells of each input by itself, whichever way the raw is brought into the range."""
    inputs = raws_of(controller, 40, seed)
    function, _ = lower_controller(controller, Strategy())
    status = run(Program("p", (function,)), "c", inputs, checked=True).status
    for i in controller.inputs:
        outside = (inputs[i.name] < i.variable.raw.lo) | (inputs[i.name] > i.variable.raw.hi)
        names = [b.name for b in function.status]
        bit = f"SATURATED_{i.name.upper()}"
        told = (status >> names.index(bit)) & 1 if bit in names else np.zeros(40, dtype=np.int64)
        assert np.array_equal(told, outside)


def test_small_places_share_words() -> None:
    """W3s is computed two outputs to a word: one table of words, whose halves are the tables of the other programs."""
    (controller,) = load(ROOT / "benchmarks" / "w3s.fz").module.controllers
    assert ways(controller) == ("loops", "written", "packed")
    tables: dict[str, tuple[Table, ...]] = {
        s.interpolation: lower_controller(controller, s)[0].tables for s in strategies(controller)
    }
    (words,) = tables["packed"]
    v, w = tables["written"]
    assert (words.ctype, v.ctype, w.ctype) == ("uint32", "uint8", "uint8")
    assert [(x & 0xFFFF, x >> 16) for x in words.values] == list(zip(v.values, w.values, strict=True))
    assert tables["loops"][0].values == v.values + w.values


def test_words_are_read_within_reach() -> None:
    """Of W3s's 16 corners the farthest lie 40 words apart: a window opens where a load of Thumb would not reach."""
    (controller,) = load(ROOT / "benchmarks" / "w3s.fz").module.controllers
    packed, *_ = (s for s in strategies(controller) if s.interpolation == "packed")
    function, _ = lower_controller(controller, packed)
    windows = {s.name for s in function.body if isinstance(s, Window)}
    read = [n for e in expressions(function.body) for n in nodes(e) if isinstance(n, Element) and n.array in windows]
    assert len(windows) == 2
    assert len(read) == 16
    assert max(n.index.hi for n in read) == REACH


def a_raw(counts: int) -> Raw:
    """0 .. counts for 0 .. 1."""
    return Raw("uint16", F(1, counts), F(0), 0, counts)


@pytest.mark.parametrize(("steps", "narrow"), [(1, True), (6, True), (7, True), (12, True), (97, False)])
def test_places_that_are_no_small_multiples_stay_raw_counts(steps: int, narrow: bool) -> None:
    """A narrow place times a degree of 1 fits 16 bits, and is chosen only where that costs less than is tolerated."""
    own = Variable("x", F(0), F(1), ONE, a_raw(32768), NOWHERE)
    inputs = [input_of(own, (F(0), F(1, 2), F(1)))] * 2
    places = [F(k, steps) for k in range(steps + 1)]
    output = output_of(Variable("y", F(0), F(1), ONE, a_raw(60000), NOWHERE), [Singleton(p) for p in places])
    table = tuple(min(round((a + b) * steps / 4), steps) for a in range(3) for b in range(3))
    controller = interpolation(list(inputs), [output], [table])
    assert controller.cells is not None
    fmt = format_of(controller, controller.cells)
    assert fmt.narrow is narrow
    found = fmt.outputs[0]
    assert found.most << fmt.bits <= (65535 if narrow else 2**32 - 1)
    if narrow:
        assert found.most << (fmt.bits + 1) > 65535 or fmt.bits == 15
        assert fmt.rounding(0) <= TOLERATED * 60000
        exact = [found.base + found.unit * i for i in found.integers]
        assert exact == [places[t] * 60000 for t in table]


PD = """
module pd
controller pd {
    input  error in [-10, 10] { partition NB NM NS Z PS PM PB }
    input  rate in [-2, 2] { partition NB NM NS Z PS PM PB }
    output u in [-100, 100] { singletons NB NM NS Z PS PM PB }
    output hard in [0, 1] { term A = singleton(0)  term B = singleton(0.137)  term C = singleton(0.71) }
    infer { and = product, defuzzify = weighted_average }
    table u by error, rate {
             NB  NM  NS  Z   PS  PM  PB
        NB:  NB  NB  NB  NB  NM  NS  Z
        NM:  NB  NB  NB  NM  NS  Z   PS
        NS:  NB  NB  NM  NS  Z   PS  PM
        Z:   NB  NM  NS  Z   PS  PM  PB
        PS:  NM  NS  Z   PS  PM  PB  PB
        PM:  NS  Z   PS  PM  PB  PB  PB
        PB:  Z   PS  PM  PB  PB  PB  PB
    }
    table hard by error, rate {
             NB NM NS Z  PS PM PB
        NB:  C  C  B  B  B  C  C
        NM:  C  B  B  A  B  B  C
        NS:  B  B  A  A  A  B  B
        Z:   B  A  A  A  A  A  B
        PS:  B  B  A  A  A  B  B
        PM:  C  B  B  A  B  B  C
        PB:  C  C  B  B  B  C  C
    }
}
"""


def votes(n: int) -> str:
    """A spec of n inputs of two terms: how many of them are high decides."""
    rows = "".join(
        f"        ({', '.join(row)}): V{row.count('H')} V{row.count('H') + 1}\n"
        for row in itertools.product("LH", repeat=n - 1)
    )
    inputs = "".join(f"    input x{i} in [0, 1] {{ partition L H }}\n" for i in range(n))
    places = ", ".join(f"V{k} at {k * k}" for k in range(n + 1))
    return (
        f"module votes\ncontroller votes {{\n{inputs}    output y in [0, {n * n}] {{ singletons {places} }}\n"
        f"    infer {{ and = product, defuzzify = weighted_average }}\n    fires at 1/{2**n}\n"
        f"    table y by {', '.join(f'x{i}' for i in range(n))} {{\n        L H\n{rows}    }}\n}}\n"
    )


@pytest.mark.parametrize("inputs", [6, 8])
def test_many_inputs_are_interpolated_as_few_are(inputs: int) -> None:
    """No sum of many small products is divided: what is certified is two roundings of 15 bits an input at most."""
    (controller,) = load(votes(inputs)).module.controllers
    assert applies(controller) and ("written" in ways(controller)) == (inputs <= 6)
    _, numbers = lower_controller(controller, Strategy())
    error = bound_controller(numbers, tuple(F(0) for _ in controller.inputs), Effort(64)).errors["y"]
    assert error / (controller.outputs[0].variable.hi) < inputs * 2 * F(1, 2**15)


@pytest.mark.parametrize("spec", [str(ROOT / "benchmarks" / "w3s.fz"), PD, votes(7)], ids=["w3s", "pd", "votes"])
def test_a_certificate_is_not_far_from_what_is_seen(spec: str) -> None:
    """Over many raws the largest error keeps within its bound and comes to more than half of it: what the shifts, the
    products and the degrees of fewer bits add is all counted, and little else."""
    (controller,) = load(spec if "\n" in spec else Path(spec)).module.controllers
    function, numbers = lower_controller(controller, Strategy())
    bounds = bound_controller(numbers, tuple(F(0) for _ in controller.inputs), Effort(64))
    inputs = raws_of(controller, 200_000 if len(controller.inputs) < 5 else 20_000, 5)
    raws = run(Program("p", (function,)), controller.name, inputs).outputs
    values = {i.name: dequantise(i.variable, inputs[i.name]) for i in controller.inputs}
    exact = evaluate_controller(controller, values, {}, {})
    for output in controller.outputs:
        off = np.abs(dequantise(output.variable, raws[output.name]) - exact.outputs[output.name])
        assert off.max() <= float(bounds.errors[output.name])
        assert off.max() > float(bounds.errors[output.name]) / 2
