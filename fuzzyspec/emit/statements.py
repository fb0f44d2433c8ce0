"""Statements of the program as lines of C."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import assert_never

from fuzzyspec.emit.cprinter import Level, Spelling, Text, condition, converted, element, literal, stored, subscript
from fuzzyspec.emit.ctypes import count_ctype, signed, spelled
from fuzzyspec.emit.layout import INDENT, code, comment
from fuzzyspec.emit.names import FunctionNames, Names, Scope, identifier, singular
from fuzzyspec.fixed.build import LIMITS
from fuzzyspec.fixed.program import (
    Assign,
    AssignElement,
    Branch,
    CallFunction,
    Comment,
    Define,
    DefineArray,
    Each,
    Function,
    ListPort,
    Local,
    Loop,
    Program,
    ReadPort,
    ReadState,
    Record,
    SetOutput,
    SetState,
    SetStatus,
    Stmt,
    Window,
)
from fuzzyspec.fixed.prune import expressions, nodes, prune, statements


@dataclass(frozen=True)
class Body:
    """What stands between a function's braces (as statements and as lines), and what of its parameters it uses."""

    pruned: tuple[Stmt, ...]
    lines: tuple[str, ...]
    sets_status: bool
    reads_input: bool
    uses_state: bool


@dataclass(frozen=True)
class _Context:
    program: Program
    function: Function
    names: Names
    own: FunctionNames
    spelling: Spelling
    calls: Mapping[int, str]
    """The stem of the locals of a call, by the statement's identity."""
    lists: Mapping[str, ListPort]
    elements: Mapping[str, str]
    """The pointer to the current element, by list."""
    counts: Mapping[int, str]
    """The local that holds how many elements are used, by the statement's identity."""


def print_body(program: Program, function: Function, names: Names) -> Body:
    """The function's statements, pruned and indented by one level; the status is the local ``status``."""
    body = prune(function.body)
    _refuse_shadowing(body, frozenset())
    context = _context(program, function, names, body)
    every = list(statements(body))
    reads = [n for e in expressions(body) for n in nodes(e)]
    return Body(
        pruned=body,
        lines=tuple(_block(body, 1, context)),
        sets_status=any(isinstance(s, SetStatus) or (isinstance(s, CallFunction) and s.held) for s in every)
        or any(isinstance(s, Each) and _can_overrun(context.lists[s.list]) for s in every),
        reads_input=any(isinstance(n, ReadPort) for n in reads) or any(isinstance(s, Each) for s in every),
        uses_state=any(isinstance(n, ReadState) for n in reads)
        or any(isinstance(s, SetState) or (isinstance(s, CallFunction) and s.state is not None) for s in every),
    )


@dataclass(frozen=True, slots=True)
class Ranges:
    """The least and the greatest value of each local of a function, by its name in the C; and of an array's elements,
    of each assignment in the order in which they stand, for all of them together or by index."""

    locals: Mapping[str, tuple[int, int]]
    elements: Mapping[str, tuple[tuple[tuple[int, int], ...], ...]]


def ranges_of(program: Program, function: Function, names: Names) -> Ranges:
    """What the compiler has derived of a function's locals."""
    body = prune(function.body)
    spelled_as = _context(program, function, names, body).spelling.locals
    locals_: dict[str, tuple[int, int]] = {}
    elements: dict[str, tuple[tuple[tuple[int, int], ...], ...]] = {}
    for statement in statements(body):
        match statement:
            case Define(local) | Assign(local):
                name = spelled_as[local.name]
                lo, hi = locals_.get(name, (local.lo, local.hi))
                locals_[name] = min(lo, local.lo), max(hi, local.hi)
            case AssignElement():
                name = spelled_as[statement.array]
                of = tuple((statement.value.lo, hi) for hi in statement.most or (statement.value.hi,))
                elements[name] = (*elements.get(name, ()), of)
            case _:
                pass
    return Ranges(locals_, elements)


def _context(program: Program, function: Function, names: Names, body: tuple[Stmt, ...]) -> _Context:
    own = names.functions[function.name]
    taken = Scope({"in", "out", "state", "status"} | names.globals | names.macros, capitals=False)
    lists = {p.name: p for p in function.inputs if isinstance(p, ListPort)}
    locals_: dict[str, str] = {}
    for name in _local_names(body):
        if name not in locals_:
            locals_[name] = taken.claim(name)
    elements = {name: taken.claim(singular(name)) for name in lists}
    counts: dict[int, str] = {}
    calls: dict[int, str] = {}
    for statement in statements(body):
        if isinstance(statement, Each):
            counts[id(statement)] = taken.claim(f"{statement.list}_used")
        elif isinstance(statement, CallFunction):
            calls[id(statement)] = _call_stem(statement.id, taken)
    spelling = Spelling(
        locals=locals_,
        tables=own.tables,
        ports={signal: f"in->{field}" for signal, field in own.inputs.items()},
        state={signal: f"state->{field}" for signal, field in own.state.items()},
        fields={
            (name, signal): f"{elements[name]}->{field}"
            for name in lists
            for signal, field in own.record_fields[name].items()
        },
        read=f"{names.macro}_READ",
        mul_high=names.mul_high,
        quotients=names.quotients,
        narrow=program.narrow,
    )
    return _Context(program, function, names, own, spelling, calls, lists, elements, counts)


