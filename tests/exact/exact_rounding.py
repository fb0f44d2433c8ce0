"""How far float64 may be from the rationals, worked out from the operations that were done.

With u = 2^-53, every operation is off by at most u times its result. To first order, which is all that counts at
these sizes (the second order is u times smaller; every count below is rounded up by more than that):

degree      start + (x - x_i) / length * rise. Rounding x_i moves it by u |x_i| (once more where that puts x on the
            other side of a cut), which the slope turns into a degree; six operations and constants on numbers up to 1.
strength    min and max pass the largest error on, a product of numbers up to 1 the sum, a + b - a b the sum too; four u
            an operation; weights one constant and one operation.
level       max passes the largest error on; a sum over R rules R of them, and R additions of numbers up to R.
envelope    left + t rise (or that times the level): six u times the level's size H; a bend that is misplaced by dt
            puts the trapezoid off by (change of slope) dt, at most 8 u H. Together 16 u H beyond the level's error.
area        a stretch of width w between P places: P additions and ten more operations on what is at most H w; then the
            sum over n stretches (over R rules again for clipped sums).
inputs      where an input is itself off by e, its degrees are by slope e more.
centroid    (M + dM) / (A + dA) - M / A, with M / A <= W the width: (dM + W dA) / (A - dA); one quotient, one
            addition of the low end, both rounded.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from fractions import Fraction

from fuzzyspec.exact import Point
from fuzzyspec.model.controller import And, Antecedent, Controller, Input, Is, Not, Or, Output
from fuzzyspec.model.term import PiecewiseLinear

U = Fraction(1, 2**53)


NOTHING: Mapping[str, Fraction] = {}


def degree_error(inp: Input, inputs: Mapping[str, Fraction] = NOTHING) -> Fraction:
    """Of any degree of an input's terms; ``inputs`` gives the errors of those that are off themselves."""
    worst = steepest = Fraction(0)
    for term in inp.terms:
        if isinstance(term.shape, PiecewiseLinear):
            for (x0, y0), (x1, y1) in itertools.pairwise(term.shape.points):
                if x1 > x0:  # a jump has no slope
                    slope = abs((y1 - y0) / (x1 - x0))
                    steepest = max(steepest, slope)
                    worst = max(worst, slope * max(abs(x0), abs(x1)))
    return U * (2 * worst + 8) + steepest * inputs.get(inp.name, Fraction(0))


def _truth_error(antecedent: Antecedent, of: Controller, inputs: Mapping[str, Fraction]) -> Fraction:
    match antecedent:
        case Is(number, terms):
            return len(terms) * (degree_error(of.inputs[number], inputs) + 4 * U)
        case Not(operand):
            return _truth_error(operand, of, inputs) + U
        case And(operands) | Or(operands):
            return sum((_truth_error(o, of, inputs) + 4 * U for o in operands), Fraction(0))


def strength_error(of: Controller, inputs: Mapping[str, Fraction] = NOTHING) -> Fraction:
    """Of any rule's strength."""
    cells = sum((degree_error(i, inputs) + U for i in of.inputs), Fraction(0)) if of.cells else Fraction(0)
    return max([cells, *(_truth_error(r.antecedent, of, inputs) + 2 * U for r in of.sentences)])


def _rules(of: Controller, output: int) -> int:
    cells = sum(1 for c in of.cells.consequents[output] if c >= 0) if of.cells else 0
    return cells + sum(1 for r in of.sentences for o, _ in r.consequents if o == output)


def output_error(
    of: Controller, output: Output, point: Point, inputs: Mapping[str, Fraction] = NOTHING
) -> Fraction | None:
    """Of an output at a point, None where the area is too small for any bound."""
    area = point.areas[output.name]
    if area == 0 and not point.decisions.get(f"fires.{output.name}", 1):
        return U * abs(point.outputs[output.name])  # a constant, rounded
    number, terms = of.outputs.index(output), len(output.terms)
    rules = _rules(of, number) if of.infer.aggregate == "sum" else 1
    level = rules * (strength_error(of, inputs) + rules * U)
    width = output.integrate_hi - output.integrate_lo
    if of.infer.defuzzify == "weighted_average":
        area_error = terms * (level + (terms + 3) * rules * U)
        moment_error = width * area_error
    else:
        bends = sum(len(t.shape.points) for t in output.terms if isinstance(t.shape, PiecewiseLinear))
        cuts = (bends + 1) * (1 + terms * terms)
        relative = (16 + 10 + terms * terms + cuts + rules * terms) * U
        area_error = width * (level + relative * rules)
        moment_error = width * width * (level + (relative + 10 * U) * rules)
    if area <= area_error:
        return None
    ends = max(abs(output.integrate_lo), abs(output.integrate_hi))
    return (moment_error + width * area_error) / (area - area_error) + U * (3 * width + 2 * ends)
