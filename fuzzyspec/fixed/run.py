"""Run a program over numpy arrays: the integer model that the C must equal bit for bit.

Lanes are cases. A branch runs once for all lanes under a mask; nothing here rounds, wraps or saturates but by the
program's
own nodes. int64 holds every product of two 32-bit values that a node can make.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, assert_never

import numpy as np
import numpy.typing as npt

from fuzzyspec.fixed.program import (
    Above,
    AllOf,
    AnyOf,
    Assign,
    AssignElement,
    Binary,
    BinaryOp,
    Branch,
    CallFunction,
    Comment,
    Compare,
    CompareOp,
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

Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

Visit = Callable[[tuple[Stmt, ...], int], None]
"""Told a block and how many lanes enter it."""

CHUNK = 1 << 14
"""Lanes at a time: small enough that a program's locals stay in cache."""


@dataclass(frozen=True)
class Run:
    """``outputs``, ``state``: name to (N,) raws; ``status``: (N,); ``decisions``: key to (N,) or (N, capacity).

    State of a nested call is named ``<call>.<output>``. A decision that was not taken (an element beyond the
    count) is -1.
    """

    outputs: dict[str, Ints]
    status: Ints
    state: dict[str, Ints]
    decisions: dict[str, Ints]


_ARITHMETIC: Mapping[BinaryOp, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.floordiv,
    ">>": operator.rshift,
    "<<": operator.lshift,
    "&": operator.and_,
    "|": operator.or_,
    "^": operator.xor,
}
_COMPARISON: Mapping[CompareOp, Callable[[Any, Any], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}


class IntervalError(AssertionError):
    """A value left the interval that its node claims: a bug of the compiler."""


def run(
    program: Program,
    function_name: str,
    inputs: Mapping[str, npt.ArrayLike],
    state: Mapping[str, npt.ArrayLike] | None = None,
    record: bool = False,
    checked: bool = False,
    visit: Visit | None = None,
) -> Run:
    """Run one function over arrays of raws.

    ``inputs``: scalars ``name`` of shape (N,), list fields ``list.field`` of shape (N, M), counts ``list.count`` of
    shape (N,). ``state`` as in :class:`Run`, else the initial one. With ``record`` the decisions are kept; with
    ``checked`` every value is held against its node's interval (:class:`IntervalError`). ``visit`` is told of every
    block that is entered, those of called functions included.
    Raises KeyError for a missing signal and ValueError for shapes that do not agree.
    """
    function = program.function(function_name)
    arrays = {k: np.asarray(v).astype(np.int64) for k, v in inputs.items()}
    lanes = _lanes(function, arrays)
    held = {
        k: np.broadcast_to(np.asarray(v, dtype=np.int64), (lanes,))
        for k, v in (state or initial_state(program, function)).items()
    }
    parts: list[Run] = []
    for start in range(0, max(lanes, 1), CHUNK):
        part = slice(start, min(start + CHUNK, lanes))
        frame = _Frame(
            program,
            function,
            part.stop - part.start,
            {k: v[part] for k, v in arrays.items()},
            {k: v[part].copy() for k, v in held.items()},
            record,
            checked,
            visit,
        )
        frame.block(function.body, None)
        parts.append(Run(frame.outputs, frame.status, frame.state, frame.decisions))
    return _join(parts)


def initial_state(program: Program, function: Function) -> dict[str, int]:
    """Raws that ``init`` stores."""
    found = {s.name: s.initial for s in function.state}
    for name, callee in function.nested:
        for key, value in initial_state(program, program.function(callee)).items():
            found[f"{name}.{key}"] = value
    return found


def decision_shapes(program: Program, function: Function) -> dict[str, int | None]:
    """Every decision's key; the value is the list's capacity where it is taken once an element."""
    lists = {p.name: p.capacity for p in function.inputs if isinstance(p, ListPort)}
    found: dict[str, int | None] = {}

    def walk(body: tuple[Stmt, ...], capacity: int | None) -> None:
        for stmt in body:
            match stmt:
                case Record(key, _):
                    found[key] = capacity
                case CallFunction(id=name, callee=callee):
                    for key in decision_shapes(program, program.function(callee)):
                        found[f"{name}.{key}"] = capacity
                case Loop(_, _, inner):
                    walk(inner, capacity)
                case Each(list_, _, inner):
                    walk(inner, lists[list_])
                case Branch(_, then, other):
                    walk(then, capacity)
                    walk(other, capacity)
                case _:
                    pass

    walk(function.body, None)
    return found


def _lanes(function: Function, arrays: Mapping[str, Ints]) -> int:
    sizes: set[int] = set()
    for port in function.inputs:
        names = (
            [port.name]
            if not isinstance(port, ListPort)
            else [f"{port.name}.{f.name}" for f in port.fields] + [f"{port.name}.count"]
        )
        for name in names:
            if name not in arrays:
                raise KeyError(f"no values for the signal {name!r}")
            sizes.add(arrays[name].shape[0])
    if len(sizes) > 1:
        raise ValueError("the signals' arrays differ in length")
    return sizes.pop() if sizes else 1


def _join(parts: list[Run]) -> Run:
    if len(parts) == 1:
        return parts[0]

    def cat(dicts: list[dict[str, Ints]]) -> dict[str, Ints]:
        return {k: np.concatenate([d[k] for d in dicts]) for k in dicts[0]}

    return Run(
        cat([p.outputs for p in parts]),
        np.concatenate([p.status for p in parts]),
        cat([p.state for p in parts]),
        cat([p.decisions for p in parts]),
    )


@dataclass
class _Frame:
    program: Program
    function: Function
    n: int
    inputs: dict[str, Ints]
    state: dict[str, Ints]
    record: bool
    checked: bool
    visit: Visit | None
    outputs: dict[str, Ints] = field(default_factory=dict)
    locals: dict[str, Any] = field(default_factory=dict)
    arrays: dict[str, Ints] = field(default_factory=dict)
    windows: dict[str, tuple[Ints, Any]] = field(default_factory=dict)
    decisions: dict[str, Ints] = field(default_factory=dict)
    element: int | None = None
    mask: Bools | None = None

    def __post_init__(self) -> None:
        self.status = np.zeros(self.n, dtype=np.int64)
        self.lane = np.arange(self.n)
        self.bits = {bit.name: 1 << i for i, bit in enumerate(self.function.status)}
        self.tables = {t.name: np.array(t.values, dtype=np.int64) for t in self.function.tables}
        for port in self.function.outputs:
            self.outputs[port.name] = np.zeros(self.n, dtype=np.int64)
        if self.record:
            for key, capacity in decision_shapes(self.program, self.function).items():
                shape = (self.n,) if capacity is None else (self.n, capacity)
                self.decisions[key] = np.full(shape, -1, dtype=np.int64)

    # --- statements ---------------------------------------------------------------------------

    def block(self, body: tuple[Stmt, ...], mask: Bools | None) -> None:
        if self.visit is not None:
            self.visit(body, self.n if mask is None else int(mask.sum()))
        for stmt in body:
            self.step(stmt, mask)

    def step(self, stmt: Stmt, mask: Bools | None) -> None:
        self.mask = mask
        match stmt:
            case Comment():
                pass
            case Define(local, value, _):
                # Lanes outside the mask take the value too: they never read it, and it is in range for any operands.
                self.locals[local.name] = self.held(value, local, mask)
            case Assign(local, value):
                new = self.held(value, local, mask)
                self.locals[local.name] = new if mask is None else np.where(mask, new, self.locals[local.name])
            case DefineArray(name, _, size):
                self.arrays[name] = np.zeros((size, self.n), dtype=np.int64)
            case Window(name, _, table, start):
                self.windows[name] = (self.tables[table], self.value(start))
            case AssignElement(array, _, index, value, most):
                at, new = self.value(index), self.value(value)
                if most and self.checked:
                    assert np.all((new <= np.array(most)[at]) | (mask is not None and ~mask)), stmt
                self.store(self.arrays[array], at, new, mask)
            case Loop(counter, count, body):
                for i in range(count):
                    self.locals[counter.name] = i
                    self.block(body, mask)
            case Branch(test, then, other):
                self.branch(self.test(test), then, other, mask)
            case Each():
                self.each(stmt, mask)
            case SetOutput(name, value):
                self.outputs[name] = self.merge(self.value(value), self.outputs[name], mask)
            case SetState(name, value):
                self.state[name] = self.merge(self.value(value), self.state[name], mask)
            case SetStatus(bit):
                self.status = self.merge(self.status | self.bits[bit], self.status, mask)
            case CallFunction():
                self.call(stmt, mask)
            case Record(key, value):
                if self.record:
                    self.keep(key, value, mask)
            case _:
                assert_never(stmt)

    def merge(self, new: Any, old: Ints, mask: Bools | None) -> Ints:
        if mask is None:
            return np.array(np.broadcast_to(new, (self.n,)), dtype=np.int64)
        return np.where(mask, new, old)

    def held(self, value: Expr, local: Local, mask: Bools | None) -> Any:
        result = self.value(value)
        if self.checked:
            seen = result if mask is None else np.broadcast_to(result, (self.n,))[mask]
            if np.size(seen) and (np.min(seen) < local.lo or np.max(seen) > local.hi):
                raise IntervalError(f"{local.name}: {np.min(seen)} .. {np.max(seen)} outside {local.lo} .. {local.hi}")
        return result

    def store(self, array: Ints, index: Any, value: Any, mask: Bools | None) -> None:
        if np.ndim(index) == 0:
            array[index] = value if mask is None else np.where(mask, value, array[index])
            return
        lanes = self.lane if mask is None else self.lane[mask]
        array[index[lanes], lanes] = np.broadcast_to(value, (self.n,))[lanes]

    def branch(self, test: Any, then: tuple[Stmt, ...], other: tuple[Stmt, ...], mask: Bools | None) -> None:
        taken: Bools = np.broadcast_to(np.asarray(test, dtype=np.bool_), (self.n,))
        inside = taken if mask is None else taken & mask
        if inside.all():
            self.block(then, None if mask is None else inside)
        elif inside.any():
            self.block(then, inside)
        if other:
            outside = ~taken if mask is None else ~taken & mask
            if outside.any():
                self.block(other, outside)

    def each(self, stmt: Each, mask: Bools | None) -> None:
        port = next(p for p in self.function.inputs if p.name == stmt.list)
        assert isinstance(port, ListPort)
        count = self.inputs[f"{stmt.list}.count"]
        over = count > port.capacity
        overrun = self.bits[f"OVERRUN_{stmt.list.upper()}"]
        self.status = np.where(over if mask is None else over & mask, self.status | overrun, self.status)
        width = self.inputs[f"{stmt.list}.{port.fields[0].name}"].shape[1]
        used = np.minimum(count, port.capacity)
        if self.n and used.max(initial=0) > width:
            raise ValueError(f"{stmt.list}: a count of {used.max()} with {width} records")
        for j in range(int(used.max(initial=0))):
            self.element = j
            self.locals[stmt.counter.name] = j
            live = used > j
            self.block(stmt.body, live if mask is None else live & mask)
        self.element = None

    def call(self, stmt: CallFunction, mask: Bools | None) -> None:
        callee = self.program.function(stmt.callee)
        ports = [p.name for p in callee.inputs]
        given = {
            p: np.array(np.broadcast_to(self.value(a), (self.n,)), dtype=np.int64)
            for p, a in zip(ports, stmt.arguments, strict=True)
        }
        prefix = f"{stmt.state}." if stmt.state is not None else ""
        state = {k[len(prefix) :]: v for k, v in self.state.items() if k.startswith(prefix)} if prefix else {}
        frame = _Frame(self.program, callee, self.n, given, state, self.record, self.checked, self.visit)
        frame.block(callee.body, mask)
        for output, local in stmt.results:
            self.locals[local.name] = frame.outputs[output]
        for key, value in frame.state.items():
            self.state[f"{prefix}{key}"] = value
        for bit, mine in stmt.held:
            hit = (frame.status & frame.bits[bit]) != 0
            self.status = np.where(hit if mask is None else hit & mask, self.status | self.bits[mine], self.status)
        for key, value in frame.decisions.items():
            self.put(f"{stmt.id}.{key}", value, mask)

    def keep(self, key: str, value: Expr | Test, mask: Bools | None) -> None:
        result = self.test(value) if isinstance(value, Compare | AllOf | AnyOf | NotTest) else self.value(value)
        self.put(key, np.array(np.broadcast_to(result, (self.n,)), dtype=np.int64), mask)

    def put(self, key: str, value: Ints, mask: Bools | None) -> None:
        if self.element is None:
            self.decisions[key] = self.merge(value, self.decisions[key], mask)
        else:
            column = self.decisions[key][:, self.element]
            self.decisions[key][:, self.element] = self.merge(value, column, mask)

    # --- expressions --------------------------------------------------------------------------

    def inside(self, where: Any) -> Any:
        """An index of a table; 0 for lanes outside the mask, where it may be anything and what is read is not used."""
        return where if self.mask is None or np.ndim(where) == 0 else np.where(self.mask, where, 0)

    def value(self, expr: Expr) -> Any:
        match expr:
            case Const(value):
                return value
            case Local(name):
                return self.locals[name]
            case Element(array, _, index, _, _, table):
                where = self.value(index)
                if array in self.windows:
                    of, start = self.windows[array]
                    return of[self.inside(start + where)]
                if table:
                    return self.tables[array][self.inside(where)]
                return self.arrays[array][where] if np.ndim(where) == 0 else self.arrays[array][where, self.lane]
            case ReadPort(name):
                return self.inputs[name]
            case ReadField(list_, name):
                assert self.element is not None
                return self.inputs[f"{list_}.{name}"][:, self.element]
            case ReadState(name):
                return self.state[name]
            case Binary(op, left, right):
                return _ARITHMETIC[op](self.value(left), self.value(right))
            case Least(left, right):
                return np.minimum(self.value(left), self.value(right))
            case Greatest(left, right):
                return np.maximum(self.value(left), self.value(right))
            case Above(left, right):
                return np.maximum(np.subtract(self.value(left), self.value(right)), 0)
            case Select(test, then, other):
                return np.where(self.test(test), self.value(then), self.value(other))
            case MulHigh(left, right):
                return mul_high(self.value(left), self.value(right))
            case Quotient(num, den):
                return quotient(self.value(num), self.value(den))
            case _:
                assert_never(expr)

    def test(self, test: Test) -> Any:
        match test:
            case Compare(op, left, right):
                return _COMPARISON[op](self.value(left), self.value(right))
            case AllOf(operands):
                return np.logical_and.reduce(np.broadcast_arrays(*(self.test(t) for t in operands)))
            case AnyOf(operands):
                return np.logical_or.reduce(np.broadcast_arrays(*(self.test(t) for t in operands)))
            case NotTest(operand):
                return np.logical_not(self.test(operand))
            case _:
                assert_never(test)


def mul_high(left: Any, right: Any) -> Any:
    """``floor(left * right / 2**16)``; operands below 2**32 and at most 2**16."""
    return np.right_shift(np.multiply(left, right), 16)


def quotient(num: Any, den: Any) -> Any:
    """``floor(num * 2**16 / den)`` where ``num < den < 2**31``, else 65536."""
    small = np.less(num, den)
    # Lanes outside a mask may hold anything, a divisor of 0 and less among it.
    safe = np.maximum(np.where(small, den, 1), 1)
    return np.where(small, np.left_shift(np.where(small, num, 0), 16) // safe, 65536)