def _call_stem(call: str, taken: Scope) -> str:
    """``drive``, such that ``drive_in``, ``drive_out`` and ``drive_status`` are free; else ``drive_2``."""
    wanted = identifier(call)
    stem, number = wanted, 1
    while not all(taken.free(f"{stem}_{part}") for part in ("in", "out", "status")):
        number += 1
        stem = f"{wanted}_{number}"
    for part in ("in", "out", "status"):
        taken.claim(f"{stem}_{part}")
    return stem


def _local_names(body: tuple[Stmt, ...]) -> Iterator[str]:
    for statement in statements(body):
        match statement:
            case Define():
                yield statement.local.name
            case DefineArray() | Window():
                yield statement.name
            case Loop() | Each():
                yield statement.counter.name
            case CallFunction():
                yield from (local.name for _, local in statement.results)
            case _:
                pass


def _refuse_shadowing(body: tuple[Stmt, ...], outer: frozenset[str]) -> None:
    """A program has one value for a name; C would have two."""
    here = set(outer)
    for statement in body:
        inner: tuple[tuple[Stmt, ...], ...] = ()
        match statement:
            case Loop() | Each():
                declared, inner = [statement.counter.name], (statement.body,)
            case Branch():
                declared, inner = [], (statement.then, statement.other)
            case _:
                declared = list(_local_names((statement,)))
        for name in declared:
            if name in here:
                raise AssertionError(f"local {name!r} is defined twice")
        for block in inner:
            _refuse_shadowing(block, frozenset(here | set(declared)))
        if not inner:
            here.update(declared)


def _block(body: tuple[Stmt, ...], depth: int, context: _Context) -> Iterator[str]:
    for index, statement in enumerate(body):
        after_block = depth == 1 and index > 0 and isinstance(body[index - 1], Branch | Loop | Each)
        if (after_block and not isinstance(statement, Branch | Loop | Each)) or (
            index > 0 and isinstance(statement, Comment)
        ):
            yield ""
        yield from _statement(statement, depth, context)


def _statement(statement: Stmt, depth: int, context: _Context) -> Iterator[str]:
    names = context.spelling
    match statement:
        case Comment():
            yield from comment(statement.text, depth)
        case Define():
            const = "const " if statement.constant else ""
            declared = f"{const}{spelled(statement.local.ctype)} {names.locals[statement.local.name]}"
            yield from code(f"{declared} = {stored(statement.value, statement.local.ctype, names)};", depth)
        case DefineArray():
            declared = f"{spelled(statement.ctype)} {names.locals[statement.name]}[{statement.size}]"
            yield from code(f"{declared};", depth)
        case Window():
            pointer = f"const {spelled(statement.ctype)} *const {names.locals[statement.name]}"
            yield from code(
                f"{pointer} = &{names.tables[statement.table]}[{subscript(statement.start, names)}];", depth
            )
        case Assign():
            target = names.locals[statement.local.name]
            yield from code(f"{target} = {stored(statement.value, statement.local.ctype, names)};", depth)
        case AssignElement():
            target = element(statement.array, statement.index, names)
            yield from code(f"{target} = {stored(statement.value, statement.ctype, names)};", depth)
        case Loop():
            count = literal(statement.count, signed(statement.counter.ctype)).text
            yield from _loop(statement.counter, count, depth, context)
            yield from _block(statement.body, depth + 1, context)
            yield f"{INDENT * depth}}}"
        case Each():
            yield from _each(statement, depth, context)
        case Branch():
            yield from _branch(statement, depth, context)
        case SetOutput():
            ctype = next(p.ctype for p in context.function.outputs if p.name == statement.name)
            target = f"out->{context.own.outputs[statement.name]}"
            yield from code(f"{target} = {stored(statement.value, ctype, names)};", depth)
        case SetState():
            ctype = next(p.ctype for p in context.function.state if p.name == statement.name)
            yield from code(f"{names.state[statement.name]} = {stored(statement.value, ctype, names)};", depth)
        case SetStatus():
            yield from _set_status(context.own.bits[statement.bit], depth, context)
        case CallFunction():
            yield from _call(statement, depth, context)
        case Record():
            raise AssertionError("records are pruned before printing")
        case _:
            assert_never(statement)


