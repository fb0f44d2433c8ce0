"""Degrees of membership, and which terms can be positive where."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import assert_never

import numpy as np

from fuzzyspec.exact.result import Floats, Ints
from fuzzyspec.model.controller import Input
from fuzzyspec.model.term import PiecewiseLinear, Shape, Singleton


@dataclass(frozen=True, slots=True)
class Knot:
    """A distinct x of a piecewise-linear shape: the values from the left, there, and from the right."""

    x: Fraction
    left: Fraction
    at: Fraction
    right: Fraction


def knots(shape: PiecewiseLinear) -> tuple[Knot, ...]:
    """The shape's points, those of one x (a jump) put together: the largest of their values holds there."""
    found: list[Knot] = []
    for x, y in shape.points:
        if found and found[-1].x == x:
            found[-1] = Knot(x, found[-1].left, max(found[-1].at, y), y)
        else:
            found.append(Knot(x, y, y, y))
    return tuple(found)


@lru_cache(maxsize=4096)
def _float_knots(shape: PiecewiseLinear) -> tuple[Floats, Floats, Floats, Floats, Floats, bool]:
    """x, value at x; and for each stretch from x_i to x_(i+1) (the last one constant): start, rise, length."""
    ks = knots(shape)
    x = np.array([float(k.x) for k in ks])
    at = np.array([float(k.at) for k in ks])
    start = np.array([float(k.right) for k in ks])
    rise = np.array([float(b.left - a.right) for a, b in itertools.pairwise(ks)] + [0.0])
    length = np.array([float(b.x - a.x) for a, b in itertools.pairwise(ks)] + [1.0])
    jumps = any(k.at != k.right for k in ks)
    return x, at, start, rise, length, jumps


def degree(shape: Shape, value: Floats) -> Floats:
    """Membership of each value: linear between the points, constant beyond them, the larger value at a jump."""
    match shape:
        case Singleton(place):
            return np.asarray(value == float(place), dtype=np.float64)
        case PiecewiseLinear():
            x, at, start, rise, length, jumps = _float_knots(shape)
            index = np.searchsorted(x, value, side="right") - 1
            before = index < 0
            index[before] = 0
            part = (value - x[index]) / length[index]
            result = np.clip(start[index] + part * rise[index], 0.0, 1.0)
            if jumps:
                here = value == x[index]
                result[here] = at[index[here]]
            if before.any():
                result[before] = float(shape.points[0][1])
            return np.asarray(result)
        case _:
            assert_never(shape)


def degrees(inp: Input, value: Floats) -> Floats:
    """(terms, N): the degree of every term."""
    if not inp.terms:
        return np.zeros((0, len(value)))
    return np.stack([degree(term.shape, value) for term in inp.terms])


@dataclass(frozen=True, slots=True)
class Regions:
    """The input axis cut where any term bends: 2 m + 1 regions for m cuts, the cuts being regions themselves.

    ``active[region]`` lists the terms that are positive somewhere in it, filled up to a common length with terms
    that are 0 there (their degree makes them harmless).
    """

    cuts: Floats
    active: Ints

    def at(self, value: Floats) -> Ints:
        """(slots, N): the terms that can be positive at each value."""
        region = np.searchsorted(self.cuts, value, side="left") + np.searchsorted(self.cuts, value, side="right")
        return np.asarray(self.active.T[:, region])


@lru_cache(maxsize=512)
def regions(inp: Input) -> Regions:
    """Which terms can be positive where, found by looking at one place of each region."""
    places: set[Fraction] = set()
    for term in inp.terms:
        match term.shape:
            case Singleton(at):
                places.add(at)
            case PiecewiseLinear(points):
                places.update(x for x, _ in points)
            case _:
                assert_never(term.shape)
    cuts = np.unique(np.array([float(p) for p in places]))
    between = (cuts[1:] + cuts[:-1]) / 2
    probes = np.empty(2 * len(cuts) + 1)
    probes[1::2] = cuts
    probes[0], probes[-1] = cuts[0] - 1.0, cuts[-1] + 1.0
    probes[2:-1:2] = between
    positive = degrees(inp, probes) > 0.0
    slots = max(1, int(positive.sum(axis=0).max()))
    # a stable sort by "is not positive" puts the positive terms first, in their order
    active = np.argsort(~positive, axis=0, kind="stable")[:slots].T
    return Regions(cuts, np.ascontiguousarray(active, dtype=np.int64))
