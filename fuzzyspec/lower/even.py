"""Outputs whose sets come in few shapes: an even partition's areas are multiples of two polynomials.

All terms of such an output have areas proportional to one another, and so have all its overlaps, whose means lie at
their middles. Terms that are not symmetric (the half triangles at the ends) share one moment polynomial.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

from fuzzyspec.lower.clipped import ClippedSet, clipped_sets
from fuzzyspec.model.controller import Output

MAX_TERMS = 8
"""Sets of terms are bits of a byte."""
MAX_MULTIPLE = 4


@dataclass(frozen=True)
class EvenOutput:
    """``single`` is the smallest term, ``multiples`` the areas of all terms in units of its; ``pair`` is None
    without overlaps.

    ``turning`` is a term that is not symmetric, None where all are.
    """

    forms: tuple[ClippedSet, ...]
    single: ClippedSet
    multiples: tuple[int, ...]
    pair: ClippedSet | None
    turning: ClippedSet | None

    def unit_of(self, form: ClippedSet) -> tuple[ClippedSet, int]:
        """The set to evaluate in place of one of the output's, and how many times its area stands for that one's.

        Every program for the output does this, so all of them compute the same integers.
        """
        if len(form.members) != 1 or form.moment_sign:
            return form, 1
        return replace(self.single, moment_sign=0), self.multiples[form.members[0]]

    @property
    def singles(self) -> tuple[ClippedSet, ...]:
        return tuple(f for f in self.forms if len(f.members) == 1)

    @property
    def pairs(self) -> tuple[ClippedSet, ...]:
        return tuple(f for f in self.forms if len(f.members) == 2)


def even_output(output: Output) -> EvenOutput | None:
    """The output's sets, or None where they are not that regular. Raises TooManySets."""
    if output.peaks is None or len(output.terms) > MAX_TERMS:
        return None
    forms = clipped_sets(output)
    singles = [f for f in forms if len(f.members) == 1]
    pairs = [f for f in forms if len(f.members) == 2]
    if len(singles) + len(pairs) != len(forms) or len(singles) != len(output.terms):
        return None
    if any(len(f.pieces) != 1 for f in forms) or any(f.moment_sign for f in pairs):
        return None
    if any(f.members[1] != f.members[0] + 1 or f.pieces != pairs[0].pieces for f in pairs):
        return None
    single = min(singles, key=lambda f: (f.pieces[0].width[0], -abs(f.moment_sign)))
    multiples: list[int] = []
    for f in singles:
        ratio = _ratio(f, single)
        if ratio is None or ratio.denominator != 1 or ratio > MAX_MULTIPLE:
            return None
        multiples.append(int(ratio))
    turning = [f for f in singles if f.moment_sign]
    if any(multiples[f.members[0]] != 1 for f in turning):
        return None
    if any(f.pieces[0].first != turning[0].pieces[0].first for f in turning):
        return None
    return EvenOutput(forms, single, tuple(multiples), pairs[0] if pairs else None, turning[0] if turning else None)


def _ratio(form: ClippedSet, unit: ClippedSet) -> Fraction | None:
    a, b = form.pieces[0].width, unit.pieces[0].width
    ratio = a[0] / b[0]
    return ratio if a[1] == ratio * b[1] else None
