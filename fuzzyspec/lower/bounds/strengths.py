"""Strengths and levels over boxes of inputs, with what they can be off by.

A quantity over B boxes is a :class:`Band`: the exact value lies in ``lo .. hi`` and the integer one within ``off``
of it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import assert_never

import numpy as np
import numpy.typing as npt

from fuzzyspec.lower.bounds.memberships import SLACK, Floats, Membership, membership
from fuzzyspec.lower.controller import ControllerNumbers
from fuzzyspec.model.controller import And, Antecedent, Controller, Is, Not, Or

Ints = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Band:
    lo: Floats
    hi: Floats
    off: Floats


@dataclass(frozen=True)
class Boxes:
    """B boxes in relative input positions; arrays are (B, inputs)."""

    lo: Floats
    hi: Floats

    def __len__(self) -> int:
        return len(self.lo)

    def some(self, chosen: npt.NDArray[np.bool_] | Ints | list[int]) -> Boxes:
        """Those that an index array or a mask names."""
        return Boxes(self.lo[chosen], self.hi[chosen])

    def and_(self, others: Boxes) -> Boxes:
        """These, then the others."""
        return Boxes(np.concatenate([self.lo, others.lo]), np.concatenate([self.hi, others.hi]))


@dataclass(frozen=True)
class Levels:
    """Levels of one output: arrays (B, terms). ``strongest`` is the largest strength's upper end."""

    band: Band
    rules: int


def by_degree(hi: Floats) -> list[Ints]:
    """One input's terms from the largest upper end (B, terms) of their degrees down, as many as can be active at once:
    each (B,)."""
    order = np.argsort(-hi, axis=1, kind="stable")
    active = int((hi > 0).sum(axis=1).max(initial=1))
    return [order[:, j] for j in range(max(active, 1))]


def cells_named(controller: Controller, terms: list[list[Ints]]) -> Iterator[tuple[tuple[int, ...], list[Ints]]]:
    """Every cell of such ``terms`` of each input: which of them it is, and by output what it names (B,), one past the
    last term where it names none."""
    cells = controller.cells
    assert cells is not None
    tables = [
        np.array([len(o.terms) if t < 0 else t for t in c])
        for o, c in zip(controller.outputs, cells.consequents, strict=True)
    ]
    for which in itertools.product(*(range(len(t)) for t in terms)):
        index = np.zeros_like(terms[0][0])
        for size, found, w in zip(cells.shape, terms, which, strict=True):
            index = index * size + found[w]
        yield which, [table[index] for table in tables]


