"""The benchmark specs hold the tables that their formulas give, in both sets of raws."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from pathlib import Path

import pytest

from fuzzyspec.check import check
from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.model.controller import Controller
from fuzzyspec.model.term import PiecewiseLinear, Singleton
from fuzzyspec.syntax import parse

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
SETS = ["", "_raw16"]


def controller(name: str) -> Controller:
    """The only controller of a benchmark."""
    source = Source(f"{name}.fz", (BENCHMARKS / f"{name}.fz").read_text(encoding="utf-8"))
    parsed, found = parse(source)
    module, found = check(parsed, source, found)
    assert module is not None, [d.message for d in found]
    assert module.name == name
    (only,) = module.controllers
    return only


def w1(s: int, f: int) -> tuple[int, ...]:
    """The tipper: 0 cheap, 1 average, 2 generous."""
    return (0 if s + f <= 1 else 1 if s + f == 2 else 2,)


def w2(t: int, d: int) -> tuple[int, ...]:
    """The paper's Table 1, rows eta_d."""
    return ("SMB".index(("BBB", "BMM", "BMS")[d][t]),)


def w3(a: int, b: int, c: int, t: int) -> tuple[int, ...]:
    """The velocity table of 81 rules."""
    return max(0, 4 - 2 * b - (a + c + abs(t - 1)) // 2), min(6, max(0, 3 + (a - c) + (t - 1) * (2 - b)))


@pytest.mark.parametrize("raws", SETS)
@pytest.mark.parametrize(("name", "formula"), [("w1", w1), ("w2", w2), ("w3", w3), ("w3s", w3)])
def test_tables_follow_their_formulas(name: str, formula: object, raws: str) -> None:
    """Every cell of every output holds the term that the formula names."""
    assert callable(formula)
    c = controller(name + raws)
    assert c.cells is not None
    for flat, indices in enumerate(product(*(range(len(i.terms)) for i in c.inputs))):
        assert tuple(o[flat] for o in c.cells.consequents) == formula(*indices), indices


@pytest.mark.parametrize("raws", SETS)
def test_shapes(raws: str) -> None:
    """W1's output terms are the triangles given; W3s has singletons at W3's peaks and the product."""
    tip = controller("w1" + raws).outputs[0]
    feet = [(0, 5, 10), (10, 15, 20), (20, 25, 30)]
    assert [t.shape for t in tip.terms] == [
        PiecewiseLinear(tuple((Fraction(x), Fraction(y)) for x, y in zip(foot, (0, 1, 0), strict=True)))
        for foot in feet
    ]
    shapes, singletons = controller("w3" + raws), controller("w3s" + raws)
    assert (shapes.infer.and_, shapes.infer.aggregate, shapes.infer.defuzzify) == ("min", "max", "centroid")
    assert (singletons.infer.and_, singletons.infer.defuzzify) == ("product", "weighted_average")
    for a, b in zip(shapes.outputs, singletons.outputs, strict=True):
        assert a.peaks is not None
        assert [t.shape for t in b.terms] == [Singleton(p) for p in a.peaks]
        assert not a.full


@pytest.mark.parametrize("name", ["w1", "w2", "w3", "w3s"])
def test_full_scale_raws(name: str) -> None:
    """In the second set every variable runs over counts 0..65535."""
    c = controller(name + "_raw16")
    for variable in [i.variable for i in c.inputs] + [o.variable for o in c.outputs]:
        raw = variable.raw
        assert (raw.ctype, raw.lo, raw.hi) == ("uint16", 0, 65535)
        assert (raw.value(0), raw.value(65535)) == (variable.lo, variable.hi)
