"""The header as data for its template: what a user of the generated functions must know."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from fuzzyspec.emit.conversion import conversion
from fuzzyspec.emit.ctypes import count_ctype, signed, spelled
from fuzzyspec.emit.describe import certificate_lines, signal
from fuzzyspec.emit.layout import COLUMNS, INDENT, block_comment, comment
from fuzzyspec.emit.names import FunctionNames, Names, Scope
from fuzzyspec.fixed.certificate import Certificate
from fuzzyspec.fixed.program import Function, ListPort, Port, Program


@dataclass(frozen=True, slots=True)
class Struct:
    """A ``typedef struct``; ``members`` are laid out, comments included."""

    name: str
    title: tuple[str, ...]
    members: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Prototype:
    """A declared function under its comment."""

    title: tuple[str, ...]
    text: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Section:
    """All that the header says of one function."""

    title: tuple[str, ...]
    macros: tuple[tuple[str, ...], ...]
    structs: tuple[Struct, ...]
    prototypes: tuple[Prototype, ...]


@dataclass(frozen=True)
class Told:
    """What is known of one function besides its program.

    ``reachable`` and ``acting`` are by output, ``budget`` is a limit each.
    """

    certificate: Certificate | None
    reachable: Mapping[str, str]
    acting: Mapping[str, str]
    budget: tuple[str, ...] = ()


def status_base(program: Program) -> str:
    """The type under ``<prefix>_status_t``."""
    return "uint32_t" if any(len(f.status) > 16 for f in program.functions) else "uint16_t"


def sections(program: Program, names: Names, told: Mapping[str, Told]) -> tuple[Section, ...]:
    """One section a function, callees before callers."""
    macros = Scope(names.macros)
    return tuple(_section(program, f, names, told[f.name], macros) for f in program.functions)


def prototype(function: Function, names: Names) -> str:
    """The function's declarator, without a semicolon."""
    own = names.functions[function.name]
    state = f"{own.state_t} *state, " if holds(function) else ""
    return f"{names.status_t} {own.function}({state}const {own.input_t} *in, {own.output_t} *out)"


def holds(function: Function) -> bool:
    """Whether a call needs a state."""
    return bool(function.state or function.nested)


def _section(program: Program, function: Function, names: Names, told: Told, macros: Scope) -> Section:
    own = names.functions[function.name]
    title = f"{function.kind.capitalize()} {function.name}."
    groups = [
        _bits(function, own),
        _limits(function, own),
        _acting(function, own, macros),
        _conversions(function, own, macros),
    ]
    return Section(
        title=tuple(comment(title)),
        macros=tuple(tuple(g) for g in groups if g),
        structs=tuple(_structs(program, function, names, told)),
        prototypes=tuple(_prototypes(function, names, told)),
    )


def _aligned(pairs: list[tuple[str, str]]) -> list[str]:
    """Left sides in one column, what follows in the next."""
    width = max(len(left) for left, _ in pairs)
    return [f"{left.ljust(width)} {right}".rstrip() for left, right in pairs]