class Strengths:
    """Evaluates one controller's rules over boxes, for given errors of its inputs (relative to their ranges).

    ``raws``, where given, are all that it is called with: by input the smallest and the largest.
    """

    def __init__(
        self,
        numbers: ControllerNumbers,
        input_errors: tuple[float, ...],
        raws: tuple[tuple[int, int], ...] | None = None,
    ) -> None:
        self.numbers = numbers
        self.controller: Controller = numbers.controller
        self.errors = input_errors
        self.raws = raws
        self.terms: list[list[Membership]] = [
            [membership(t.shape, i.variable.lo, i.variable.hi) for t in i.terms] for i in self.controller.inputs
        ]

    def degrees(self, boxes: Boxes) -> list[list[Band]]:
        """Degrees of every term of every input."""
        found: list[list[Band]] = []
        for i, terms in enumerate(self.terms):
            e = self.errors[i]
            row: list[Band] = []
            for m, own in zip(terms, map(float, self.numbers.degree_errors[i]), strict=True):
                lo, hi = m.over(boxes.lo[:, i] - e, boxes.hi[:, i] + e)
                rounding = np.where((hi <= 0) | (lo >= 1), 0.0, own)
                if not e:
                    row.append(Band(lo, hi, rounding))
                    continue
                # From the raw's value to the exact input's: along the slopes on the way, or by a jump there.
                left, right = boxes.lo[:, i] - 2 * e, boxes.hi[:, i] + 2 * e
                moved = m.over(left, right)
                reach = moved[1] - moved[0]
                steep = np.maximum.reduce([np.abs(k) for k in m.slope(left, right)])
                slide = np.where(m.jumps_in(left, right), reach, np.minimum(reach, steep * e))
                row.append(Band(lo, hi, rounding + np.where(reach == 0, 0.0, slide)))
            found.append(row)
        return found

    def alone(self, i: int | None) -> Strengths:
        """The same, were nothing to err but input i and its degrees; for None, nothing but what rules round."""
        numbers = self.numbers
        one = replace(
            numbers,
            degree_errors=tuple(
                errors if k == i else (Fraction(0),) * len(errors) for k, errors in enumerate(numbers.degree_errors)
            ),
            cell_error=numbers.cell_error if i is None else Fraction(0),
            sentence_errors=tuple(e if i is None else Fraction(0) for e in numbers.sentence_errors),
        )
        return Strengths(one, tuple(e if k == i else 0.0 for k, e in enumerate(self.errors)), self.raws)

    def farthest(self, i: int) -> float:
        """How far an interpolation along input i can be led astray, in units of an edge; not capped at 1, since an
        input's error may reach over several terms."""
        return float(max(self.numbers.degree_errors[i])) + self.errors[i] * max(m.steepest for m in self.terms[i])

    def travel(self, boxes: Boxes) -> Floats:
        """By input, the most that a degree can move from one side of a box to the other, jumps apart; (B, inputs)."""
        columns: list[Floats] = []
        for i, terms in enumerate(self.terms):
            lo, hi = boxes.lo[:, i], boxes.hi[:, i]
            slopes = [np.abs(k) for m in terms for k in m.slope(lo, hi)]
            columns.append((hi - lo) * np.maximum.reduce(slopes))
        return np.stack(columns, axis=1)

    def legal(self, i: int) -> tuple[float, float]:
        """The ends of the raws that the controller is called with, relative to the range; all legal ones."""
        v = self.controller.inputs[i].variable
        raws = (v.raw.lo, v.raw.hi) if self.raws is None else self.raws[i]
        ends = sorted(v.raw.value(r) for r in raws)
        return float((ends[0] - v.lo) / (v.hi - v.lo)), float((ends[1] - v.lo) / (v.hi - v.lo))

    def around(self, i: int) -> tuple[float, float]:
        """Where an input may be in the exact meaning, relative to its range: about those raws, or anywhere."""
        if self.raws is None:
            return 0.0, 1.0
        low, high = self.legal(i)
        return max(0.0, low - self.errors[i]), min(1.0, high + self.errors[i])

    def off_by(self, errors: tuple[float, ...]) -> Strengths:
        """The same with other errors of the inputs."""
        return Strengths(self.numbers, errors, self.raws)

    def levels(self, boxes: Boxes) -> list[Band]:
        """For every output the levels of its terms, arrays (B, terms)."""
        degrees = self.degrees(boxes)
        fired: list[list[tuple[Ints, Band]]] = [[] for _ in self.controller.outputs]
        if self.controller.cells is not None:
            self._cells(boxes, degrees, fired)
        for number, rule in enumerate(self.controller.sentences):
            band = self.sentence(rule.antecedent, degrees)
            weight = float(rule.weight)
            rounding = float(self.numbers.sentence_errors[number])
            off = np.where(band.hi > 0, band.off * weight + rounding, 0.0)
            band = Band(band.lo * weight, band.hi * weight, off)
            for output, term in rule.consequents:
                fired[output].append((np.full(len(boxes), term), band))
        return [
            self._aggregate(len(boxes), len(o.terms), f) for o, f in zip(self.controller.outputs, fired, strict=True)
        ]

    def _aggregate(self, n: int, terms: int, fired: list[tuple[Ints, Band]]) -> Band:
        lo, hi, off = np.zeros((n, terms + 1)), np.zeros((n, terms + 1)), np.zeros((n, terms + 1))
        row = np.arange(n)
        if self.controller.infer.aggregate == "sum":
            for term, b in fired:
                lo[row, term] += b.lo
                hi[row, term] += b.hi
                off[row, term] += b.off
        else:
            for term, b in fired:
                lo[row, term] = np.maximum(lo[row, term], b.lo)
                hi[row, term] = np.maximum(hi[row, term], b.hi)
            widest = max((float(b.off.max(initial=0.0)) for _, b in fired), default=0.0)
            for term, b in fired:
                # Only a rule that can be the largest, in either meaning, moves the level.
                counts = b.hi >= lo[row, term] - 2 * widest
                off[row, term] = np.maximum(off[row, term], np.where(counts, b.off, 0.0))
        return Band(lo[:, :terms], hi[:, :terms], off[:, :terms])

    # --- cells ----------------------------------------------------------------------------------

    def _cells(self, boxes: Boxes, degrees: list[list[Band]], fired: list[list[tuple[Ints, Band]]]) -> None:
        row = np.arange(len(boxes))
        found: list[list[Ints]] = []
        bands: list[list[Band]] = []
        for terms in degrees:
            lo, hi, off = (np.stack(ends, axis=1) for ends in zip(*((b.lo, b.hi, b.off) for b in terms), strict=True))
            found.append(by_degree(hi))
            bands.append([Band(lo[row, k], hi[row, k], off[row, k]) for k in found[-1]])
        for which, named in cells_named(self.controller, found):
            band = self.both([b[w] for b, w in zip(bands, which, strict=True)])
            off = np.where(band.hi > 0, band.off + float(self.numbers.cell_error), 0.0)
            band = Band(band.lo, band.hi, off)
            for o, terms_named in enumerate(named):
                fired[o].append((terms_named, band))

    # --- norms ----------------------------------------------------------------------------------

    def both(self, parts: list[Band]) -> Band:
        """``and`` of several."""
        if self.controller.infer.and_ == "min":
            lo: Floats = np.minimum.reduce([b.lo for b in parts])
            hi: Floats = np.minimum.reduce([b.hi for b in parts])
            widest = np.maximum.reduce([b.off for b in parts])
            off = np.maximum.reduce([np.where(b.lo <= hi + 2 * widest, b.off, 0.0) for b in parts])
            return Band(lo, hi, off)
        product = parts[0]
        for b in parts[1:]:
            off = product.off * (b.hi + b.off) + b.off * product.hi
            product = Band(product.lo * b.lo, product.hi * b.hi, off)
        return product

    def either(self, parts: list[Band]) -> Band:
        """``or`` of several."""
        if self.controller.infer.or_ == "max":
            lo: Floats = np.maximum.reduce([b.lo for b in parts])
            hi: Floats = np.maximum.reduce([b.hi for b in parts])
            widest = np.maximum.reduce([b.off for b in parts])
            off = np.maximum.reduce([np.where(b.hi >= lo - 2 * widest, b.off, 0.0) for b in parts])
            return Band(lo, hi, off)
        result = parts[0]
        for b in parts[1:]:
            # a + b - a b grows with both, with either by what the other leaves: half-way between its two values.
            lo_, hi_ = (result.lo + b.lo - result.lo * b.lo, result.hi + b.hi - result.hi * b.hi)
            result = Band(lo_, hi_, result.off * _left_by(b) + b.off * _left_by(result))
        return result

    def sentence(self, node: Antecedent, degrees: list[list[Band]]) -> Band:
        """The strength of an antecedent, before its weight."""
        match node:
            case Is(i, terms):
                return self.either([degrees[i][t] for t in terms])
            case Not(operand):
                b = self.sentence(operand, degrees)
                return Band(1 - b.hi, 1 - b.lo, b.off)
            case And(operands):
                return self.both([self.sentence(o, degrees) for o in operands])
            case Or(operands):
                return self.either([self.sentence(o, degrees) for o in operands])
            case _:
                assert_never(node)


def _left_by(b: Band) -> Floats:
    """The most that half-way between a degree's two values leaves of 1."""
    most: Floats = 1.0 + SLACK - np.maximum(b.lo - b.off / 2, 0.0)
    return most
