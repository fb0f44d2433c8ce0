"""What one step of a system means, in float64 over any number of cases."""

from __future__ import annotations

from collections.abc import Callable
from typing import assert_never

import numpy as np

from fuzzyspec.exact.affine import Affine, affine
from fuzzyspec.exact.controller import evaluate_controller
from fuzzyspec.exact.place import Place
from fuzzyspec.exact.result import Arrays, Bools, Exact, Floats, Ints
from fuzzyspec.exact.signals import Signals, saturated_into, signals, to_coherent
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

_COMPARE: dict[str, Callable[[Floats, Floats | np.float64], Bools]] = {
    "<": np.less,
    "<=": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "==": np.equal,
    "!=": np.not_equal,
}
_TURNED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}


def evaluate_system(
    system: System, inputs: Arrays, decisions: Arrays | None = None, state: Arrays | None = None
) -> Exact:
    """The exact meaning of one step.

    ``inputs``: (N,) or scalar a signal, (N, M) a field of a list, whose ``<list>.count`` says how many of the M records
    count (at most the capacity); declared units, saturated to the declared ranges. Values are carried as reals
    throughout: a controller's argument saturates to its input's range and is not rounded to a raw. ``decisions`` are
    taken where given (-1: not given), (N,) or (N, capacity). ``state``: ``<call>.<output>`` of what is held.
    Raises KeyError for a missing signal, ValueError where a count exceeds the records.
    """
    given, held = decisions or {}, state or {}
    step = _Step(system, signals(system, inputs, {**given, **held}), given, held)
    for statement in system.statements:
        match statement:
            case ForEach(over, body):
                inner = step.top.inside(over, step.signals.elements[over])
                for each in body:
                    step.run(each, inner)
            case Let() | Call():
                step.run(statement, step.top)
            case _:
                assert_never(statement)
    for output in system.outputs:
        step.leave(output)
    return step.result


