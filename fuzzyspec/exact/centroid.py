"""Area and moment of the union of implied sets: the envelope integrated stretch by stretch, nothing sampled.

The output axis is cut where any term bends and, for clipping, where two terms cross. Between two cuts every term is a
line and the lines keep their order, so the envelope can only bend where a line meets a clip height (clip), or where
two scaled lines meet (product). Those places are found per case and sorted; between them the envelope is linear
and trapezoids are exact.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Literal

import numpy as np

from fuzzyspec.exact.membership import Knot, knots
from fuzzyspec.exact.result import Floats
from fuzzyspec.model.controller import Output
from fuzzyspec.model.term import PiecewiseLinear

Implies = Literal["min", "product"]


@dataclass(frozen=True, slots=True)
class Stretch:
    """Part of the axis where every term is linear. ``start`` is measured from ``integrate_lo``.

    ``terms`` are those that are positive here; ``left`` and ``right`` (terms, 1) their values as the ends are come to
    from inside.
    """

    start: float
    width: float
    terms: tuple[int, ...]
    left: Floats
    right: Floats


@lru_cache(maxsize=1024)
def stretches(output: Output, implies: Implies, only: int | None = None) -> tuple[Stretch, ...]:
    """The axis of an output, cut; of all its terms, or of term ``only``."""
    lo, hi = output.integrate_lo, output.integrate_hi
    lines: list[tuple[Knot, ...]] = []
    for number, term in enumerate(output.terms):
        if not isinstance(term.shape, PiecewiseLinear):
            raise ValueError(f"term {term.name} of {output.name} has no area")
        lines.append(knots(term.shape) if only in (None, number) else ())
    cuts = sorted({lo, hi} | {k.x for ks in lines for k in ks if lo < k.x < hi})
    found: list[Stretch] = []
    for a, b in itertools.pairwise(cuts):
        ends = {n: (_from_right(ks, a), _from_left(ks, b)) for n, ks in enumerate(lines) if ks}
        ends = {n: e for n, e in ends.items() if max(e) > 0}
        if not ends:
            continue
        inner = {_crossing(p, q) for p, q in itertools.combinations(ends.values(), 2)} if implies == "min" else set()
        parts = sorted({Fraction(0), Fraction(1)} | {c for c in inner if c is not None})
        for s, t in itertools.pairwise(parts):
            here = {n: (p + s * (q - p), p + t * (q - p)) for n, (p, q) in ends.items()}
            found.append(
                Stretch(
                    float(a + s * (b - a) - lo),
                    float((t - s) * (b - a)),
                    tuple(here),
                    np.array([[float(p)] for p, _ in here.values()]),
                    np.array([[float(q)] for _, q in here.values()]),
                )
            )
    return tuple(found)


def _from_right(ks: tuple[Knot, ...], x: Fraction) -> Fraction:
    """The limit at x from above."""
    if x < ks[0].x:
        return ks[0].left
    for a, b in itertools.pairwise(ks):
        if a.x <= x < b.x:
            return a.right + (x - a.x) / (b.x - a.x) * (b.left - a.right)
    return ks[-1].right


def _from_left(ks: tuple[Knot, ...], x: Fraction) -> Fraction:
    """The limit at x from below."""
    if x > ks[-1].x:
        return ks[-1].right
    for a, b in itertools.pairwise(ks):
        if a.x < x <= b.x:
            return a.right + (x - a.x) / (b.x - a.x) * (b.left - a.right)
    return ks[0].left


def _crossing(p: tuple[Fraction, Fraction], q: tuple[Fraction, Fraction]) -> Fraction | None:
    """Where in (0, 1) two lines given by their values at 0 and 1 cross."""
    before, after = p[0] - q[0], p[1] - q[1]
    if before * after >= 0:
        return None
    return before / (before - after)


def union(output: Output, levels: Floats, implies: Implies) -> tuple[Floats, Floats]:
    """Area of the largest of the implied sets, and its moment about ``integrate_lo``; ``levels`` are (terms, N)."""
    area, moment = np.zeros(levels.shape[1]), np.zeros(levels.shape[1])
    for stretch in stretches(output, implies):
        _add(stretch, levels[list(stretch.terms)], implies, area, moment)
    return area, moment


def single(output: Output, term: int, level: Floats, implies: Implies) -> tuple[Floats, Floats]:
    """Area and moment of one implied set; ``level`` is (N,)."""
    area, moment = np.zeros(len(level)), np.zeros(len(level))
    for stretch in stretches(output, implies, term):
        _add(stretch, level[None, :], implies, area, moment)
    return area, moment


def _add(stretch: Stretch, levels: Floats, implies: Implies, area: Floats, moment: Floats) -> None:
    """Add one stretch's area and moment, in the cases where anything is raised there."""
    raised = np.flatnonzero(levels.any(axis=0))
    if not raised.size:
        return
    levels = levels[:, raised]
    left, right = stretch.left, stretch.right
    rise = right - left
    if implies == "min":
        places = _clip_places(left, rise, levels)

        def envelope(t: Floats) -> Floats:
            return np.asarray(np.minimum(left + t * rise, levels).max(axis=0))
    else:
        places = _scaled_places(left * levels, right * levels)

        def envelope(t: Floats) -> Floats:
            return np.asarray(((left + t * rise) * levels).max(axis=0))

    a, m = _trapezoids(places, envelope)
    a *= stretch.width
    area[raised] += a
    moment[raised] += stretch.start * a + m * stretch.width**2


def _clip_places(left: Floats, rise: Floats, levels: Floats) -> list[Floats]:
    """Where (0 to 1 along the stretch) each sloping line meets each clip height."""
    return [
        np.clip((level - start) / slope, 0.0, 1.0)
        for start, slope in zip(left[:, 0], rise[:, 0], strict=True)
        if slope
        for level in levels
    ]


def _scaled_places(left: Floats, right: Floats) -> list[Floats]:
    """Where (0 to 1 along the stretch) each pair of scaled lines meets; 0 where it does not."""
    places = []
    for p, q in itertools.combinations(range(len(left)), 2):
        before, after = left[p] - left[q], right[p] - right[q]
        meet = before * after < 0
        places.append(np.divide(before, before - after, out=np.zeros_like(before), where=meet))
    return places


def _trapezoids(places: list[Floats], envelope: Callable[[Floats], Floats]) -> tuple[Floats, Floats]:
    """Area and moment about 0 over [0, 1] of what is linear between 0, the places (in any order) and 1."""
    before = np.zeros(1)
    value = envelope(before)
    area = moment = np.zeros(1)
    for place in [*_sorted(places), np.ones(1)]:
        next_value = envelope(place)
        length = place - before
        part = length * (value + next_value) / 2
        area = area + part
        moment = moment + before * part + length * length * (value + 2 * next_value) / 6
        before, value = place, next_value
    return area, moment


def _sorted(rows: list[Floats]) -> list[Floats]:
    """The rows sorted case by case. Few rows: exchanges between whole rows beat a sort of each column."""
    rows = list(rows)
    for end in range(len(rows) - 1, 0, -1):
        for i in range(end):
            rows[i], rows[i + 1] = np.minimum(rows[i], rows[i + 1]), np.maximum(rows[i], rows[i + 1])
    return rows