def _set_status(bit: str, depth: int, context: _Context) -> list[str]:
    return code(f"status = ({context.names.status_t})(status | {bit});", depth)


def _loop(counter: Local, count: str, depth: int, context: _Context) -> list[str]:
    name = context.spelling.locals[counter.name]
    first = literal(0, signed(counter.ctype)).text
    return code(f"for ({spelled(counter.ctype)} {name} = {first}; {name} < {count}; ++{name}) {{", depth)


def _can_overrun(port: ListPort) -> bool:
    """A list of 255 has a ``uint8_t`` for a count and cannot be overrun."""
    return port.capacity < LIMITS[count_ctype(port.capacity)][1]


def _each(statement: Each, depth: int, context: _Context) -> Iterator[str]:
    port = context.lists[statement.list]
    own, pad = context.own, INDENT * depth
    given, used = f"in->{own.counts[port.name]}", context.counts[id(statement)]
    capacity, ctype = own.limits[port.name], spelled(count_ctype(port.capacity))
    if _can_overrun(port):
        if statement.body:
            yield from code(f"{ctype} {used} = {given};", depth)
        yield f"{pad}if ({used if statement.body else given} > {capacity}) {{"
        if statement.body:
            yield from code(f"{used} = {capacity};", depth + 1)
        yield from _set_status(own.bits[f"OVERRUN_{port.name.upper()}"], depth + 1, context)
        yield f"{pad}}}"
    elif statement.body:
        yield from code(f"const {ctype} {used} = {given};", depth)
    if statement.body:
        pointer, counter = context.elements[port.name], context.spelling.locals[statement.counter.name]
        yield from _loop(statement.counter, used, depth, context)
        yield from code(
            f"const {own.records[port.name]} *const {pointer} = &in->{own.inputs[port.name]}[{counter}];", depth + 1
        )
        yield ""
        yield from _block(statement.body, depth + 1, context)
        yield f"{pad}}}"


def _branch(statement: Branch, depth: int, context: _Context) -> Iterator[str]:
    pad = INDENT * depth
    head = "if"
    while True:
        yield from _headed(head, statement, depth, context)
        yield from _block(statement.then, depth + 1, context)
        match statement.other:
            case ():
                if head != "if":
                    # MISRA C:2012 rule 15.7: a chain of else-if ends in else.
                    yield f"{pad}}} else {{"
                    yield f"{pad}{INDENT}/* Nothing to do. */"
                break
            case (Branch() as chained,):
                head, statement = "} else if", chained
            case _:
                yield f"{pad}}} else {{"
                yield from _block(statement.other, depth + 1, context)
                break
    yield f"{pad}}}"


def _headed(head: str, statement: Branch, depth: int, context: _Context) -> list[str]:
    return code(f"{head} ({condition(statement.test, context.spelling)}) {{", depth)


def _call(statement: CallFunction, depth: int, context: _Context) -> Iterator[str]:
    callee = context.program.function(statement.callee)
    called = context.names.functions[statement.callee]
    stem = context.calls[id(statement)]
    given, got, told = f"{stem}_in", f"{stem}_out", f"{stem}_status"
    yield from code(f"{called.input_t} {given};", depth)
    yield from code(f"{called.output_t} {got};", depth)
    for port, argument in zip(callee.inputs, statement.arguments, strict=True):
        if isinstance(port, ListPort):
            raise AssertionError("a called function takes scalars")
        value = stored(argument, port.ctype, context.spelling)
        yield from code(f"{given}.{called.inputs[port.name]} = {value};", depth)
    state = f"&{context.spelling.state[statement.state]}, " if statement.state is not None else ""
    call = f"{called.function}({state}&{given}, &{got});"
    if statement.held:
        yield from code(f"const {context.names.status_t} {told} = {call}", depth)
        for theirs, ours in statement.held:
            yield from code(f"if (({told} & {called.bits[theirs]}) != 0U) {{", depth)
            yield from _set_status(context.own.bits[ours], depth + 1, context)
            yield f"{INDENT * depth}}}"
    else:
        yield from code(f"(void){call}", depth)
    for output, local in statement.results:
        ctype = next(p.ctype for p in callee.outputs if p.name == output)
        value = converted(Text(f"{got}.{called.outputs[output]}", Level.ATOM, ctype), local.ctype)
        yield from code(f"const {spelled(local.ctype)} {context.spelling.locals[local.name]} = {value};", depth)
