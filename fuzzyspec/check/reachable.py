"""What an output can really reach: rigorous enclosures, and values that are attained for certain.

The centroid of any combination of clipped or scaled terms lies in the hull of the centroids that its terms can have
alone where

* the combination is a sum: it is then a weighted mean of those; or
* it is a maximum over ordered terms: their supports begin and end in one order, and where two of them overlap the
  lower one does not rise and the higher one does not fall (a strong partition is such a family). Let A be the highest
  term that takes part and B the maximum of those below it; max(A, B) = A + R, where R = B (1 - A/B) as far as B exceeds
  A. On the support of A no part of B rises, and A does not fall as far as B reaches, so the factor does not increase
  over the support of B; by Chebyshev's inequality the centroid of R is at most that of B, which by induction is at most
  the largest centroid of a term alone. The lower end is the mirror image.

For other terms under a maximum: every level set of the combination is a union of the terms' level sets, a union of
intervals has its centroid within the hull of their middles, and the centroid is a mean of those of the level sets.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Literal

from fuzzyspec.check.degrees import core, degree, points
from fuzzyspec.check.strength import conjunction, rule_strength
from fuzzyspec.model.controller import Controller, Output
from fuzzyspec.model.term import PiecewiseLinear, Shape, Singleton

Corners = tuple[tuple[Fraction, Fraction], ...]
Hull = tuple[Fraction, Fraction]

MOST_LOOKS = 600
"""Inputs that are tried for attained values."""


@dataclass(frozen=True)
class Reach:
    """``lo .. hi`` holds every value while something fires; ``attained`` is the hull of values certainly taken.

    ``means`` names the argument for the enclosure. ``unused`` lists terms that no rule gives the output.
    """

    lo: Fraction
    hi: Fraction
    attained: Hull | None
    means: Literal["singletons", "one term", "sum of terms", "ordered terms", "level sets", "supports"]
    unused: tuple[str, ...]

    @property
    def exact(self) -> bool:
        return self.attained == (self.lo, self.hi)


def reach(controller: Controller, output: int) -> Reach:
    """The interval of an output while it fires."""
    variable = controller.outputs[output]
    used = _used(controller, output)
    unused = tuple(t.name for k, t in enumerate(variable.terms) if k not in used)
    attained = _attained(controller, output)
    hull = _hull([_alone(variable, k, controller.infer.implies == "min") for k in used])
    shapes = [variable.terms[k].shape for k in used]
    if any(isinstance(s, Singleton) for s in shapes):
        return Reach(*hull, attained, "singletons", unused)
    if len(used) == 1:
        return Reach(*hull, attained, "one term", unused)
    if controller.infer.aggregate == "sum":
        return Reach(*hull, attained, "sum of terms", unused)
    clipped = [_within(s, variable.integrate_lo, variable.integrate_hi) for s in shapes]
    if _ordered(clipped):
        return Reach(*hull, attained, "ordered terms", unused)
    if all(_unimodal(c) for c in clipped):
        return Reach(*_hull([_hull([(m, m) for m in _middles(c)]) for c in clipped]), attained, "level sets", unused)
    return Reach(*_hull([_support(c) for c in clipped]), attained, "supports", unused)


def _used(controller: Controller, output: int) -> list[int]:
    """Terms that some rule gives the output."""
    found = {term for s in controller.sentences for o, term in s.consequents if o == output}
    if controller.cells is not None:
        found |= set(controller.cells.consequents[output]) - {-1}
    return sorted(found)


def _alone(variable: Output, term: int, clips: bool) -> Hull:
    """The hull of the values that a term can give on its own, at any strength."""
    shape = variable.terms[term].shape
    if isinstance(shape, Singleton):
        return shape.at, shape.at
    corners = _within(shape, variable.integrate_lo, variable.integrate_hi)
    whole = _centroid(corners, max(y for _, y in corners))
    if not clips:
        return whole, whole
    if not _unimodal(corners):
        return _support(corners)
    # The centroid at clip height h is the mean over t < h of the middles of the level sets, weighted by their lengths:
    # it is monotone in h where they are monotone in t.
    middles = _middles(corners)
    rising = all(a <= b for a, b in itertools.pairwise(middles))
    falling = all(a >= b for a, b in itertools.pairwise(middles))
    if rising or falling:
        return _hull([(whole, whole), (middles[0], middles[0])])
    return _hull([(m, m) for m in middles])


def _within(shape: Shape, lo: Fraction, hi: Fraction) -> Corners:
    """A shape's corners over ``[lo, hi]`` alone."""
    inner = [(x, y) for x, y in points(shape) if lo < x < hi]
    return ((lo, degree(shape, lo, 1)), *inner, (hi, degree(shape, hi, -1)))


def _centroid(corners: Corners, height: Fraction) -> Fraction:
    """Centroid of a shape clipped at a height."""
    area = moment = Fraction(0)
    for (x0, y0), (x1, y1) in itertools.pairwise(corners):
        if x0 == x1:
            continue
        cuts = [x0, x1]
        if min(y0, y1) < height < max(y0, y1):
            cuts.insert(1, x0 + (x1 - x0) * (height - y0) / (y1 - y0))
        for a, b in itertools.pairwise(cuts):
            ya, yb = (min(height, y0 + (y1 - y0) * (x - x0) / (x1 - x0)) for x in (a, b))
            area += (b - a) * (ya + yb) / 2
            moment += (b - a) * (a * (2 * ya + yb) + b * (ya + 2 * yb)) / 6
    return moment / area if area else (corners[0][0] + corners[-1][0]) / 2


