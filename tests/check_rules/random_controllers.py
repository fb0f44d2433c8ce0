"""Random controllers over irregular terms, as text, and their strengths word by word from the definitions."""

from __future__ import annotations

import itertools
from fractions import Fraction
from math import prod

from hypothesis import strategies as st

from fuzzyspec.model.controller import And, Is, Not, Or

PLACES = st.integers(-4, 44).map(lambda k: Fraction(k, 4))
"""Quarters on and around the range [0, 10] of every input."""


@st.composite
def terms(draw, names):
    """A term declaration for each name: any of the shapes, jumps included."""
    found = []
    for name in names:
        a, b, c, d = sorted(draw(st.lists(PLACES, min_size=4, max_size=4)))
        shapes = [f"points(({a}, 1/4), ({b}, 1), ({b}, 1/3), ({d}, 1/2))"]
        if a < b:
            shapes += [f"ramp_up({a}, {b})", f"ramp_down({a}, {b})", f"trapezoid({a}, {b}, {c}, {d})"]
        if a < d:
            shapes += [f"triangle({a}, {c}, {d})"]
        found.append(f"term {name} = {draw(st.sampled_from(shapes))}")
    return " ".join(found)


@st.composite
def conditions(draw, inputs, depth=2):
    """A condition of a sentence rule."""
    kind = draw(st.sampled_from(["is", "is not", "in", "and", "or", "not"] if depth else ["is", "is not", "in"]))
    variable, names = draw(st.sampled_from(inputs))
    if kind in ("is", "is not"):
        return f"{variable} {kind} {draw(st.sampled_from(names))}"
    if kind == "in":
        chosen = draw(st.lists(st.sampled_from(names), min_size=1, unique=True))
        return f"{variable} in {{{', '.join(chosen)}}}"
    if kind == "not":
        return f"not ({draw(conditions(inputs, depth - 1))})"
    parts = draw(st.lists(conditions(inputs, depth - 1), min_size=2, max_size=3))
    return "(" + f" {kind} ".join(parts) + ")"


@st.composite
def controllers(draw, norms=("min", "product"), conorms=("max", "probsum")):
    """A controller that always has an `otherwise`, so that gaps are no error."""
    inputs = [(f"x{i}", [f"T{k}" for k in range(draw(st.integers(1, 3)))]) for i in range(draw(st.integers(1, 3)))]
    lines = ["controller c {"]
    for name, names in inputs:
        shapes = f"partition {' '.join(names)}" if len(names) > 1 and draw(st.booleans()) else draw(terms(names))
        lines.append(f"input {name} in [0, 10] {{ {shapes} }}")
    lines.append("output y in [0, 1] { partition S M B otherwise 0 }")
    lines.append(f"infer {{ and = {draw(st.sampled_from(norms))}, or = {draw(st.sampled_from(conorms))} }}")
    lines.append(f"fires at {draw(st.sampled_from(['1/64', '1/4', '1/2']))}")
    if draw(st.booleans()):
        lines.append("behavior A priority 1 {")
        for _ in range(draw(st.integers(1, 4))):
            asked = [
                f"{name} in {{{', '.join(draw(st.lists(st.sampled_from(names), min_size=1, unique=True)))}}}"
                for name, names in inputs
            ]
            # One consequent for all, so that no two rules disagree.
            lines.append(f"if {' and '.join(asked)} then y is M")
    else:
        lines.append("rules {")
        for _ in range(draw(st.integers(1, 4))):
            weight = draw(st.sampled_from(["", " with 1/2", " with 0.9"]))
            lines.append(f"if {draw(conditions(inputs))} then y is {draw(st.sampled_from('SMB'))}{weight}")
    return "\n".join([*lines, "}", "}"])


# --- strengths, from the definitions -----------------------------------------------------------


def membership(term, x):
    """Linear between corners, constant beyond, the largest value at a jump."""
    corners = term.shape.points
    here = [y for at, y in corners if at == x]
    if here:
        return max(here)
    below = [p for p in corners if p[0] < x]
    above = [p for p in corners if p[0] > x]
    if not below or not above:
        return (below[-1] if below else above[0])[1]
    (x0, y0), (x1, y1) = below[-1], above[0]
    return y0 + (y1 - y0) * (x - x0) / (x1 - x0)


def strength(controller, at):
    """The strongest strength over all rules that set the only output."""
    degrees = [[membership(t, x) for t in v.terms] for v, x in zip(controller.inputs, at, strict=True)]
    conj = min if controller.infer.and_ == "min" else prod
    disj = max if controller.infer.or_ == "max" else (lambda values: 1 - prod(1 - v for v in values))

    def truth(a):
        match a:
            case Is(i, chosen):
                return disj([degrees[i][t] for t in chosen])
            case Not(operand):
                return 1 - truth(operand)
            case And(operands):
                return conj([truth(o) for o in operands])
            case Or(operands):
                return disj([truth(o) for o in operands])

    found = [Fraction(0)] + [rule.weight * truth(rule.antecedent) for rule in controller.sentences]
    if controller.cells is not None:
        for flat, cell in enumerate(itertools.product(*(range(len(v.terms)) for v in controller.inputs))):
            if controller.cells.consequents[0][flat] >= 0:
                found.append(conj([ds[t] for ds, t in zip(degrees, cell, strict=True)]))
    return max(found)