def _commented(rows: list[tuple[str, str]]) -> list[str]:
    """Code with a comment behind it, or above it where the line would be too long."""
    width = max(len(left) for left, _ in rows)
    out: list[str] = []
    for left, note in rows:
        beside = f"{left.ljust(width)} {comment(note)[0]}" if note else left
        if len(beside) <= COLUMNS and len(comment(note)) == 1:
            out.append(beside)
        else:
            out += [*comment(note, (len(left) - len(left.lstrip())) // len(INDENT)), left]
    return out


def _bits(function: Function, own: FunctionNames) -> list[str]:
    if not function.status:
        return []
    digits = 4 if len(function.status) <= 16 else 8
    left = _aligned([(f"#define {own.bits[b.name]}", f"0x{1 << i:0{digits}X}U") for i, b in enumerate(function.status)])
    return _commented(list(zip(left, (b.meaning for b in function.status), strict=True)))


def _limits(function: Function, own: FunctionNames) -> list[str]:
    pairs: list[tuple[str, str]] = []
    seen: set[str] = set()
    for port in (*function.inputs, *function.outputs):
        if isinstance(port, ListPort):
            pairs.append((f"#define {own.limits[port.name]}", f"{port.capacity}U"))
            for field in port.fields:
                pairs += _extremes(own.limits[f"{port.name}.{field.name}"], field)
        elif port.variable is not None and port.name not in seen:
            pairs += _extremes(own.limits[port.name], port)
            seen.add(port.name)
    return ["/* Legal raws; what lies outside saturates. */", *_aligned(pairs)] if pairs else []


def _extremes(stem: str, port: Port) -> list[tuple[str, str]]:
    return [(f"#define {stem}_{end}", _raw(value, port)) for end, value in (("MIN", port.lo), ("MAX", port.hi))]


def _raw(value: int, port: Port) -> str:
    if not signed(port.ctype):
        return f"{value}U"
    # -32768 would be a long where int has 16 bits.
    return "INT16_MIN" if value == -(2**15) else f"({value})" if value < 0 else str(value)


def _acting(function: Function, own: FunctionNames, macros: Scope) -> list[str]:
    if not function.behaviors:
        return []
    codes = [("NONE", 0), *((b.name.upper(), b.code) for b in function.behaviors)]
    pairs = [(f"#define {macros.claim(f'{own.macro}_ACTING_{name}')}", f"{code}U") for name, code in codes]
    return ["/* Which behavior acts. */", *_aligned(pairs)]


def _conversions(function: Function, own: FunctionNames, macros: Scope) -> list[str]:
    lines: list[str] = []
    seen: set[str] = set()
    for name, port in _measured(function):
        found = conversion(port.variable, port.ctype) if port.variable is not None and name not in seen else None
        if found is not None:
            seen.add(name)
            stem = own.limits[name]
            lines += comment(f"{name}: x in {found.words}, {found.lo} .. {found.hi}")
            lines += _macro(f"{macros.claim(f'{stem}_FROM_{found.name}')}(x)", found.from_body)
            lines += _macro(f"{macros.claim(f'{stem}_TO_{found.name}')}(raw)", found.to_body)
    head = "/* Conversions on integers, rounded to nearest; x may be evaluated more than once. */"
    return [head, *lines] if lines else []


def _macro(name: str, body: str) -> list[str]:
    line = f"#define {name} {body}"
    return [line] if len(line) <= COLUMNS else [f"#define {name} \\", f"{INDENT}{body}"]


def _measured(function: Function) -> list[tuple[str, Port]]:
    found: list[tuple[str, Port]] = []
    for port in (*function.inputs, *function.outputs):
        if isinstance(port, ListPort):
            found += [(f"{port.name}.{f.name}", f) for f in port.fields]
        else:
            found.append((port.name, port))
    return found


def _structs(program: Program, function: Function, names: Names, told: Told) -> list[Struct]:
    own = names.functions[function.name]
    found: list[Struct] = []
    rows: list[tuple[str, str]] = []
    for port in function.inputs:
        if isinstance(port, ListPort):
            record, members = own.records[port.name], own.record_fields[port.name]
            fields = [(f"{INDENT}{spelled(f.ctype)} {members[f.name]};", signal(f)) for f in port.fields]
            found.append(Struct(record, tuple(comment(f"An element of {port.name}.")), tuple(_commented(fields))))
            rows.append(
                (f"{INDENT}const {record} *{own.inputs[port.name]};", f"at least min(count, {port.capacity}) elements")
            )
            count = spelled(count_ctype(port.capacity))
            rows.append((f"{INDENT}{count} {own.counts[port.name]};", f"0 .. {port.capacity} are used"))
        else:
            rows.append((f"{INDENT}{spelled(port.ctype)} {own.inputs[port.name]};", signal(port)))
    found.append(Struct(own.input_t, (), tuple(_commented(rows))))
    outputs = [(f"{INDENT}{spelled(p.ctype)} {own.outputs[p.name]};", _output(p, told)) for p in function.outputs]
    found.append(Struct(own.output_t, (), tuple(_commented(outputs))))
    if holds(function):
        state = [(f"{INDENT}{spelled(s.ctype)} {own.state[s.name]};", f"held: {signal(s)}") for s in function.state]
        for name, callee in function.nested:
            state.append(
                (f"{INDENT}{names.functions[callee].state_t} {own.state[name]};", f"of {program.function(callee).name}")
            )
        title = comment(f"What {own.function} remembers; {own.init} sets it up.")
        found.append(Struct(own.state_t, tuple(title), tuple(_commented(state))))
    return found


def _output(port: Port, told: Told) -> str:
    if port.variable is None:
        return told.acting.get(port.name, "code of the acting behavior, 0 where nothing fires")
    return signal(port)


def _prototypes(function: Function, names: Names, told: Told) -> list[Prototype]:
    own = names.functions[function.name]
    found: list[Prototype] = []
    if holds(function):
        title = comment("Call once before the first call that takes this state.")
        found.append(Prototype(tuple(title), (f"void {own.init}({own.state_t} *state);",)))
    ports = function.outputs
    lines = [f"One {'step of system' if function.kind == 'system' else 'call of controller'} {function.name}."]
    lines += certificate_lines(told.certificate, ports, told.reachable)
    if told.budget:
        lines.append(f"budget: {'; '.join(told.budget)}")
    found.append(Prototype(tuple(block_comment(lines)), tuple(declaration(prototype(function, names) + ";"))))
    return found


def declaration(text: str) -> list[str]:
    """A declarator, its parameters on a line of their own where it is too long."""
    if len(text) <= COLUMNS:
        return [text]
    head, rest = text.split("(", 1)
    parameters = rest.split(", ")
    pad = " " * (len(head) + 1)
    return [f"{head}({parameters[0]},", *(f"{pad}{p}," for p in parameters[1:-1]), f"{pad}{parameters[-1]}"]
