"""Words of 32 bits for many boxes of inputs at once: of each, the least and the greatest number that it can be.

In a box of one input they are that input's very numbers. Where an operation might wrap around, or its meaning hangs on
a sign that is not known, a word is anything; a divisor is never 0 and a shift never too far, which is proved elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tests.mutation.c_words import MASK, WIDTHS, _known, signed

Ints = npt.NDArray[np.int64]
SIGNED, UNSIGNED = (-(1 << 31), (1 << 31) - 1), (0, MASK)


@dataclass(frozen=True, eq=False)
class Span:
    """(N,) least and greatest numbers of a word, or of a truth."""

    lo: Ints
    hi: Ints

    def within(self, low: int, high: int) -> Span:
        """As a number of a type of 32 bits or less: wrapped into it as a whole, or anything in it."""
        size = high - low + 1
        by = (self.lo - low) // size * size
        lo, hi = self.lo - by, self.hi - by
        fits = hi <= high
        return Span(np.where(fits, lo, low), np.where(fits, hi, high))


@dataclass
class Boxes:
    """Does what ``c_words.Words`` does, for ``many`` boxes. Words are ints where they are the same number in all."""

    many: int

    def span(self, word: Any, sign: bool) -> Span:
        """A word as numbers of a type with or without a sign."""
        if isinstance(word, int):
            number = signed(word & MASK) if sign else word & MASK
            return Span(np.full(self.many, number), np.full(self.many, number))
        return word.within(*(SIGNED if sign else UNSIGNED))  # type: ignore[no-any-return]

    def unknown(self, ctype: str) -> Span:
        """Any value of a type."""
        low, high = limits(ctype)
        return Span(np.full(self.many, low), np.full(self.many, high))

    def value(self, truth: Any) -> Any:
        """A truth is its int."""
        return truth

    def truth(self, word: Any) -> Any:
        """Whether a word is not 0."""
        if isinstance(word, int):
            return int(word != 0)
        return Span(((word.lo > 0) | (word.hi < 0)) + 0, ((word.lo != 0) | (word.hi != 0)) + 0)

    def every(self, truths: Sequence[Any]) -> Any:
        """All of them."""
        found = [self.truth(t) for t in truths]
        if any(t == 0 for t in found if isinstance(t, int)):
            return 0
        spans = [t for t in found if not isinstance(t, int)]
        if not spans:
            return 1
        return Span(np.min([s.lo for s in spans], axis=0), np.min([s.hi for s in spans], axis=0))

    def negated(self, truth: Any) -> Any:
        """The opposite."""
        known = self.truth(truth)
        return 1 - known if isinstance(known, int) else Span(1 - known.hi, 1 - known.lo)

    def any(self, truths: Sequence[Any]) -> Any:
        """One of them at least."""
        return self.negated(self.every([self.negated(t) for t in truths]))

    def chosen(self, condition: Any, one: Any, other: Any) -> Any:
        """``condition ? one : other``."""
        known = self.truth(condition)
        if isinstance(known, int):
            return one if known else other
        if isinstance(one, int) and isinstance(other, int) and one == other:
            return one
        below = any(not isinstance(w, int) and (w.lo < 0).any() for w in (one, other))
        a, b = ((self.span(w, below) if isinstance(w, int) else w) for w in (one, other))
        yes, no = known.lo > 0, known.hi <= 0
        return Span(
            np.where(yes, a.lo, np.where(no, b.lo, np.minimum(a.lo, b.lo))),
            np.where(yes, a.hi, np.where(no, b.hi, np.maximum(a.hi, b.hi))),
        )

    def binary(self, operator: str, left: Any, right: Any, sign: bool) -> Any:
        """An arithmetic operation or a comparison of words in their common type."""
        if isinstance(left, int) and isinstance(right, int):
            known = _known(operator, left & MASK, right & MASK, sign)
            if known is not None:
                return known
        a, b = self.span(left, sign), self.span(right, sign)
        match operator:
            case "<":
                return Span((a.hi < b.lo) + 0, (a.lo < b.hi) + 0)
            case "<=":
                return Span((a.hi <= b.lo) + 0, (a.lo <= b.hi) + 0)
            case ">" | ">=":
                return self.binary({">": "<", ">=": "<="}[operator], right, left, sign)
            case "==":
                one = (a.lo == a.hi) & (b.lo == b.hi) & (a.lo == b.lo)
                return Span(one + 0, ((a.lo <= b.hi) & (b.lo <= a.hi)) + 0)
            case "!=":
                return self.negated(self.binary("==", left, right, sign))
        return self._arithmetic(operator, a, b).within(*(SIGNED if sign else UNSIGNED))

    def _arithmetic(self, operator: str, a: Span, b: Span) -> Span:
        match operator:
            case "+":
                return Span(a.lo + b.lo, a.hi + b.hi)
            case "-":
                return Span(a.lo - b.hi, a.hi - b.lo)
            case "*":
                return _corners(np.multiply, a, b)
            case "<<":
                return _corners(np.multiply, a, Span(1 << np.minimum(b.lo, 31), 1 << np.minimum(b.hi, 31)))
            case ">>":
                shift = Span(np.minimum(b.lo, 31), np.minimum(b.hi, 31))
                return _corners(np.right_shift, a, shift)
            case "/":
                return _corners(_toward_zero, a, Span(np.maximum(b.lo, 1), np.maximum(b.hi, 1)))
        # Bits, or a remainder: exact for single numbers, of others the most bits that come up.
        single = (a.lo == a.hi) & (b.lo == b.hi)
        exact = {"&": np.bitwise_and, "|": np.bitwise_or, "^": np.bitwise_xor, "%": np.fmod}[operator](
            a.lo, np.where(b.lo == 0, 1, b.lo) if operator == "%" else b.lo
        )
        natural = (a.lo >= 0) & (b.lo >= 0)
        bits = 1 << np.ceil(np.log2(np.maximum(np.maximum(a.hi, b.hi), 0) + 1.0)).astype(np.int64)
        most = np.minimum(a.hi, b.hi) if operator == "&" else bits
        return Span(
            np.where(single, exact, np.where(natural, 0, SIGNED[0])),
            np.where(single, exact, np.where(natural, most, UNSIGNED[1])),
        )

    def undefined(self, operator: str, left: Any, right: Any, sign: bool) -> int:
        """Not asked here."""
        return 0

    def cast(self, word: Any, ctype: str) -> Any:
        """A value in a type."""
        width, sign = WIDTHS[ctype]
        if isinstance(word, int):
            low = word & ((1 << width) - 1)
            return (low - (1 << width)) & MASK if sign and low >> (width - 1) else low
        return word.within(*limits(ctype))

    def impossible(self, claims: Sequence[Any], seconds: float) -> bool:
        """Whether the claims are never true together, in no box."""
        found = self.every(claims)
        return found == 0 if isinstance(found, int) else not found.hi.any()

    def differ(self, one: Any, other: Any) -> Any:
        """Whether two words are different."""
        return self.binary("!=", one, other, False)


def limits(ctype: str) -> tuple[int, int]:
    """The least and the greatest number of a type."""
    width, sign = WIDTHS[ctype]
    return (-(1 << (width - 1)), (1 << (width - 1)) - 1) if sign else (0, (1 << width) - 1)


def _toward_zero(num: Ints, den: Ints) -> Ints:
    return np.asarray(np.sign(num) * (np.abs(num) // den), dtype=np.int64)


def _corners(of: Any, a: Span, b: Span) -> Span:
    """A function that is monotonic in each operand; anything where its results leave 32 bits by far."""
    ends = [of(x, y) for x in (a.lo, a.hi) for y in (b.lo, b.hi)]
    size = np.maximum(np.abs(a.lo), np.abs(a.hi)) * 1.0
    far = size * np.maximum(np.abs(b.lo), np.abs(b.hi)) >= 2.0**62 if of is np.multiply else np.zeros(len(size), bool)
    return Span(np.where(far, SIGNED[0], np.min(ends, axis=0)), np.where(far, UNSIGNED[1], np.max(ends, axis=0)))
