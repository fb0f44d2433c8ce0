"""A lemma in words of as many bits as its values need, for bitwuzla."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fuzzyspec.prove.lemma import Expr, Num, Op, Var, Wide
from fuzzyspec.prove.ranges import COMPARISONS, Unbounded, result

Word = tuple[Any, int, Wide]
"""A term of two's complement, its width, and the values it takes."""


class Words:
    """Puts expressions into words."""

    def __init__(self, ranges: Mapping[str, Wide], effort: int) -> None:
        import bitwuzla as b

        self._b, self._ranges = b, ranges
        options = b.Options()
        options.set(b.Option.TIME_LIMIT_PER, effort)
        self._terms = b.TermManager()
        self._solver = b.Bitwuzla(self._terms, options)
        self._known: dict[str, Word] = {}

    def assume(self, claim: Expr) -> None:
        """Add what holds."""
        self._solver.assert_formula(self._truth(claim))

    def impossible(self) -> bool:
        """Whether nothing satisfies all of it; False also where that was not found out in time."""
        return bool(self._solver.check_sat() == self._b.Result.UNSAT)

    def _term(self, kind: str, *operands: Any, indices: tuple[int, ...] = ()) -> Any:
        return self._terms.mk_term(getattr(self._b.Kind, kind), list(operands), list(indices))

    def _constant(self, value: int, width: int) -> Any:
        return self._terms.mk_bv_value(self._terms.mk_bv_sort(width), value % 2**width)

    def _fit(self, word: Word, width: int) -> Any:
        term, have, _ = word
        if width > have:
            return self._term("BV_SIGN_EXTEND", term, indices=(width - have,))
        return term if width == have else self._term("BV_EXTRACT", term, indices=(width - 1, 0))

    def _truth(self, expr: Expr) -> Any:
        match expr:
            case Op("&&", (a, b)):
                return self._term("AND", self._truth(a), self._truth(b))
            case Op("||", (a, b)):
                return self._term("OR", self._truth(a), self._truth(b))
            case Op("!", (a,)):
                return self._term("NOT", self._truth(a))
            case Op("<" | "<=" | ">" | ">=" | "==" | "!=" as op, (a, b)):
                one, other = self._word(a), self._word(b)
                width = max(one[1], other[1])
                kinds = {"<": "BV_SLT", "<=": "BV_SLE", ">": "BV_SGT", ">=": "BV_SGE", "==": "EQUAL", "!=": "DISTINCT"}
                return self._term(kinds[op], self._fit(one, width), self._fit(other, width))
            case _:
                term, width, _ = self._word(expr)
                return self._term("DISTINCT", term, self._constant(0, width))

    def _word(self, expr: Expr) -> Word:
        match expr:
            case Num(value):
                width = width_of((value, value))
                return self._constant(value, width), width, (value, value)
            case Var(name):
                if name not in self._known:
                    within = self._ranges[name]
                    width = width_of(within)
                    term = self._terms.mk_const(self._terms.mk_bv_sort(width), name)
                    self._known[name] = term, width, within
                    self.assume(Op("<=", (Num(within[0]), expr)))
                    self.assume(Op("<=", (expr, Num(within[1]))))
                return self._known[name]
            case Op(op, (a, b, c)) if op == "?":
                one, other = self._word(b), self._word(c)
                width = max(one[1], other[1])
                term = self._term("ITE", self._truth(a), self._fit(one, width), self._fit(other, width))
                return term, width, result(op, [(0, 1), one[2], other[2]])
            case Op(op, _) if op in COMPARISONS:
                term = self._term("ITE", self._truth(expr), self._constant(1, 2), self._constant(0, 2))
                return term, 2, (0, 1)
            case Op(op, args):
                return self._operation(op, [self._word(a) for a in args])

    def _operation(self, op: str, words: list[Word]) -> Word:
        within = result(op, [w[2] for w in words])
        width = max(width_of(within), *(w[1] for w in words))
        if op.startswith(("wrap", "sign")):
            bits = int(op[4:])
            if within == words[0][2]:
                return words[0]
            low = self._fit(words[0], max(bits, words[0][1]))
            low = self._term("BV_EXTRACT", low, indices=(bits - 1, 0))
            if op.startswith("wrap"):
                return self._term("BV_ZERO_EXTEND", low, indices=(1,)), bits + 1, within
            return low, bits, within
        if op == "neg":
            return self._term("BV_NEG", self._fit(words[0], width)), width, within
        kinds = {"+": "BV_ADD", "-": "BV_SUB", "*": "BV_MUL", "/": "BV_SDIV", "%": "BV_SREM", "<<": "BV_SHL"}
        kinds |= {">>": "BV_ASHR", "&": "BV_AND", "|": "BV_OR", "^": "BV_XOR"}
        if op not in kinds:
            raise Unbounded(op)
        return self._term(kinds[op], *(self._fit(w, width) for w in words)), width, within


def width_of(within: Wide) -> int:
    """Bits of two's complement that hold all of them."""
    return max((-within[0] - 1 if within[0] < 0 else within[0]).bit_length(), within[1].bit_length()) + 1
