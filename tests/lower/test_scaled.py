"""Crisp arithmetic, places, quotients and decisions: integers held to rationals along random chains."""

from __future__ import annotations

import operator
import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fuzzyspec.fixed.build import RangeError
from fuzzyspec.fixed.program import Const, Define, Expr, Select, Stmt, Test
from fuzzyspec.lower.decisions import decide
from fuzzyspec.lower.places import place, read
from fuzzyspec.lower.quotients import divide, settle, zero_over_zero
from fuzzyspec.lower.scaled import Arithmetic, Scaled, constant
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.units import Unit
from fuzzyspec.model.variable import Variable
from tests.lower.lower_models import over, rationals, variables
from tests.lower.lower_running import given as reading
from tests.lower.lower_running import outcome

F = Fraction
UNITS = [
    Unit(""),
    Unit("%", (), F(1, 100)),
    Unit("degC", (("K", 1),), F(1), F(27315, 100)),
    Unit("tick", (), F(12, 1000)),
]
Raws = tuple[int, ...]
COMPARE: dict[str, Callable[[F, F], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}


@dataclass
class Chain:
    """Inputs with errors of their own, statements so far, and the raws (and true values) of some cases."""

    variables: list[Variable]
    arithmetic: Arithmetic
    start: list[Scaled]
    cases: list[Raws]
    truths: list[tuple[F, ...]]
    """What each input really is, in coherent units: off its raw's value by at most its error."""

    def run(self, results: dict[str, Expr]) -> dict[str, list[int]]:
        """The results of every case."""
        inputs = {v.name: [c[k] for c in self.cases] for k, v in enumerate(self.variables)}
        seen = outcome(self.arithmetic.body, results, inputs)
        return {k: v.tolist() for k, v in seen.items()}

    def value(self, scaled: Scaled) -> list[F]:
        """What a computed value is in every case."""
        return [scaled.offset + scaled.step * i for i in self.run({"value": scaled.expr})["value"]]


@st.composite
def chains(draw: st.DrawFn, most: int = 3, exact: bool | None = None) -> Chain:
    """Some variables of any range, raw and unit, read with or without an error."""
    found: list[Variable] = []
    scope, body = Scope(), list[Stmt]()
    start: list[Scaled] = []
    errors: list[F] = []
    for k in range(draw(st.integers(1, most))):
        variable = replace(draw(variables(f"x{k}")), unit=draw(st.sampled_from(UNITS)))
        found.append(variable)
        define, local = reading(variable.name, variable.raw.ctype, variable.raw.lo, variable.raw.hi)
        scope.name(variable.name)
        body.append(define)
        sound = draw(st.booleans()) if exact is None else exact
        error = F(0) if sound else (variable.hi - variable.lo) / draw(st.sampled_from([7, 1000, 65536]))
        errors.append(error * variable.unit.scale)
        start.append(read(variable, local, error))
    dice = random.Random(draw(st.integers(0, 2**20)))
    cases = [
        tuple(dice.choice((v.raw.lo, v.raw.hi, dice.randint(v.raw.lo, v.raw.hi))) for v in found) for _ in range(30)
    ]
    truths = [
        tuple(
            v.unit.to_coherent(v.raw.value(r)) + e * dice.choice((-1, 0, 1, F(1, 3)))
            for v, r, e in zip(found, case, errors, strict=True)
        )
        for case in cases
    ]
    return Chain(found, Arithmetic(scope, body), start, cases, truths)


def operate(draw: st.DrawFn, chain: Chain, a: Scaled, b: Scaled) -> tuple[Scaled, Callable[[F, F], F]]:
    """An operation on two values in integers, and the same in rationals."""
    arithmetic = chain.arithmetic
    factor = draw(rationals(-4, 4))
    kinds: dict[str, tuple[Callable[[], Scaled], Callable[[F, F], F]]] = {
        "plus": (lambda: arithmetic.plus(a, b, "sum"), operator.add),
        "minus": (lambda: arithmetic.plus(a, arithmetic.negated(b), "difference"), operator.sub),
        "times": (lambda: arithmetic.times(a, b, "product"), operator.mul),
        "by": (lambda: arithmetic.by_constant(a, factor), lambda x, _: x * factor),
        "shifted": (lambda: arithmetic.plus(a, constant(factor), "shifted"), lambda x, _: x + factor),
        "smallest": (lambda: arithmetic.smallest([a, b], "least"), min),
        "largest": (lambda: arithmetic.largest([a, b, constant(factor)], "most"), lambda x, y: max(x, y, factor)),
        "absolute": (lambda: arithmetic.absolute(a, "size"), lambda x, _: abs(x)),
        "square": (lambda: arithmetic.times(a, a, "square"), lambda x, _: x * x),
    }
    lowered, meaning = kinds[draw(st.sampled_from(sorted(kinds)))]
    return lowered(), meaning


Known = tuple[Scaled, list[F]]
"""A computed value and what it really is in every case."""


def one_of(data: st.DataObject, known: list[Known]) -> Known:
    """Any of them."""
    return known[data.draw(st.integers(0, len(known) - 1))]


def grown(data: st.DataObject, chain: Chain, steps: int) -> list[Known]:
    """Values computed one from another, each with what it really is in every case; what does not fit is left out."""
    known = [(s, [t[k] for t in chain.truths]) for k, s in enumerate(chain.start)]
    for _ in range(steps):
        (a, exact_a), (b, exact_b) = one_of(data, known), one_of(data, known)
        before = len(chain.arithmetic.body)
        try:
            made, meaning = operate(data.draw, chain, a, b)
        except RangeError:
            del chain.arithmetic.body[before:]
            continue
        known.append((made, [meaning(x, y) for x, y in zip(exact_a, exact_b, strict=True)]))
    return known


@settings(max_examples=120)
@given(data=st.data())
def test_chains_stay_within_their_error(data: st.DataObject) -> None:
    """Whatever is computed from whatever, the integers are within the tracked error of the rationals."""
    chain = data.draw(chains())
    for made, exact in grown(data, chain, 5):
        for mine, true in zip(chain.value(made), exact, strict=True):
            assert abs(mine - true) <= made.error
            assert made.lo <= mine <= made.hi


@settings(max_examples=25)
@given(data=st.data())
def test_sums_and_extremes_of_coarse_raws_cost_nothing(data: st.DataObject) -> None:
    """Where the integers stay small, sums, differences, extremes and constant factors have no error at all."""
    body: list[Stmt] = []
    values: list[Scaled] = []
    for name in "xy":
        define, local = reading(name, "uint16", 0, data.draw(st.integers(1, 1000)))
        body.append(define)
        step, offset = (F(data.draw(st.integers(-60, 60)) or 1, data.draw(st.sampled_from([1, 4, 10]))) for _ in "ab")
        values.append(Scaled(local, step, offset, F(0)))
    a, b = values
    arithmetic = Arithmetic(Scope({"x", "y"}), body)
    for made in (
        arithmetic.plus(a, b, "sum"),
        arithmetic.plus(a, arithmetic.negated(b), "difference"),
        arithmetic.by_constant(a, F(1, 7)),
        arithmetic.smallest([a, b, constant(F(3, 2))], "least"),
        arithmetic.absolute(b, "size"),
    ):
        assert made.error == 0


@settings(max_examples=100)
@given(data=st.data())
def test_a_place_takes_the_nearest_raw(data: st.DataObject) -> None:
    """A value in its place: a legal raw within the stated error of the saturated value; what was outside is told of."""
    chain = data.draw(chains(2))
    known = grown(data, chain, 3)
    value, exact = known[-1]
    unit = data.draw(st.sampled_from(UNITS))
    if data.draw(st.booleans()) and value.lo < value.hi:
        # Part of what the value can be, so that it leaves its place at either end.
        part = sorted(data.draw(st.lists(st.fractions(0, 1, max_denominator=20), min_size=2, max_size=2, unique=True)))
        lo, hi = (unit.from_coherent(value.lo + (value.hi - value.lo) * p) for p in part)
        target = data.draw(over("place", lo, hi, unit))
    else:
        target = data.draw(variables("place", unit))
    try:
        placed = place(chain.arithmetic, value, target, "place")
    except RangeError:
        assume(False)
    outside: Expr = Const(0)
    for test in placed.outside:
        outside = Select(test, Const(1), outside, 0, 1)
    told = chain.run({"raw": placed.raw, "outside": outside, "value": value.expr})
    for raw, bit, i, true in zip(told["raw"], told["outside"], told["value"], exact, strict=True):
        wanted = min(max(target.unit.from_coherent(true), target.lo), target.hi)
        assert target.raw.lo <= raw <= target.raw.hi
        assert abs(target.raw.value(raw) - wanted) <= placed.error
        mine = target.unit.from_coherent(value.offset + value.step * i)
        assert bit == (not target.lo <= mine <= target.hi)


def saturated(x: F, y: F, into: tuple[F, F], sign: int) -> F:
    """``x / y`` into a range; ``sign`` is the side from which y comes to 0."""
    if y == 0:
        return into[1] if x * sign > 0 else into[0]
    return min(max(x / y, into[0]), into[1])


@settings(max_examples=120)
@given(data=st.data())
def test_quotients_into_a_range(data: st.DataObject) -> None:
    """x/y saturates into its range within the stated error; x/0 is the end on x's side; 0/0 is settled."""
    chain = data.draw(chains(2, exact=data.draw(st.booleans())))
    known = grown(data, chain, 2)
    x, exact_x = one_of(data, known)
    y, exact_y = one_of(data, known)
    assume(y.lo != y.hi)
    sign = -1 if y.lo < 0 and data.draw(st.booleans()) else 1
    lo = data.draw(rationals(-9, 9))
    into = (lo, lo + data.draw(rationals(1, 20)))
    fallback = constant(data.draw(rationals(-9, 9)))
    divides = data.draw(st.booleans())
    try:
        if y.lo < 0 < y.hi or (sign < 0) == (y.lo >= 0):
            # A divisor has one sign: its size, or what is opposite to it.
            y, exact_y = chain.arithmetic.absolute(y, "size"), [abs(v) for v in exact_y]
            if sign < 0:
                y, exact_y = chain.arithmetic.negated(y), [-v for v in exact_y]
        quotient = divide(chain.arithmetic, x, y, into, divides, "ratio")
        test, band = zero_over_zero(chain.arithmetic, x, y, "zero")
        result = settle(chain.arithmetic, test, quotient, fallback, "settled")
    except RangeError:
        assume(False)
    told = chain.run({"value": result.expr, "zero": Select(test, Const(1), Const(0), 0, 1)})
    for i, zero, true_x, true_y in zip(told["value"], told["zero"], exact_x, exact_y, strict=True):
        mine = result.offset + result.step * i
        if zero:
            assert abs(true_x) <= band and abs(true_y) <= band
            # The place saturates what settles it, too.
            wanted = min(max(fallback.lo, into[0]), into[1])
        elif true_x == true_y == 0:
            # Decided otherwise than in rationals: only where the operands are within the band.
            assert band > 0
            continue
        else:
            wanted = saturated(true_x, true_y, into, sign)
        assert abs(mine - wanted) <= result.error, (true_x, true_y, into)


@settings(max_examples=60)
@given(data=st.data())
def test_quotients_over_their_own_interval(data: st.DataObject) -> None:
    """A divisor that cannot be 0, over the interval of all that the quotient can be: within its error, unsaturated."""
    chain = data.draw(chains(2))
    known = grown(data, chain, 2)
    x, exact_x = one_of(data, known)
    y, exact_y = one_of(data, known)
    away = data.draw(rationals(1, 9)) + 2 * y.error
    try:
        y = chain.arithmetic.plus(chain.arithmetic.absolute(y, "size"), constant(away), "away")
        exact_y = [abs(v) + away for v in exact_y]
        corners = [a / b for a in (x.lo - x.error, x.hi + x.error) for b in (y.lo - y.error, y.hi + y.error)]
        quotient = divide(chain.arithmetic, x, y, (min(corners), max(corners)), False, "ratio")
    except RangeError:
        assume(False)
    for mine, true_x, true_y in zip(chain.value(quotient), exact_x, exact_y, strict=True):
        assert abs(mine - true_x / true_y) <= quotient.error


def ones(test: Test) -> Expr:
    """A test as a number."""
    return Select(test, Const(1), Const(0), 0, 1)


@settings(max_examples=100)
@given(data=st.data(), op=st.sampled_from(sorted(COMPARE)), swapped=st.booleans())
def test_a_raw_and_a_literal_are_decided_exactly(data: st.DataObject, op: str, swapped: bool) -> None:
    """Every raw against any literal, raws' own values among them, either way round: the exact decision, no band."""
    variable = data.draw(variables("x", unit=data.draw(st.sampled_from(UNITS)), most=500))
    own = variable.unit.to_coherent(variable.raw.value(data.draw(st.integers(variable.raw.lo, variable.raw.hi))))
    literal = data.draw(st.just(own) | rationals(-60, 60) | st.just(own + variable.raw.step * variable.unit.scale / 3))
    define, local = reading("x", variable.raw.ctype, variable.raw.lo, variable.raw.hi)
    arithmetic = Arithmetic(Scope({"x"}), [define])
    left, right = read(variable, local), constant(literal)
    test, band = decide(arithmetic, op, *((right, left) if swapped else (left, right)), "test")
    assert band == 0
    raws = np.arange(variable.raw.lo, variable.raw.hi + 1)
    told = outcome(arithmetic.body, {"test": ones(test)}, {"x": raws})["test"]
    for raw, mine in zip(raws.tolist(), told.tolist(), strict=True):
        value = variable.unit.to_coherent(variable.raw.value(raw))
        pair = (literal, value) if swapped else (value, literal)
        assert bool(mine) == COMPARE[op](*pair)


@settings(max_examples=100)
@given(data=st.data(), op=st.sampled_from(sorted(COMPARE)))
def test_computed_values_are_decided_within_the_band(data: st.DataObject, op: str) -> None:
    """Between computed values the decision is the exact one wherever the operands differ by more than the band."""
    chain = data.draw(chains(2))
    known = grown(data, chain, 3)
    left, exact_left = one_of(data, known)
    right, exact_right = one_of(data, [*known, (constant(F(1)), [F(1)] * len(chain.cases))])
    try:
        test, band = decide(chain.arithmetic, op, left, right, "test")
    except RangeError:
        assume(False)
    told = chain.run({"test": ones(test)})["test"]
    for mine, a, b in zip(told, exact_left, exact_right, strict=True):
        assert bool(mine) == COMPARE[op](a, b) or abs(a - b) <= band


def test_defining_is_the_only_statement() -> None:
    """Arithmetic is straight-line code: every statement defines a local, once."""
    scope, body = Scope(), list[Stmt]()
    _, local = reading("x", "uint16", 0, 1000)
    arithmetic = Arithmetic(scope, body)
    x = Scaled(local, F(1, 7), F(3), F(0))
    arithmetic.times(arithmetic.absolute(arithmetic.plus(x, constant(F(-50)), "a"), "b"), x, "c")
    assert all(isinstance(s, Define) and s.constant for s in body)
    names = [s.local.name for s in body if isinstance(s, Define)]
    assert len(names) == len(set(names)) > 0
