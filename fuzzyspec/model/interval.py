"""The closed interval that an expression of a system lies in over the declared ranges, in coherent units.

Exact rationals, conservative: a quotient or a difference of related quantities is taken as if they were unrelated.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import assert_never

from fuzzyspec.model.system import (
    Abs,
    Add,
    Call,
    CallOutput,
    Clamp,
    Const,
    Div,
    Expr,
    Fold,
    ForEach,
    Greatest,
    If,
    Least,
    Let,
    ListInput,
    Mul,
    Neg,
    ReadField,
    ReadInput,
    ReadLet,
    Sub,
    System,
)
from fuzzyspec.model.variable import Variable

Interval = tuple[Fraction, Fraction]

ZERO = Fraction(0)


def range_of(variable: Variable) -> Interval:
    """A variable's range in coherent units."""
    return variable.unit.to_coherent(variable.lo), variable.unit.to_coherent(variable.hi)


def hull(*intervals: Interval) -> Interval:
    """The smallest interval that holds all."""
    return min(i[0] for i in intervals), max(i[1] for i in intervals)


def product(a: Interval, b: Interval) -> Interval:
    """Of two unrelated factors."""
    ends = [x * y for x in a for y in b]
    return min(ends), max(ends)


def square(a: Interval) -> Interval:
    """Of one factor with itself."""
    ends = [a[0] * a[0], a[1] * a[1]]
    return ZERO if a[0] <= 0 <= a[1] else min(ends), max(ends)


def quotient(n: Interval, d: Interval) -> tuple[Fraction | None, Fraction | None]:
    """Of ``n`` by ``d``, which does not hold both signs; None is an end that is not bounded."""
    if d[1] <= 0:
        n, d = (-n[1], -n[0]), (-d[1], -d[0])
    if d[1] == 0:
        return None, None
    if d[0] > 0:
        ends = [x / y for x in n for y in d]
        return min(ends), max(ends)
    return n[0] / d[1] if n[0] >= 0 else None, n[1] / d[1] if n[1] <= 0 else None


def saturated(lo: Fraction | None, hi: Fraction | None, into: Interval) -> Interval:
    """An interval, possibly unbounded, after saturation into a range."""

    def clip(x: Fraction) -> Fraction:
        return max(into[0], min(into[1], x))

    return into[0] if lo is None else clip(lo), into[1] if hi is None else clip(hi)


MOST_BITS = 512
"""Denominators longer than this are shortened, outwards, lest products of products grow without end."""


def shortened(interval: Interval) -> Interval:
    """An interval that holds another, with ends of bounded length; short ends stay what they are."""
    scale = 2**MOST_BITS
    lo, hi = interval
    if lo.denominator > scale:
        lo = Fraction(math.floor(lo * scale), scale)
    if hi.denominator > scale:
        hi = Fraction(math.ceil(hi * scale), scale)
    return lo, hi


class Intervals:
    """What is known of a system's names; ``of`` gives an expression's interval from it."""

    def __init__(self) -> None:
        self._inputs: dict[str, Interval] = {}
        self._fields: dict[tuple[str, str], Interval] = {}
        self._capacity: dict[str, int] = {}
        self._lets: dict[tuple[str, str | None], Interval] = {}
        self._outputs: dict[tuple[str, str], Interval] = {}

    @classmethod
    def of_system(cls, system: System) -> Intervals:
        """With all of a checked system's names."""
        known = cls()
        for i in system.inputs:
            known.add_input(i)
        for statement in system.statements:
            match statement:
                case ForEach(list=over, body=body):
                    for inner in body:
                        known.add_statement(inner, over)
                case Let() | Call():
                    known.add_statement(statement, None)
                case _:
                    assert_never(statement)
        return known

    def add_input(self, declared: Variable | ListInput) -> None:
        if isinstance(declared, ListInput):
            self._capacity[declared.name] = declared.capacity
            for f in declared.fields:
                self._fields[declared.name, f.name] = range_of(f)
        else:
            self._inputs[declared.name] = range_of(declared)

    def add_statement(self, statement: Let | Call, over: str | None) -> None:
        """Add a ``let`` or a call; ``over`` is the list whose loop it stands in."""
        match statement:
            case Let(name=name, value=value):
                self._lets[name, over] = shortened(self.of(value))
            case Call(id=call, controller=controller):
                for o in controller.outputs:
                    self._outputs[call, o.name] = range_of(o.variable)
            case _:
                assert_never(statement)

    def of(self, expr: Expr) -> Interval:
        """The interval of an expression whose names were all added."""
        match expr:
            case Const(value=value):
                return value, value
            case ReadInput(name=name):
                return self._inputs[name]
            case ReadField(list=over, field=field):
                return self._fields[over, field]
            case ReadLet(name=name, list=over):
                return self._lets[name, over]
            case CallOutput(call=call, output=output):
                return self._outputs[call, output]
            case Add(left=left, right=right):
                a, b = self.of(left), self.of(right)
                return a[0] + b[0], a[1] + b[1]
            case Sub(left=left, right=right):
                a, b = self.of(left), self.of(right)
                return a[0] - b[1], a[1] - b[0]
            case Mul(left=left, right=right):
                return square(self.of(left)) if left == right else product(self.of(left), self.of(right))
            case Neg(operand=operand):
                a = self.of(operand)
                return -a[1], -a[0]
            case Div():
                return self._quotient(expr)
            case Least(operands=operands):
                each = [self.of(o) for o in operands]
                return min(i[0] for i in each), min(i[1] for i in each)
            case Greatest(operands=operands):
                each = [self.of(o) for o in operands]
                return max(i[0] for i in each), max(i[1] for i in each)
            case Clamp(operand=operand, lo=lo, hi=hi):
                return saturated(*self.of(operand), (lo, hi))
            case Abs(operand=operand):
                a = self.of(operand)
                ends = [abs(a[0]), abs(a[1])]
                return ZERO if a[0] <= 0 <= a[1] else min(ends), max(ends)
            case If(then=then, other=other):
                return hull(self.of(then), self.of(other))
            case Fold():
                return self._fold(expr)
            case _:
                assert_never(expr)

    def _quotient(self, expr: Div) -> Interval:
        lo, hi = quotient(self.of(expr.left), self.of(expr.right))
        if expr.into is not None:
            result = saturated(lo, hi, expr.into)
        elif lo is None or hi is None:
            raise ValueError("a divisor that can be 0 needs a range to saturate into")
        else:
            result = lo, hi
        return result if expr.otherwise is None else hull(result, self.of(expr.otherwise))

    def _fold(self, expr: Fold) -> Interval:
        capacity = self._capacity[expr.list]
        if expr.body is None:
            return ZERO, Fraction(capacity)
        body = self.of(expr.body)
        if expr.kind == "sum":
            return min(ZERO, capacity * body[0]), max(ZERO, capacity * body[1])
        return body if expr.otherwise is None else hull(body, self.of(expr.otherwise))


def interval(expr: Expr, system: System) -> Interval:
    """The interval of an expression of a checked system; to ask often, keep ``Intervals.of_system``."""
    return Intervals.of_system(system).of(expr)
