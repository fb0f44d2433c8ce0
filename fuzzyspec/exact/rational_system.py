"""The meaning of a system's step at one point, in rationals: element by element, as a person would work it out."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import assert_never

from fuzzyspec.exact.rational import Point, controller_point
from fuzzyspec.model.interval import Intervals
from fuzzyspec.model.system import (
    Abs,
    ActingOutput,
    Add,
    Both,
    Call,
    CallOutput,
    Clamp,
    Compare,
    Const,
    Div,
    Either,
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
    Neither,
    ReadField,
    ReadInput,
    ReadLet,
    Sub,
    System,
    SystemOutput,
    Test,
)
from fuzzyspec.model.variable import Variable

ZERO = Fraction(0)

Given = Mapping[str, Fraction | int | Sequence[Fraction]]
Element = Mapping[str, int]
"""The number of the current element of each list whose loop or fold an expression stands in."""
Where = tuple[str, tuple[int, ...]]
"""A decision's key and the elements it is taken for, outermost list first."""

_COMPARE: dict[str, Callable[[Fraction, Fraction], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}


@dataclass(frozen=True, slots=True)
class SystemPoint:
    """As ``Exact``, for one case; decisions and margins by key and element number (none outside loops).

    What is not asked has no entry.
    """

    outputs: dict[str, Fraction]
    decisions: dict[Where, int]
    margins: dict[Where, Fraction]
    state: dict[str, Fraction]


def evaluate_system_exactly(
    system: System,
    inputs: Given,
    decisions: Mapping[str, int | Sequence[int]] | None = None,
    state: Mapping[str, Fraction] | None = None,
) -> dict[str, Fraction]:
    """The outputs at one point, in declared units; the rest as for ``evaluate_system``, for one case."""
    return system_point(system, inputs, decisions, state).outputs


def system_point(
    system: System,
    inputs: Given,
    decisions: Mapping[str, int | Sequence[int]] | None = None,
    state: Mapping[str, Fraction] | None = None,
) -> SystemPoint:
    """One step at one point, with its decisions and their margins."""
    step = _Step(system, inputs, decisions or {}, state or {})
    for statement in system.statements:
        match statement:
            case ForEach(over, body):
                for number in range(step.count[over]):
                    for each in body:
                        step.run(each, {over: number})
            case Let() | Call():
                step.run(statement, {})
            case _:
                assert_never(statement)
    for output in system.outputs:
        match output:
            case SystemOutput(variable, value):
                step.result.outputs[output.name] = step.put(value, variable, {})
            case ActingOutput(name, call):
                step.result.outputs[name] = Fraction(step.called(call, {}).acting)
            case _:
                assert_never(output)
    return step.result


class _Step:
    """What is known while a step is worked out."""

    def __init__(
        self,
        system: System,
        inputs: Given,
        given: Mapping[str, int | Sequence[int]],
        held: Mapping[str, Fraction],
    ) -> None:
        self.result = SystemPoint({}, {}, {}, {})
        self.count: dict[str, int] = {}
        self._given = given
        self._held = held
        self._intervals = Intervals.of_system(system)
        self._inputs: dict[str, Fraction] = {}
        self._fields: dict[tuple[str, str, int], Fraction] = {}
        self._lets: dict[tuple[str, int | None], Fraction] = {}
        self._calls: dict[tuple[str, int | None], tuple[Call, Point]] = {}
        self._loops: dict[str, str | None] = {}
        for i in system.inputs:
            if isinstance(i, ListInput):
                self.count[i.name] = max(0, min(i.capacity, _whole(inputs[f"{i.name}.count"])))
                for f in i.fields:
                    values = inputs[f"{i.name}.{f.name}"]
                    assert isinstance(values, Sequence)
                    for number in range(self.count[i.name]):
                        self._fields[i.name, f.name, number] = _read(values[number], f)
            else:
                value = inputs[i.name]
                assert not isinstance(value, Sequence)
                self._inputs[i.name] = _read(Fraction(value), i)

    def run(self, statement: Let | Call, at: Element) -> None:
        over = next(iter(at), None)
        number = at[over] if over is not None else None
        match statement:
            case Let(name, value):
                self._lets[name, number] = self.number(value, at)
            case Call(identity):
                self._loops[identity] = over
                self._calls[identity, number] = (statement, self._call(statement, at))
            case _:
                assert_never(statement)

    def _call(self, call: Call, at: Element) -> Point:
        prefix = f"{call.id}."
        arguments = {
            i.name: self.put(a, i.variable, at) for i, a in zip(call.controller.inputs, call.arguments, strict=True)
        }
        told = {key.removeprefix(prefix): self._told(key, at) for key in self._given if key.startswith(prefix)}
        held = {k.removeprefix(prefix): v for k, v in self._held.items() if k.startswith(prefix)}
        point = controller_point(call.controller, arguments, told, held)
        for key, decision in point.decisions.items():
            self.result.decisions[prefix + key, tuple(at.values())] = decision
            self.result.margins[prefix + key, tuple(at.values())] = point.margins[key]
        self.result.state.update({prefix + name: value for name, value in point.state.items()})
        return point

    def called(self, call: str, at: Element) -> Point:
        """What a call gave, in the loop it stands in."""
        over = self._loops[call]
        return self._calls[call, None if over is None else at[over]][1]

    def put(self, expr: Expr, into: Variable, at: Element) -> Fraction:
        """A value put into a variable: its unit, its range."""
        return max(into.lo, min(into.hi, into.unit.from_coherent(self.number(expr, at))))

    def number(self, expr: Expr, at: Element) -> Fraction:
        """In coherent units."""
        match expr:
            case Const(value):
                return value
            case ReadInput(name):
                return self._inputs[name]
            case ReadField(over, field):
                return self._fields[over, field, at[over]]
            case ReadLet(name, over):
                return self._lets[name, None if over is None else at[over]]
            case CallOutput(call, output):
                controller = next(c for (name, _), (c, _) in self._calls.items() if name == call).controller
                unit = next(o.variable.unit for o in controller.outputs if o.name == output)
                return unit.to_coherent(self.called(call, at).outputs[output])
            case Add(left, right):
                return self.number(left, at) + self.number(right, at)
            case Sub(left, right):
                return self.number(left, at) - self.number(right, at)
            case Mul(left, right):
                return self.number(left, at) * self.number(right, at)
            case Neg(operand):
                return -self.number(operand, at)
            case Div():
                return self._quotient(expr, at)
            case Least(operands):
                return min(self.number(o, at) for o in operands)
            case Greatest(operands):
                return max(self.number(o, at) for o in operands)
            case Clamp(operand, lo, hi):
                return max(lo, min(hi, self.number(operand, at)))
            case Abs(operand):
                return abs(self.number(operand, at))
            case If(test, then, other):
                return self.number(then if self.test(test, at) else other, at)
            case Fold():
                return self._fold(expr, at)
            case _:
                assert_never(expr)

    def _quotient(self, expr: Div, at: Element) -> Fraction:
        left, right = self.number(expr.left, at), self.number(expr.right, at)
        if expr.otherwise is not None:
            settled = self._decide(expr.key, left == right == 0, max(abs(left), abs(right)), at)
            if settled:
                return self.number(expr.otherwise, at)
        if expr.into is None:
            return left / right
        lo, hi = expr.into
        if right != 0:
            return max(lo, min(hi, left / right))
        if left == 0:
            return max(lo, min(hi, ZERO))
        negative = self._intervals.of(expr.right)[1] <= 0
        return hi if (left > 0) != negative else lo

    def _fold(self, expr: Fold, at: Element) -> Fraction:
        elements = [{**at, expr.list: number} for number in range(self.count[expr.list])]
        passing = [e for e in elements if expr.test is None or self.test(expr.test, e)]
        if expr.body is None:
            return Fraction(len(passing))
        values = [self.number(expr.body, e) for e in passing]
        if expr.kind == "sum":
            return sum(values, ZERO)
        if values:
            return max(values) if expr.kind == "max" else min(values)
        assert expr.otherwise is not None
        return self.number(expr.otherwise, at)

    def test(self, test: Test, at: Element) -> bool:
        """Every comparison in it is a decision, asked whatever the others say."""
        match test:
            case Compare(op, left, right, key):
                a, b = self.number(left, at), self.number(right, at)
                return self._decide(key, _COMPARE[op](a, b), abs(a - b), at)
            case Both(operands):
                outcomes = [self.test(o, at) for o in operands]
                return all(outcomes)
            case Either(operands):
                outcomes = [self.test(o, at) for o in operands]
                return any(outcomes)
            case Neither(operand):
                return not self.test(operand, at)
            case _:
                assert_never(test)

    def _decide(self, key: str, own: bool, margin: Fraction, at: Element) -> bool:
        self.result.decisions[key, tuple(at.values())] = int(own)
        self.result.margins[key, tuple(at.values())] = margin
        told = self._told(key, at)
        return own if told < 0 else bool(told)

    def _told(self, key: str, at: Element) -> int:
        given = self._given.get(key, -1)
        if isinstance(given, Sequence):
            return given[list(at.values())[-1]]
        return given


def _whole(value: Fraction | int | Sequence[Fraction]) -> int:
    if isinstance(value, Sequence) or value != int(value):
        raise ValueError(f"a count is a whole number, not {value}")
    return int(value)


def _read(value: Fraction, variable: Variable) -> Fraction:
    """Saturated, in coherent units."""
    return variable.unit.to_coherent(max(variable.lo, min(variable.hi, value)))
