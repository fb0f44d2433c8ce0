"""The self-test as data for its template: golden vectors in tables, and a function that walks through them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from fuzzyspec.emit.cprinter import literal, reader_name
from fuzzyspec.emit.ctypes import count_ctype, signed
from fuzzyspec.emit.header import holds
from fuzzyspec.emit.layout import code
from fuzzyspec.emit.names import FunctionNames, Names, Scope
from fuzzyspec.emit.tables import Printed, Reader, printed, readers
from fuzzyspec.emit.vectors import COUNT, Column, Vectors, golden, states
from fuzzyspec.fixed.build import LIMITS
from fuzzyspec.fixed.program import CType, Function, ListPort, Program
from fuzzyspec.model.system import Module


@dataclass(frozen=True, slots=True)
class Check:
    """A member of the answer and what it must be."""

    got: str
    want: str


@dataclass(frozen=True, slots=True)
class Filled:
    """A local list that a vector fills; ``moves`` set its element ``j``."""

    name: str
    record: str
    member: str
    size: int
    moves: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, slots=True)
class Tested:
    """One function's vectors.

    ``states`` is empty or holds the type of its state, ``inits`` the function that sets it up, as ``begins`` says.
    """

    name: str
    function: str
    input_t: str
    output_t: str
    states: tuple[str, ...]
    inits: tuple[str, ...]
    begins: tuple[Check, ...]
    tables: tuple[Printed, ...]
    moves: tuple[tuple[str, ...], ...]
    lists: tuple[Filled, ...]
    status: str
    checks: tuple[Check, ...]
    count: int
    first: int


@dataclass(frozen=True, slots=True)
class SelftestFile:
    """What the self-test template lays out."""

    tests: tuple[Tested, ...]
    readers: tuple[Reader, ...]


class _Tables:
    """Collects the tables of one function and says how they are read."""

    def __init__(self, stem: str, names: Names, scope: Scope) -> None:
        self._stem, self._read, self._scope = stem, f"{names.macro}_READ", scope
        self.printed: list[Printed] = []
        self.ctypes: set[CType] = set()

    def read(self, kind: str, key: str, ctype: CType, values: Column, index: str = "i") -> str:
        """Add a table; the expression that reads it."""
        name = self._scope.claim(f"{self._stem}_{kind}_{key}")
        self.printed.append(printed(name, ctype, values))
        self.ctypes.add(ctype)
        return f"{reader_name(self._read, ctype)}({name}, {index})"


def selftest_file(module: Module, program: Program, names: Names) -> SelftestFile:
    """Vectors of every function, in the program's order."""
    tests: list[Tested] = []
    ctypes: set[CType] = set()
    scope = Scope(names.globals | names.macros)
    for function in program.functions:
        stem = names.functions[function.name].function
        tables = _Tables(stem, names, scope)
        tests.append(
            _tested(program, function, names, golden(module, program, function), tables, 1 + COUNT * len(tests), scope)
        )
        ctypes |= tables.ctypes
    return SelftestFile(tuple(tests), readers(names.macro, ctypes))


def _tested(
    program: Program, function: Function, names: Names, vectors: Vectors, tables: _Tables, first: int, scope: Scope
) -> Tested:
    own = names.functions[function.name]
    moves: list[tuple[str, ...]] = []
    lists: list[Filled] = []
    used = {"in", "out", "state", "status", "differs", "i", "j", "at"}
    taken = Scope(used | names.globals | names.macros, capitals=False)
    for port in function.inputs:
        if isinstance(port, ListPort):
            key = f"{port.name}.count"
            count = tables.read("in", key, count_ctype(port.capacity), vectors.inputs[key])
            moves.append(tuple(code(f"in.{own.counts[port.name]} = {count};", 1)))
            lists.append(_filled(port, own.records[port.name], own, vectors, tables, taken.claim(port.name)))
        else:
            value = tables.read("in", port.name, port.ctype, vectors.inputs[port.name])
            moves.append(tuple(code(f"in.{own.inputs[port.name]} = {value};", 1)))
    members = dict(_state_members(program, function, names))
    checks = [
        Check(f"out.{own.outputs[p.name]}", tables.read("out", p.name, p.ctype, vectors.outputs[p.name]))
        for p in function.outputs
    ]
    begins: list[Check] = []
    for key, state in states(program, function):
        begins.append(Check(f"state.{members[key]}", literal(state.initial, signed(state.ctype)).text))
        before = tables.read("before", key, state.ctype, vectors.state[key])
        moves.append(tuple(code(f"state.{members[key]} = {before};", 1)))
        after = tables.read("after", key, state.ctype, vectors.after[key])
        checks.append(Check(f"state.{members[key]}", after))
    word: CType = "uint32" if max(vectors.status) > LIMITS["uint16"][1] else "uint16"
    status = tables.read("expected", "status", word, vectors.status)
    return Tested(
        name=scope.claim(f"{own.function}_differs"),
        function=own.function,
        input_t=own.input_t,
        output_t=own.output_t,
        states=(own.state_t,) if holds(function) else (),
        inits=(own.init,) if holds(function) else (),
        begins=tuple(begins),
        tables=tuple(tables.printed),
        moves=tuple(moves),
        lists=tuple(lists),
        status=status,
        checks=tuple(checks),
        count=COUNT,
        first=first,
    )


def _filled(port: ListPort, record: str, own: FunctionNames, vectors: Vectors, tables: _Tables, name: str) -> Filled:
    moves = []
    for field in port.fields:
        key = f"{port.name}.{field.name}"
        value = tables.read("in", key, field.ctype, vectors.inputs[key], "at")
        moves.append(tuple(code(f"{name}[j].{own.record_fields[port.name][field.name]} = {value};", 2)))
    return Filled(name, record, own.inputs[port.name], vectors.lengths[port.name], tuple(moves))


def _state_members(program: Program, function: Function, names: Names) -> Iterator[tuple[str, str]]:
    own: Mapping[str, str] = names.functions[function.name].state
    for port in function.state:
        yield port.name, own[port.name]
    for name, callee in function.nested:
        for key, member in _state_members(program, program.function(callee), names):
            yield f"{name}.{key}", f"{own[name]}.{member}"