class _Step:
    """What is known while a step is evaluated."""

    def __init__(self, system: System, known: Signals, given: Arrays, held: Arrays) -> None:
        self.signals = known
        self.top = Place((), np.ones(known.cases, dtype=np.bool_))
        self.result = Exact({}, {}, {}, {})
        self._given = given
        self._held = held
        self._intervals = Intervals.of_system(system)
        self._variables: dict[ReadInput | ReadField, Variable] = {}
        for i in system.inputs:
            if isinstance(i, ListInput):
                self._variables |= {ReadField(i.name, f.name): f for f in i.fields}
            else:
                self._variables[ReadInput(i.name)] = i
        self._lets: dict[ReadLet, tuple[Let, Floats]] = {}
        self._calls: dict[str, tuple[Call, str | None, dict[str, Floats]]] = {}

    # --- statements ----------------------------------------------------------------------------

    def run(self, statement: Let | Call, place: Place) -> None:
        over = place.lists[-1] if place.lists else None
        match statement:
            case Let(name, value):
                array = np.array(np.broadcast_to(self.number(value, place), place.shape))
                self._lets[ReadLet(name, over)] = (statement, array)
            case Call():
                self._calls[statement.id] = (statement, over, self._call(statement, place))
            case _:
                assert_never(statement)

    def _call(self, call: Call, place: Place) -> dict[str, Floats]:
        """The controller's outputs, in declared units; evaluated only for what is asked."""
        asked = np.nonzero(place.active)
        arguments = {
            i.name: np.broadcast_to(self._put(a, i.variable, place), place.shape)[asked]
            for i, a in zip(call.controller.inputs, call.arguments, strict=True)
        }
        prefix = f"{call.id}."
        decisions = {
            key.removeprefix(prefix): np.broadcast_to(np.asarray(value), place.shape)[asked]
            for key, value in self._given.items()
            if key.startswith(prefix)
        }
        state = {
            key.removeprefix(prefix): np.broadcast_to(np.asarray(value), place.shape)[asked]
            for key, value in self._held.items()
            if key.startswith(prefix)
        }
        got = evaluate_controller(call.controller, arguments, decisions, state)
        for key, decision in got.decisions.items():
            self.result.decisions[prefix + key] = _scattered(decision, place, -1).astype(np.int64)
            self.result.margins[prefix + key] = _scattered(got.margins[key], place, np.inf)
        for name, value in got.state.items():
            self.result.state[prefix + name] = _scattered(value, place, 0.0)
        return {name: _scattered(value, place, 0.0) for name, value in got.outputs.items()}

    def leave(self, output: SystemOutput | ActingOutput) -> None:
        match output:
            case SystemOutput(variable, value):
                array = self._put(value, variable, self.top)
            case ActingOutput(_, call):
                array = self._calls[call][2]["acting"]
            case _:
                assert_never(output)
        self.result.outputs[output.name] = np.array(np.broadcast_to(array, self.top.shape))

    def _put(self, expr: Expr, into: Variable, place: Place) -> Floats:
        """A value put into a variable: its unit, its range. What is handed on in its own unit stays untouched."""
        match expr:
            case ReadInput() | ReadField() if _alike(self._variables[expr], into):
                value = self._read(expr, place)
            case CallOutput(call, output) if _alike(self._called(call, output), into):
                value = self._call_output(expr, place)
            case _:
                return saturated_into(self.number(expr, place), into)
        return np.clip(value, float(into.lo), float(into.hi))

    # --- numbers -------------------------------------------------------------------------------

    def number(self, expr: Expr, place: Place) -> Floats:
        """In coherent units, broadcastable to the place's shape."""
        match expr:
            case Const(value):
                return np.full((1,) * len(place.shape), float(value))
            case ReadInput() | ReadField():
                return to_coherent(self._read(expr, place), self._variables[expr].unit)
            case ReadLet(_, over):
                return place.align(self._lets[expr][1], over)
            case CallOutput(call, output):
                return to_coherent(self._call_output(expr, place), self._called(call, output).unit)
            case Add(left, right):
                return self.number(left, place) + self.number(right, place)
            case Sub(left, right):
                return self.number(left, place) - self.number(right, place)
            case Mul(left, right):
                return self.number(left, place) * self.number(right, place)
            case Neg(operand):
                return -self.number(operand, place)
            case Div():
                return self._quotient(expr, place)
            case Least(operands):
                return np.asarray(np.minimum.reduce(np.broadcast_arrays(*(self.number(o, place) for o in operands))))
            case Greatest(operands):
                return np.asarray(np.maximum.reduce(np.broadcast_arrays(*(self.number(o, place) for o in operands))))
            case Clamp(operand, lo, hi):
                return np.asarray(np.clip(self.number(operand, place), float(lo), float(hi)))
            case Abs(operand):
                return np.abs(self.number(operand, place))
            case If(test, then, other):
                holds = self.test(test, place)
                return np.where(holds, self.number(then, place.where(holds)), self.number(other, place.where(~holds)))
            case Fold():
                return self._fold(expr, place)
            case _:
                assert_never(expr)

    def _read(self, read: ReadInput | ReadField, place: Place) -> Floats:
        """In the declared unit."""
        if isinstance(read, ReadInput):
            return place.align(self.signals.scalars[read.name], None)
        return place.align(self.signals.fields[read.list, read.field], read.list)

    def _called(self, call: str, output: str) -> Variable:
        return next(o.variable for o in self._calls[call][0].controller.outputs if o.name == output)

    def _call_output(self, read: CallOutput, place: Place) -> Floats:
        """In the declared unit."""
        _, over, outputs = self._calls[read.call]
        return place.align(outputs[read.output], over)

    def _quotient(self, expr: Div, place: Place) -> Floats:
        left, right = np.broadcast_arrays(self.number(expr.left, place), self.number(expr.right, place))
        by_zero = right == 0
        # a quotient beyond float64 saturates like any other that is too large for its place
        with np.errstate(over="ignore"):
            value: Floats = np.divide(left, right, out=np.zeros(left.shape), where=~by_zero)
        if expr.into is not None:
            lo, hi = (float(end) for end in expr.into)
            # the divisor comes to 0 from inside its range, which does not hold both signs
            from_below = self._intervals.of(expr.right)[1] <= 0
            side = -left if from_below else left
            at_zero = np.where(side > 0, hi, np.where(side < 0, lo, 0.0))
            value = np.asarray(np.clip(np.where(by_zero, at_zero, value), lo, hi))
        if expr.otherwise is None:
            return value
        neither = by_zero & (left == 0)
        apart = np.maximum(np.abs(left), np.abs(right))
        settled = self._decide(expr.key, neither, apart, place)
        return np.where(settled, self.number(expr.otherwise, place.where(settled)), value)

    def _fold(self, expr: Fold, place: Place) -> Floats:
        inner = place.inside(expr.list, self.signals.elements[expr.list])
        if expr.test is not None:
            inner = inner.where(self.test(expr.test, inner))
        counted = inner.active
        if expr.body is None:
            return np.asarray(counted.sum(axis=-1), dtype=np.float64)
        body = np.broadcast_to(self.number(expr.body, inner), inner.shape)
        if expr.kind in ("sum", "count"):
            total: Floats = np.where(counted, body, 0.0).sum(axis=-1)
            return total
        worst = -np.inf if expr.kind == "max" else np.inf
        kept = np.where(counted, body, worst)
        best = kept.max(axis=-1, initial=worst) if expr.kind == "max" else kept.min(axis=-1, initial=worst)
        none: Bools = np.logical_not(counted.any(axis=-1))
        otherwise = 0.0 if expr.otherwise is None else self.number(expr.otherwise, place.where(none))
        return np.where(none, otherwise, best)

    # --- decisions -----------------------------------------------------------------------------

    def test(self, test: Test, place: Place) -> Bools:
        """Every comparison in it is a decision, asked whatever the others say."""
        match test:
            case Compare():
                return self._compare(test, place)
            case Both(operands):
                return np.asarray(np.logical_and.reduce([self.test(o, place) for o in operands]))
            case Either(operands):
                return np.asarray(np.logical_or.reduce([self.test(o, place) for o in operands]))
            case Neither(operand):
                return ~self.test(operand, place)
            case _:
                assert_never(test)

    def _compare(self, test: Compare, place: Place) -> Bools:
        left, right = affine(test.left, self._let), affine(test.right, self._let)
        if left is not None and right is not None and (left.read is None) != (right.read is None):
            if left.read is None:
                return self._compare_read(test, _TURNED[test.op], right, left, place)
            return self._compare_read(test, test.op, left, right, place)
        a, b = self.number(test.left, place), self.number(test.right, place)
        return self._decide(test.key, _COMPARE[test.op](a, b), np.abs(a - b), place)

    def _let(self, read: ReadLet) -> Let:
        return self._lets[read][0]

    def _compare_read(self, test: Compare, op: str, moving: Affine, fixed: Affine, place: Place) -> Bools:
        """Compare a signal with the one value, in its own unit, at which the sides are equal."""
        assert moving.read is not None
        unit = self._variables[moving.read].unit
        level = np.float64(float(unit.from_coherent((fixed.offset - moving.offset) / moving.slope)))
        slope = moving.slope * unit.scale
        value = self._read(moving.read, place)
        holds = _COMPARE[op if slope > 0 else _TURNED[op]](value, level)
        return self._decide(test.key, holds, np.abs(value - level) * abs(float(slope)), place)

    def _decide(self, key: str, own: Bools, margin: Floats, place: Place) -> Bools:
        """Record a decision; give the outcome that is to be taken."""
        own = np.broadcast_to(own, place.shape)
        self.result.decisions[key] = np.where(place.active, own, -1).astype(np.int64)
        self.result.margins[key] = np.where(place.active, margin, np.inf)
        if key not in self._given:
            return own
        told = np.broadcast_to(np.asarray(self._given[key]), place.shape)
        return np.where(told < 0, own, told > 0)


def _alike(a: Variable, b: Variable) -> bool:
    return (a.unit.scale, a.unit.offset) == (b.unit.scale, b.unit.offset)


def _scattered(values: Floats | Ints, place: Place, elsewhere: float) -> Floats:
    """Values of what is asked, put back into the place's shape."""
    whole = np.full(place.shape, elsewhere, dtype=np.float64)
    whole[place.active] = values
    return whole