def _unimodal(corners: Corners) -> bool:
    """Whether every level set is one interval."""
    ys = [y for _, y in corners]
    top = ys.index(max(ys))
    return all(a <= b for a, b in itertools.pairwise(ys[: top + 1])) and all(
        a >= b for a, b in itertools.pairwise(ys[top:])
    )


def _ordered(family: Sequence[Corners]) -> bool:
    """Whether supports begin and end in one order, and overlap only where the lower falls and the higher rises."""
    supports = sorted((*_support(corners), corners) for corners in family)
    if any(a[1] > b[1] for a, b in itertools.pairwise(supports)):
        return False
    for (_, end, low), (start, _, high) in itertools.combinations(supports, 2):
        if start < end and not (_monotone(low, start, end, -1) and _monotone(high, start, end, 1)):
            return False
    return True


def _monotone(corners: Corners, lo: Fraction, hi: Fraction, sign: int) -> bool:
    """Whether a shape does not fall (``sign`` 1) or does not rise (-1) over the open interval."""
    shape = PiecewiseLinear(corners)
    inner = [y for x, y in corners if lo < x < hi]
    ys = [degree(shape, lo, 1), *inner, degree(shape, hi, -1)]
    return all(sign * a <= sign * b for a, b in itertools.pairwise(ys))


def _middles(corners: Corners) -> list[Fraction]:
    """Middles of the level sets at the limits of every stretch of levels, from the lowest up; linear in between."""
    levels = sorted({Fraction(0), *(y for _, y in corners)})
    found: list[Fraction] = []
    for a, b in itertools.pairwise(levels):
        # The ends of a level set are linear in the level between two corners' levels.
        third, two_thirds = (_middle(corners, a + (b - a) * k / 3) for k in (1, 2))
        step = two_thirds - third
        found += [third - step, two_thirds + step]
    return found


def _middle(corners: Corners, level: Fraction) -> Fraction:
    """Middle of the level set of a unimodal shape, at a level that no corner has."""
    inside = [x for x, y in corners if y > level]
    for (x0, y0), (x1, y1) in itertools.pairwise(corners):
        if (y0 < level) != (y1 < level):
            inside.append(x0 + (x1 - x0) * (level - y0) / (y1 - y0))
    return (min(inside) + max(inside)) / 2


def _support(corners: Corners) -> Hull:
    """Ends of where a shape is positive."""
    touching = [
        x for (x0, y0), (x1, y1) in itertools.pairwise(corners) if x0 < x1 and (y0 > 0 or y1 > 0) for x in (x0, x1)
    ]
    return min(touching), max(touching)


def _hull(spans: Sequence[Hull]) -> Hull:
    return min(lo for lo, _ in spans), max(hi for _, hi in spans)


def _attained(controller: Controller, output: int) -> Hull | None:
    """Values taken at inputs where one term alone fires: their hull, or None where no such input was found."""
    variable = controller.outputs[output]
    found: list[Fraction] = []
    corners_of = cache(lambda term: _within(variable.terms[term].shape, variable.integrate_lo, variable.integrate_hi))
    centroid_of = cache(lambda term, height: _centroid(corners_of(term), height))
    for cell in _looks(controller, output):
        at = [core(v, t) for v, t in zip(controller.inputs, cell, strict=True)]
        degrees = [[degree(t.shape, x) for t in v.terms] for v, x in zip(controller.inputs, at, strict=True)]
        fired = _fired(controller, output, degrees)
        strength = max((s for _, s in fired), default=Fraction(0))
        if len({term for term, _ in fired}) != 1 or strength < controller.fires_at:
            continue
        term = fired[0][0]
        shape = variable.terms[term].shape
        clips = controller.infer.implies == "min"
        if isinstance(shape, Singleton):
            found.append(shape.at)
        elif not (clips and controller.infer.aggregate == "sum" and len(fired) > 1):
            top = max(y for _, y in corners_of(term))
            found.append(centroid_of(term, min(top, strength) if clips else top))
    return (min(found), max(found)) if found else None


def _looks(controller: Controller, output: int) -> list[tuple[int, ...]]:
    """Cells whose peaks are tried: some of every term that is set, and a spread over all."""
    shape = [len(v.terms) for v in controller.inputs]
    every = list(itertools.islice(itertools.product(*map(range, shape)), 0, 1 << 16))
    chosen = every[:: max(1, len(every) // MOST_LOOKS)]
    if controller.cells is not None:
        first: dict[int, int] = {}
        for index, term in enumerate(controller.cells.consequents[output]):
            first.setdefault(term, index)
        chosen += [every[i] for i in first.values() if i < len(every)]
    return chosen


def _fired(controller: Controller, output: int, degrees: Sequence[Sequence[Fraction]]) -> list[tuple[int, Fraction]]:
    """(term, strength) of every rule that sets the output and fires at all."""
    fired: list[tuple[int, Fraction]] = []
    for rule in controller.sentences:
        terms = [term for o, term in rule.consequents if o == output]
        if terms:
            strength = rule_strength(rule, degrees, controller.infer)
            fired += [(term, strength) for term in terms]
    if controller.cells is not None:
        for cell in itertools.product(*([t for t, d in enumerate(ds) if d > 0] for ds in degrees)):
            flat = 0
            for size, t in zip(controller.cells.shape, cell, strict=True):
                flat = flat * size + t
            term = controller.cells.consequents[output][flat]
            if term >= 0:
                fired.append(
                    (term, conjunction([ds[t] for ds, t in zip(degrees, cell, strict=True)], controller.infer))
                )
    return [(term, strength) for term, strength in fired if strength > 0]
