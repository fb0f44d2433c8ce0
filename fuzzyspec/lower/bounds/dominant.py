"""What a bound is owed to, told in the spec's words: where the inputs lie, and the kernel that adds most of it."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from fuzzyspec.fixed.certificate import Dominant
from fuzzyspec.lower.bounds.outputs import AverageBound, CentroidBound
from fuzzyspec.lower.bounds.strengths import Boxes, Strengths
from fuzzyspec.model.controller import Controller, Input, Output


def dominant(strengths: Strengths, bound: CentroidBound | AverageBound, output: int, box: Boxes) -> Dominant:
    """Of the one box where an output's bound is largest."""
    name = strengths.controller.outputs[output].name
    parts = bound.parts(strengths.levels(box)[output])
    degrees, rounding = float(parts.degrees[0]), float(parts.rounding[0])
    shares = {f"areas and moments of {name}": rounding, f"quotient and rounding of {name}": parts.tail}
    if isinstance(bound, AverageBound):
        shares = {f"products and sums of {name}": rounding, f"quotient and rounding of {name}": parts.tail}
    if np.isfinite(degrees):
        # What each adds if it alone errs; together they may be less than their sum.
        alone = {f"degrees of {item.name}": strengths.alone(i) for i, item in enumerate(strengths.controller.inputs)}
        alone["strengths of the rules"] = strengths.alone(None)
        shares |= {k: float(bound.parts(s.levels(box)[output]).degrees[0]) for k, s in alone.items()}
        total = max(sum(shares.values()), 2.0**-1000)
    else:
        shares, total = {f"the area of {name}, which can come too near 0": 1.0}, 1.0
    kernel = max(shares, key=lambda k: shares[k])
    return Dominant(where(strengths, box), kernel, min(100, round(100 * shares[kernel] / total)))


def added_up(
    strengths: Strengths, output: int, degrees: tuple[Boxes, list[float]], rest: tuple[Boxes, float, float]
) -> Dominant:
    """Of a bound that is added up: where degrees' roundings do most and each input's part; where all the rest does."""
    controller = strengths.controller
    name = controller.outputs[output].name
    shares = {f"degrees of {i.name}": s for i, s in zip(controller.inputs, degrees[1], strict=True)}
    shares |= {f"areas and moments of {name}": rest[1], f"quotient and rounding of {name}": rest[2]}
    kernel = max(shares, key=lambda k: shares[k])
    of_degrees = sum(degrees[1]) > rest[1] + rest[2]
    percent = round(100 * shares[kernel] / (sum(shares.values()) or 1.0))
    return Dominant(where(strengths, degrees[0] if of_degrees else rest[0]), kernel, percent)


def dominant_edge(
    controller: Controller, output: Output, edges: tuple[Fraction, ...], off: list[Fraction], rounding: Fraction
) -> Dominant:
    """Of an interpolation, whose lemma speaks of all inputs at once."""
    shares = {
        f"degrees of {i.name}, where neighbouring cells are furthest apart": e * d
        for i, e, d in zip(controller.inputs, edges, off, strict=True)
    }
    shares[f"places and interpolation of {output.name}"] = rounding
    kernel = max(shares, key=lambda k: shares[k])
    total = sum(shares.values(), Fraction(0)) or Fraction(1)
    return Dominant("anywhere", kernel, round(100 * shares[kernel] / total))


def otherwise_rounded(output: Output) -> Dominant:
    """Of an output that errs most where nothing fires."""
    return Dominant("where nothing fires", f"rounding of the value that {output.name} has otherwise", 100)


def carried_on(strengths: Strengths, output: int, box: Boxes, shares: list[float]) -> Dominant:
    """Of a bound that is most of all an input's error; ``shares`` are the inputs', of any unit."""
    controller = strengths.controller
    i = max(range(len(shares)), key=lambda k: shares[k])
    kernel = f"error of {controller.inputs[i].name}, times how steep {controller.outputs[output].name} is there"
    return Dominant(where(strengths, box), kernel, round(100 * shares[i] / (sum(shares) or 1.0)))


def where(strengths: Strengths, box: Boxes) -> str:
    """A box in the spec's words: its middle, and the terms that are active there."""
    return ", ".join(
        _place(item, [t.name for t, b in zip(item.terms, row, strict=True) if b.hi[0] > 0], box.lo[0, i], box.hi[0, i])
        for i, (item, row) in enumerate(zip(strengths.controller.inputs, strengths.degrees(box), strict=True))
    )


def _place(item: Input, active: list[str], lo: float, hi: float) -> str:
    """``eta_t near 1.5 s (TS, TM)``: the middle of a box, which is small where a search has ended."""
    variable = item.variable
    middle = variable.lo + (variable.hi - variable.lo) * Fraction((float(lo) + float(hi)) / 2)
    value = f"{float(middle):.5g} {variable.unit.symbol}".rstrip()
    return f"{item.name} near {value} ({', '.join(active)})" if active else f"{item.name} near {value}"
