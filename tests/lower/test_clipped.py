"""Closed forms of clipped sets against integration by other means."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from fractions import Fraction

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fuzzyspec.lower.clipped import MAX_SETS, ClippedSet, TooManySets, clipped_sets
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.sets import closed_form
from fuzzyspec.model.controller import Output
from fuzzyspec.model.term import PiecewiseLinear
from fuzzyspec.model.units import ONE
from fuzzyspec.model.variable import Raw, Variable
from tests.lower.lower_models import (
    NOWHERE,
    full_output,
    has_area,
    membership,
    output_of,
    partition,
    peaks,
    shapes,
    variables,
)

F = Fraction
Function = Callable[[F], F]
SLACK = F(2) ** -44
"""How far the tabulated closed form may be from the rational one (float64, lemma of the centroid)."""


def integrals(of: Function, cuts: Sequence[F]) -> tuple[F, F]:
    """Area and first moment (about 0) of a function that is a straight line between neighbouring cuts.

    Each line is told from two points inside its stretch, so what holds at the cuts themselves does not matter.
    """
    area = moment = F(0)
    for a, b in itertools.pairwise(cuts):
        third = (b - a) / 3
        y1, y2 = of(a + third), of(b - third)
        ya, yb = 2 * y1 - y2, 2 * y2 - y1
        area += (b - a) * (ya + yb) / 2
        # Simpson's rule is exact for what t * (a line) is.
        moment += (b - a) * (a * ya + (a + b) * (ya + yb) + b * yb) / 6
    return area, moment


def relative(output: Output) -> tuple[list[PiecewiseLinear], F, F]:
    """Terms and domain of integration in relative positions."""
    lo, span = output.variable.lo, output.variable.hi - output.variable.lo
    shapes = [PiecewiseLinear(tuple(((x - lo) / span, y) for x, y in _shape(t.shape).points)) for t in output.terms]
    return shapes, (output.integrate_lo - lo) / span, (output.integrate_hi - lo) / span


def _shape(shape: object) -> PiecewiseLinear:
    assert isinstance(shape, PiecewiseLinear)
    return shape


def cuts_of(shapes: Sequence[PiecewiseLinear], levels: Sequence[F], left: F, right: F) -> list[F]:
    """Everywhere that any of the shapes can bend, cross another, or cross a level."""
    corners = sorted({left, right, *(x for s in shapes for x, _ in s.points if left < x < right)})
    cuts = set(corners)
    for a, b in itertools.pairwise(corners):
        third = (b - a) / 3
        lines = [(membership(s, a + third), membership(s, b - third)) for s in shapes] + [(c, c) for c in levels]
        for i, (p0, p1) in enumerate(lines):
            for q0, q1 in lines[:i]:
                if p0 - q0 != p1 - q1:
                    at = a + third + third * (p0 - q0) / ((p0 - q0) - (p1 - q1))
                    if a < at < b:
                        cuts.add(at)
    return sorted(cuts)


def evaluated(form: ClippedSet, c: F) -> tuple[F, F]:
    """Area and moment about 0 that the closed form gives at a clip height."""
    c = min(c, form.height)
    for p in form.pieces:
        if p.start <= c <= p.end:
            area = p.area + sum(w * (c ** (i + 1) - p.start ** (i + 1)) / (i + 1) for i, w in enumerate(p.width))
            about = p.moment + sum(v * (c ** (i + 1) - p.start ** (i + 1)) / (i + 1) for i, v in enumerate(p.first))
            return area, form.reference * area + form.moment_sign * about
    raise AssertionError("no piece holds the height")


@st.composite
def outputs(draw: st.DrawFn, most: int = 4) -> Output:
    """Any output: irregular shapes that overlap as they like, partitions, full ones."""
    variable = draw(variables(most=300))
    kind = draw(st.sampled_from(["shapes", "shapes", "partition", "full"]))
    if kind == "shapes":
        own = draw(st.lists(shapes(variable, most=5), min_size=1, max_size=most))
        assume(all(has_area(s, variable.lo, variable.hi) for s in own))
        return output_of(variable, own)
    at = sorted({variable.lo, variable.hi, *draw(peaks(variable, most=5))})
    if kind == "full":
        return full_output(variable, at)
    own = [s for s in partition(at) if has_area(s, variable.lo, variable.hi)]
    return output_of(variable, own)


HEIGHTS = st.sampled_from([F(0), F(1)]) | st.fractions(0, 1, max_denominator=64)


@settings(max_examples=60)
@given(output=outputs(), c=HEIGHTS)
def test_closed_forms_are_the_integrals(output: Output, c: F) -> None:
    """Each set's area and moment at any clip height are those of the pointwise minimum of its terms, clipped there."""
    own, left, right = relative(output)
    found = clipped_sets(output)
    cuts = cuts_of(own, [c], left, right)
    for form in found:
        members = [own[k] for k in form.members]
        expected = integrals(lambda t, m=members: min(c, *(membership(s, t) for s in m)), cuts)
        assert evaluated(form, c) == expected


