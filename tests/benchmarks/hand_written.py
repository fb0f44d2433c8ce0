"""Inference over samples, written once more in numpy: for each input by itself, straight from the shapes."""

from __future__ import annotations

from itertools import product

import numpy as np

from fuzzyspec.model.controller import Controller, Output
from fuzzyspec.model.term import PiecewiseLinear, Singleton, Term


def sampled(controller: Controller, values: dict[str, float], parts: int, *, ends: bool) -> dict[str, float]:
    """Outputs of one input. Samples lie at the ends of ``parts`` parts, the outermost included, or in their middles."""
    degrees = [[_at(t, values[i.name]) for t in i.terms] for i in controller.inputs]
    cells = controller.cells
    assert cells is not None
    found = {}
    for output, consequents in zip(controller.outputs, cells.consequents, strict=True):
        levels = [0.0] * len(output.terms)
        for at, term in zip(product(*degrees), consequents, strict=True):
            strength = min(at) if controller.infer.and_ == "min" else float(np.prod(at))
            joined = max(levels[term], strength) if controller.infer.aggregate == "max" else levels[term] + strength
            levels[term] = joined
        found[output.name] = _defuzzified(output, levels, parts, ends)
    return found


def _at(term: Term, x: float) -> float:
    assert isinstance(term.shape, PiecewiseLinear)
    points = [(float(a), float(b)) for a, b in term.shape.points]
    return float(np.interp(x, [a for a, _ in points], [b for _, b in points]))


def _defuzzified(output: Output, levels: list[float], parts: int, ends: bool) -> float:
    places = [float(t.shape.at) for t in output.terms if isinstance(t.shape, Singleton)]
    if places:
        return float(np.dot(levels, places) / sum(levels))
    lo, hi = float(output.integrate_lo), float(output.integrate_hi)
    edges = np.linspace(lo, hi, parts + 1)
    ys = edges if ends else (edges[:-1] + edges[1:]) / 2
    heights = [max(min(_at(t, y), a) for t, a in zip(output.terms, levels, strict=True)) for y in ys]
    return float(np.dot(heights, ys) / sum(heights))
