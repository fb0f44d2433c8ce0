"""A second meaning of the integer program: one case at a time, plain Python integers, no masks."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import assert_never

from fuzzyspec.fixed.program import (
    Above,
    AllOf,
    AnyOf,
    Assign,
    AssignElement,
    Binary,
    Branch,
    CallFunction,
    Comment,
    Compare,
    Const,
    Define,
    DefineArray,
    Each,
    Element,
    Expr,
    Function,
    Greatest,
    Least,
    ListPort,
    Local,
    Loop,
    MulHigh,
    NotTest,
    Program,
    Quotient,
    ReadField,
    ReadPort,
    ReadState,
    Record,
    Select,
    SetOutput,
    SetState,
    SetStatus,
    Stmt,
    Test,
    Window,
)

BINARY = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.floordiv,
    ">>": operator.rshift,
    "<<": operator.lshift,
}
COMPARE = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}


@dataclass
class Case:
    """One call. ``inputs``: numbers, and lists of records under the list's name; ``counts`` of the lists.

    Decisions are kept as (key, element or None) to the number recorded last.
    """

    program: Program
    function: Function
    inputs: Mapping[str, int | list[dict[str, int]]]
    counts: Mapping[str, int] = field(default_factory=dict)
    state: dict[str, int] = field(default_factory=dict)
    outputs: dict[str, int] = field(default_factory=dict)
    bits: set[str] = field(default_factory=set)
    decisions: dict[tuple[str, int | None], int] = field(default_factory=dict)
    locals: dict[str, int] = field(default_factory=dict)
    arrays: dict[str, list[int]] = field(default_factory=dict)
    windows: dict[str, tuple[int, ...]] = field(default_factory=dict)
    element: int | None = None
    record: dict[str, int] = field(default_factory=dict)

    def call(self) -> Case:
        """Run the body; the case then holds what came out."""
        self.outputs = {p.name: 0 for p in self.function.outputs}
        self.block(self.function.body)
        return self

    @property
    def status(self) -> int:
        return sum(1 << i for i, b in enumerate(self.function.status) if b.name in self.bits)

    def block(self, body: tuple[Stmt, ...]) -> None:
        for stmt in body:
            self.step(stmt)

    def step(self, stmt: Stmt) -> None:
        match stmt:
            case Comment():
                pass
            case Define(local, value, _) | Assign(local, value):
                self.locals[local.name] = self.value(value)
            case DefineArray(name, _, size):
                self.arrays[name] = [0] * size
            case Window(name, _, table, start):
                whole = next(t.values for t in self.function.tables if t.name == table)
                self.windows[name] = whole[self.value(start) :]
            case AssignElement(array, _, index, value):
                self.arrays[array][self.value(index)] = self.value(value)
            case Loop(counter, count, body):
                for i in range(count):
                    self.locals[counter.name] = i
                    self.block(body)
            case Branch(test, then, other):
                self.block(then if self.test(test) else other)
            case Each(name, counter, body):
                port = next(p for p in self.function.inputs if p.name == name)
                assert isinstance(port, ListPort)
                if self.counts[name] > port.capacity:
                    self.bits.add(f"OVERRUN_{name.upper()}")
                records = self.inputs[name]
                assert isinstance(records, list)
                for i in range(min(self.counts[name], port.capacity)):
                    self.locals[counter.name], self.element, self.record = i, i, records[i]
                    self.block(body)
                self.element = None
            case SetOutput(name, value):
                self.outputs[name] = self.value(value)
            case SetState(name, value):
                self.state[name] = self.value(value)
            case SetStatus(bit):
                self.bits.add(bit)
            case CallFunction():
                self.nested(stmt)
            case Record(key, value):
                tested = isinstance(value, Compare | AllOf | AnyOf | NotTest)
                self.decisions[key, self.element] = int(self.test(value) if tested else self.value(value))
            case _:
                assert_never(stmt)

    def nested(self, stmt: CallFunction) -> None:
        callee = self.program.function(stmt.callee)
        prefix = f"{stmt.state}."
        mine = {k.removeprefix(prefix): v for k, v in self.state.items() if k.startswith(prefix)}
        given = {p.name: self.value(a) for p, a in zip(callee.inputs, stmt.arguments, strict=True)}
        inner = Case(self.program, callee, given, state=mine).call()
        for output, local in stmt.results:
            self.locals[local.name] = inner.outputs[output]
        self.state.update({prefix + k: v for k, v in inner.state.items()})
        self.bits |= {mine for theirs, mine in stmt.held if theirs in inner.bits}
        # What an earlier call by this statement decided is forgotten, as its other results are.
        for key in [k for k in self.decisions if k[0].startswith(f"{stmt.id}.") and k[1] == self.element]:
            del self.decisions[key]
        self.decisions |= {(f"{stmt.id}.{key}", self.element): v for (key, _), v in inner.decisions.items()}

    def value(self, expr: Expr) -> int:
        result = self._value(expr)
        assert expr.lo <= result <= expr.hi, (expr, result)
        return result

    def _value(self, expr: Expr) -> int:
        match expr:
            case Const(value):
                return value
            case Local(name):
                return self.locals[name]
            case Element(array, _, index, _, _, table):
                tables = {t.name: t.values for t in self.function.tables} | self.windows
                return (tables if table else self.arrays)[array][self.value(index)]
            case ReadPort(name):
                found = self.inputs[name]
                assert isinstance(found, int)
                return found
            case ReadField(_, name):
                return self.record[name]
            case ReadState(name):
                return self.state[name]
            case Binary(op, left, right):
                return BINARY[op](self.value(left), self.value(right))
            case Least(left, right):
                return min(self.value(left), self.value(right))
            case Greatest(left, right):
                return max(self.value(left), self.value(right))
            case Above(left, right):
                return max(self.value(left) - self.value(right), 0)
            case Select(test, then, other):
                return self.value(then) if self.test(test) else self.value(other)
            case MulHigh(left, right):
                return self.value(left) * self.value(right) // 65536
            case Quotient(num, den):
                n, d = self.value(num), self.value(den)
                return n * 65536 // d if n < d else 65536
            case _:
                assert_never(expr)

    def test(self, test: Test) -> bool:
        match test:
            case Compare(op, left, right):
                return bool(COMPARE[op](self.value(left), self.value(right)))
            case AllOf(operands):
                return all(self.test(t) for t in operands)
            case AnyOf(operands):
                return any(self.test(t) for t in operands)
            case NotTest(operand):
                return not self.test(operand)
            case _:
                assert_never(test)