@settings(max_examples=60)
@given(output=outputs(), data=st.data())
def test_inclusion_exclusion_gives_the_union(output: Output, data: st.DataObject) -> None:
    """The signed sum over all sets, each clipped at its lowest member, is area and moment of the envelope's."""
    own, left, right = relative(output)
    clips = [data.draw(HEIGHTS) for _ in own]
    signed = [F(0), F(0)]
    for form in clipped_sets(output):
        height = min(clips[k] for k in form.members)
        for i, part in enumerate(evaluated(form, height)):
            signed[i] += form.sign * part
    cuts = cuts_of(own, clips, left, right)
    envelope = integrals(lambda t: max(min(c, membership(s, t)) for c, s in zip(clips, own, strict=True)), cuts)
    assert tuple(signed) == envelope


@settings(max_examples=40)
@given(output=outputs())
def test_sets_are_those_with_common_support(output: Output) -> None:
    """A set is there if and only if its terms overlap on some stretch, once, with the sign of its size."""
    own, left, right = relative(output)
    cuts = cuts_of(own, [], left, right)
    middles = [(a + b) / 2 for a, b in itertools.pairwise(cuts)]
    together = {
        frozenset(k for k in range(len(own)) if 1 << k & mask)
        for t in middles
        for here in [sum(1 << k for k, s in enumerate(own) if membership(s, t) > 0)]
        for mask in range(1, here + 1)
        if mask & here == mask
    }
    found = clipped_sets(output)
    assert sorted(f.members for f in found) == sorted(tuple(sorted(s)) for s in together)
    assert all(f.sign == (-1) ** (len(f.members) + 1) for f in found)


@settings(max_examples=25)
@given(output=outputs(), data=st.data())
def test_the_tabulated_closed_form(output: Output, data: st.DataObject) -> None:
    """The float64 tables of every set are within their slack of the rational closed form, moments never negative."""
    for form in clipped_sets(output):
        area, moment = closed_form(form)
        assert area.min() >= 0 and moment.min() >= -float(SLACK)
        for i in (0, DEGREE_ONE, data.draw(st.integers(0, DEGREE_ONE))):
            true_area, about_0 = evaluated(form, F(i, DEGREE_ONE))
            assert abs(F(float(area[i])) - true_area) <= SLACK
            if form.moment_sign:
                own = (about_0 - form.reference * true_area) * form.moment_sign
                assert own >= 0
                assert abs(F(float(moment[i])) - own) <= SLACK
            else:
                assert about_0 == form.reference * true_area


def test_more_than_64_sets_are_refused() -> None:
    """Six terms that all overlap have 63 sets; seven have 127, which is too many."""
    x = Variable("x", F(0), F(1), ONE, Raw("uint16", F(1, 1000), F(0), 0, 1000), NOWHERE)
    ramps = [PiecewiseLinear(((F(0), F(1)), (F(k + 1), F(0)))) for k in range(7)]
    assert len(clipped_sets(output_of(x, ramps[:6]))) == MAX_SETS - 1
    with pytest.raises(TooManySets):
        clipped_sets(output_of(x, ramps))
