"""Words of 32 bits as the C computes with them: known numbers where they are known, else terms of an SMT solver.

A value is kept as C's promotions leave it on a machine whose ``int`` has 32 bits: 32 bits, and a sign where its type
has one. Nothing is proved here; formulas are made.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import bitwuzla
from bitwuzla import Kind, Result

Word: TypeAlias = "int | bitwuzla.Term"
"""32 bits, or a truth (0 or 1)."""

MASK = 0xFFFF_FFFF
WIDTHS = {
    "unsigned char": (8, False),
    "uint8_t": (8, False),
    "int8_t": (8, True),
    "uint16_t": (16, False),
    "int16_t": (16, True),
    "uint32_t": (32, False),
    "int32_t": (32, True),
    "int": (32, True),
    "_Bool": (8, False),
}
_KINDS = {
    "+": Kind.BV_ADD,
    "-": Kind.BV_SUB,
    "*": Kind.BV_MUL,
    "&": Kind.BV_AND,
    "|": Kind.BV_OR,
    "^": Kind.BV_XOR,
    "<<": Kind.BV_SHL,
}
_SIGNED = {
    "/": (Kind.BV_UDIV, Kind.BV_SDIV),
    "%": (Kind.BV_UREM, Kind.BV_SREM),
    ">>": (Kind.BV_SHR, Kind.BV_ASHR),
    "<": (Kind.BV_ULT, Kind.BV_SLT),
    "<=": (Kind.BV_ULE, Kind.BV_SLE),
    ">": (Kind.BV_UGT, Kind.BV_SGT),
    ">=": (Kind.BV_UGE, Kind.BV_SGE),
}
_OVERFLOW = {"+": Kind.BV_SADD_OVERFLOW, "-": Kind.BV_SSUB_OVERFLOW, "*": Kind.BV_SMUL_OVERFLOW}


def signed(word: int) -> int:
    """The number that 32 bits stand for in a signed type."""
    return word - (1 << 32) if word >> 31 else word


@dataclass
class Words:
    """Makes terms. Truths are terms of one bit inside, and ints where they are known."""

    manager: bitwuzla.TermManager = field(default_factory=bitwuzla.TermManager)
    made: int = 0

    def __post_init__(self) -> None:
        self.sort = self.manager.mk_bv_sort(32)

    def unknown(self, ctype: str) -> bitwuzla.Term:
        """Any value of a type."""
        self.made += 1
        width, sign = WIDTHS[ctype]
        raw = self.manager.mk_const(self.manager.mk_bv_sort(width), f"v{self.made}")
        if width == 32:
            return raw
        extend = Kind.BV_SIGN_EXTEND if sign else Kind.BV_ZERO_EXTEND
        return self.manager.mk_term(extend, [raw], [32 - width])

    def term(self, word: Word) -> bitwuzla.Term:
        """A word as a term."""
        if isinstance(word, int):
            return self.manager.mk_bv_value(self.sort, word & MASK)
        return word

    def truth(self, word: Word) -> int | bitwuzla.Term:
        """Whether a word is not 0: a known truth, or a term of it."""
        if isinstance(word, int):
            return int(word != 0)
        if word.sort().is_bool():
            return word
        return self.manager.mk_term(Kind.DISTINCT, [word, self.term(0)])

    def value(self, truth: Word) -> Word:
        """A truth as the int that C makes of it."""
        if isinstance(truth, int) or not truth.sort().is_bool():
            return truth
        return self.manager.mk_term(Kind.ITE, [truth, self.term(1), self.term(0)])

    def formula(self, truth: Word) -> bitwuzla.Term:
        """A truth as a formula."""
        known = self.truth(truth)
        return known if not isinstance(known, int) else getattr(self.manager, "mk_true" if known else "mk_false")()

    def every(self, truths: Sequence[Word]) -> Word:
        """All of them."""
        found = [self.truth(t) for t in truths]
        if any(t == 0 for t in found if isinstance(t, int)):
            return 0
        terms = [t for t in found if not isinstance(t, int)]
        if not terms:
            return 1
        return terms[0] if len(terms) == 1 else self.manager.mk_term(Kind.AND, terms)

    def negated(self, truth: Word) -> Word:
        """The opposite."""
        known = self.truth(truth)
        return 1 - known if isinstance(known, int) else self.manager.mk_term(Kind.NOT, [known])

    def any(self, truths: Sequence[Word]) -> Word:
        """One of them at least."""
        return self.negated(self.every([self.negated(t) for t in truths]))

    def chosen(self, condition: Word, one: Word, other: Word) -> Word:
        """``condition ? one : other``."""
        known = self.truth(condition)
        if isinstance(known, int):
            return one if known else other
        one, other = self.value(one), self.value(other)
        if (isinstance(one, int) and isinstance(other, int) and one == other) or self.same(one, other):
            return one
        return self.manager.mk_term(Kind.ITE, [known, self.term(one), self.term(other)])

    def same(self, one: Word, other: Word) -> bool:
        """Whether two words are one term (or one number)."""
        if isinstance(one, int) or isinstance(other, int):
            return isinstance(one, int) and isinstance(other, int) and (one - other) & MASK == 0
        return bool(one == other)

    def differ(self, one: Word, other: Word) -> Word:
        """Whether two words are different."""
        if self.same(one, other):
            return 0
        return self.manager.mk_term(Kind.DISTINCT, [self.term(self.value(one)), self.term(self.value(other))])

    def binary(self, operator: str, left: Word, right: Word, sign: bool) -> Word:
        """An arithmetic operation or a comparison of words in their common type."""
        left, right = self.value(left), self.value(right)
        if isinstance(left, int) and isinstance(right, int):
            known = _known(operator, left & MASK, right & MASK, sign)
            if known is not None:
                return known
        terms = [self.term(left), self.term(right)]
        if operator in ("==", "!="):
            return self.manager.mk_term(Kind.EQUAL if operator == "==" else Kind.DISTINCT, terms)
        kind = _KINDS.get(operator) or _SIGNED[operator][sign]
        return self.manager.mk_term(kind, terms)

    def undefined(self, operator: str, left: Word, right: Word, sign: bool) -> Word:
        """Whether an operation has no meaning in C: signed overflow, a divisor of 0, a shift by too much."""
        left, right = self.value(left), self.value(right)
        if operator in ("/", "%"):
            by_zero = self.binary("==", right, 0, False)
            if not sign:
                return by_zero
            least = [self.binary("==", left, 1 << 31, False), self.binary("==", right, MASK, False)]
            return self.any([by_zero, self.every(least)])
        if operator in ("<<", ">>"):
            far = self.binary(">=", right, 32, False)
            if operator == "<<" and sign:
                back = self.binary(">>", self.binary("<<", left, right, True), right, True)
                below = self.binary("<", left, 0, True)
                return self.any([far, below, self.differ(back, left)])
            return far
        if sign and operator in _OVERFLOW:
            if isinstance(left, int) and isinstance(right, int):
                a, b = signed(left & MASK), signed(right & MASK)
                exact = {"+": a + b, "-": a - b, "*": a * b}[operator]
                return int(not -(1 << 31) <= exact < 1 << 31)
            return self.manager.mk_term(_OVERFLOW[operator], [self.term(left), self.term(right)])
        return 0

    def cast(self, word: Word, ctype: str) -> Word:
        """A value in a type."""
        word = self.value(word)
        width, sign = WIDTHS[ctype]
        if width == 32:
            return word
        if isinstance(word, int):
            low = word & ((1 << width) - 1)
            return (low - (1 << width)) & MASK if sign and low >> (width - 1) else low
        low = self.manager.mk_term(Kind.BV_EXTRACT, [word], [width - 1, 0])
        extend = Kind.BV_SIGN_EXTEND if sign else Kind.BV_ZERO_EXTEND
        return self.manager.mk_term(extend, [low], [32 - width])

    def impossible(self, claims: Sequence[Word], seconds: float) -> bool:
        """Whether the claims are shown to be never true together."""
        all_of = self.every(claims)
        if isinstance(all_of, int):
            return all_of == 0
        options = bitwuzla.Options()
        options.set(bitwuzla.Option.TIME_LIMIT_PER, int(1000 * seconds))
        solver = bitwuzla.Bitwuzla(self.manager, options)
        solver.assert_formula(self.formula(all_of))
        return bool(solver.check_sat() == Result.UNSAT)


def _known(operator: str, left: int, right: int, sign: bool) -> int | None:
    """The result for known words; None where C has none."""
    a, b = (signed(left), signed(right)) if sign else (left, right)
    match operator:
        case "+":
            return (a + b) & MASK
        case "-":
            return (a - b) & MASK
        case "*":
            return (a * b) & MASK
        case "&" | "|" | "^":
            return {"&": left & right, "|": left | right, "^": left ^ right}[operator]
        case "<<" if right < 32:
            return (left << right) & MASK
        case ">>" if right < 32:
            return (a >> right) & MASK
        case "/" | "%" if b != 0:
            whole = abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)
            return (whole if operator == "/" else a - whole * b) & MASK
        case "<" | "<=" | ">" | ">=" | "==" | "!=":
            return int({"<": a < b, "<=": a <= b, ">": a > b, ">=": a >= b, "==": a == b, "!=": a != b}[operator])
        case _:
            return None
