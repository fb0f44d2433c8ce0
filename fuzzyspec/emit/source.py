"""The source file as data for its template."""

from __future__ import annotations

from dataclasses import dataclass

from fuzzyspec.emit.cprinter import literal
from fuzzyspec.emit.ctypes import signed
from fuzzyspec.emit.dividers import Divider, divider
from fuzzyspec.emit.header import declaration, holds, prototype
from fuzzyspec.emit.layout import INDENT, code
from fuzzyspec.emit.names import Names
from fuzzyspec.emit.statements import Body, print_body
from fuzzyspec.emit.tables import Printed, Reader, printed, readers
from fuzzyspec.fixed.division import reciprocals
from fuzzyspec.fixed.program import Element, Function, MulHigh, Program, Window
from fuzzyspec.fixed.prune import expressions, nodes, statements


@dataclass(frozen=True, slots=True)
class Init:
    """The function that sets up a state."""

    name: str
    state_t: str
    lines: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Defined:
    """One function with its tables; ``inits`` is empty or holds the one that belongs to its state."""

    tables: tuple[Printed, ...]
    inits: tuple[Init, ...]
    prototype: tuple[str, ...]
    sets_status: bool
    unused: tuple[str, ...]
    lines: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SourceFile:
    """What the source template lays out."""

    functions: tuple[Defined, ...]
    readers: tuple[Reader, ...]
    uses_mul_high: bool
    quotients: tuple[Divider, ...]
    reciprocal_tables: tuple[Printed, ...]


def source_file(program: Program, names: Names) -> SourceFile:
    """Every function, callees first, and the kernels and macros that they use."""
    bodies = [(f, print_body(program, f, names)) for f in program.functions]
    used = [node for _, body in bodies for e in expressions(body.pruned) for node in nodes(e)]
    divides_by_table = any(kernel.by == "reciprocal" for kernel in names.dividers)
    looked_up = (printed(names.reciprocals, "uint8", reciprocals()),) if divides_by_table else ()
    return SourceFile(
        functions=tuple(_defined(program, f, names, body) for f, body in bodies),
        readers=readers(
            names.macro,
            [n.ctype for n in used if isinstance(n, Element) and n.table] + ["uint8" for t in looked_up],
        ),
        uses_mul_high=any(isinstance(n, MulHigh) for n in used),
        quotients=tuple(divider(kernel, name) for kernel, name in names.dividers.items()),
        reciprocal_tables=looked_up,
    )


def _defined(program: Program, function: Function, names: Names, body: Body) -> Defined:
    own = names.functions[function.name]
    read = {n.array for e in expressions(body.pruned) for n in nodes(e) if isinstance(n, Element) and n.table}
    read |= {s.table for s in statements(body.pruned) if isinstance(s, Window)}
    unused = []
    if not body.reads_input:
        unused.append(f"{INDENT}(void)in;")
    if holds(function) and not body.uses_state:
        unused.append(f"{INDENT}(void)state;")
    return Defined(
        tables=tuple(printed(own.tables[t.name], t.ctype, t.values) for t in function.tables if t.name in read),
        inits=(_init(program, function, names),) if holds(function) else (),
        prototype=tuple(declaration(prototype(function, names))),
        sets_status=body.sets_status,
        unused=tuple(unused),
        lines=body.lines,
    )


def _init(program: Program, function: Function, names: Names) -> Init:
    own = names.functions[function.name]
    lines: list[str] = []
    for port in function.state:
        lines += code(f"state->{own.state[port.name]} = {literal(port.initial, signed(port.ctype)).text};", 1)
    for name, callee in function.nested:
        lines += code(f"{names.functions[callee].init}(&state->{own.state[name]});", 1)
    return Init(own.init, own.state_t, tuple(lines))
