"""Variables, terms, inputs and outputs for the lowering's tests, drawn by hypothesis."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from fractions import Fraction

from hypothesis import strategies as st

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.model.controller import Fallback, Input, Output
from fuzzyspec.model.term import PiecewiseLinear, Shape, Singleton, Term
from fuzzyspec.model.units import ONE, Unit
from fuzzyspec.model.variable import RAW_LIMITS, CType, Raw, Variable

NOWHERE = Span(0, 0)
Points = tuple[tuple[Fraction, Fraction], ...]


def rationals(lo: int, hi: int) -> st.SearchStrategy[Fraction]:
    """Short rationals of an interval."""
    return st.builds(
        lambda d, part: lo + Fraction(math.floor(part * (hi - lo) * d), d) if part < 1 else Fraction(hi),
        st.sampled_from([1, 2, 3, 7, 10, 100, 997]),
        st.fractions(0, 1, max_denominator=10**6) | st.sampled_from([Fraction(0), Fraction(1)]),
    )


@st.composite
def variables(draw: st.DrawFn, name: str = "x", unit: Unit = ONE, most: int = 65535) -> Variable:
    """Any range with any raw: steps that divide it or not, counts up or down, ends that are raws or not."""
    lo = draw(rationals(-50, 50))
    span = draw(st.sampled_from([Fraction(1, 1000), Fraction(1), Fraction(7), Fraction(60000)]) | rationals(1, 90))
    return draw(over(name, lo, lo + span, unit, most))


@st.composite
def over(draw: st.DrawFn, name: str, lo: Fraction, hi: Fraction, unit: Unit = ONE, most: int = 65535) -> Variable:
    """A variable of this range, with any raw."""
    ctype: CType = draw(st.sampled_from(list(RAW_LIMITS)))
    low, high = RAW_LIMITS[ctype]
    counts = draw(st.integers(2, min(high - low, most)) | st.just(min(high - low, most)))
    first = draw(st.integers(low, high - counts) | st.just(low))
    # The ends lie a part of a count beyond the first and last legal raw.
    below, above = (draw(st.sampled_from([0, 0, 0, Fraction(1, 3), Fraction(9, 10)])) for _ in "ab")
    step = (hi - lo) / (counts + below + above)
    if draw(st.booleans()):
        raw = Raw(ctype, -step, lo + step * (below + first + counts), first, first + counts)
    else:
        raw = Raw(ctype, step, lo + step * (below - first), first, first + counts)
    return Variable(name, lo, hi, unit, raw, NOWHERE)


def ends_are_legal(variable: Variable) -> bool:
    """Whether a drawn variable's legal raws are what the model promises: all whose value lies inside the range."""
    values = [variable.raw.value(variable.raw.lo), variable.raw.value(variable.raw.hi)]
    step = abs(variable.raw.step)
    return variable.lo <= min(values) < variable.lo + step and variable.hi - step < max(values) <= variable.hi


@st.composite
def peaks(draw: st.DrawFn, variable: Variable, most: int = 7) -> tuple[Fraction, ...]:
    """Peaks of a partition: the range's ends among them or not, raws or not, close together now and then."""
    span = variable.hi - variable.lo
    places = draw(
        st.lists(
            st.fractions(0, 1, max_denominator=1000) | st.sampled_from([Fraction(0), Fraction(1)]),
            min_size=2,
            max_size=most,
            unique=True,
        )
    )
    return tuple(variable.lo + span * p for p in sorted(places))


def partition(at: Sequence[Fraction]) -> tuple[PiecewiseLinear, ...]:
    """Triangles of a strong partition, the ends shouldered."""
    last = len(at) - 1
    shapes: list[PiecewiseLinear] = []
    for k, p in enumerate(at):
        before = ((at[k - 1], Fraction(0)),) if k else ()
        after = ((at[k + 1], Fraction(0)),) if k < last else ()
        shapes.append(PiecewiseLinear((*before, (p, Fraction(1)), *after)))
    return tuple(shapes)


@st.composite
def shapes(draw: st.DrawFn, variable: Variable, most: int = 6) -> PiecewiseLinear:
    """Points in order, two or three at one place now and then (jumps, spikes), some beyond the range."""
    span = variable.hi - variable.lo
    count = draw(st.integers(1, most))
    grid = draw(st.sampled_from([4, 8, 97, 1000]))
    xs = sorted(draw(st.lists(st.integers(-grid // 4, grid + grid // 4), min_size=count, max_size=count)))
    heights = st.sampled_from([Fraction(0), Fraction(1)]) | st.fractions(0, 1, max_denominator=100)
    return PiecewiseLinear(tuple((variable.lo + span * Fraction(x, grid), draw(heights)) for x in xs))


def terms(of: Sequence[Shape]) -> tuple[Term, ...]:
    """Terms T0, T1 .."""
    return tuple(Term(f"T{k}", shape, NOWHERE) for k, shape in enumerate(of))


def input_of(variable: Variable, at: Sequence[Fraction]) -> Input:
    """An input with a strong partition."""
    return Input(variable, terms(partition(at)), tuple(at))


def output_of(variable: Variable, of: Sequence[Shape], fallback: Fallback | None = None) -> Output:
    """An output whose terms are integrated over the range."""
    return Output(variable, terms(of), None, False, variable.lo, variable.hi, fallback)


def full_output(variable: Variable, at: Sequence[Fraction]) -> Output:
    """An output with a ``full`` partition; its end peaks lie on the range's ends."""
    first, last = at[1] - at[0], at[-1] - at[-2]
    own = list(partition(at))
    own[0] = PiecewiseLinear(((at[0] - first, Fraction(0)), *own[0].points))
    own[-1] = PiecewiseLinear((*own[-1].points, (at[-1] + last, Fraction(0))))
    lo, hi = variable.lo - first, variable.hi + last
    return Output(variable, terms(own), tuple(at), True, lo, hi, None)


def has_area(shape: Shape, lo: Fraction, hi: Fraction) -> bool:
    """Whether a shape is positive on a stretch of ``lo .. hi``."""
    assert not isinstance(shape, Singleton)
    cuts = sorted({lo, hi, *(x for x, _ in shape.points if lo < x < hi)})
    return any(membership(shape, (a + b) / 2) > 0 for a, b in itertools.pairwise(cuts))


def membership(shape: Shape, x: Fraction) -> Fraction:
    """The definition: linear between the points, constant beyond them, the largest value at a jump."""
    if isinstance(shape, Singleton):
        return Fraction(int(x == shape.at))
    here = [y for px, y in shape.points if px == x]
    if here:
        return max(here)
    before = [p for p in shape.points if p[0] < x]
    after = [p for p in shape.points if p[0] > x]
    if not before or not after:
        return (after or before)[0 if after else -1][1]
    (x0, y0), (x1, y1) = before[-1], after[0]
    return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
