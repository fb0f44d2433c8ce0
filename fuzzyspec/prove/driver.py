"""The C that hands every function all that a caller may hand it: what is proved, is proved of this program.

Inputs, counts and states are read from volatiles, so that the analyser takes them for any value of their C type. An
array of a list holds as many records as its count says, and no more than its bound.

Where that is too much, states are kept to what the module says they hold: each call begins with any such state, and has
to leave one behind, as the function that sets a state up has to.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from fuzzyspec.emit.names import FunctionNames, Names, name_module
from fuzzyspec.fixed.program import Program
from fuzzyspec.native.layout import Layout, ListSlot, count_ctype, layout_of, states_of

SEPARATE = 8
"""A list whose bound is at most this large is tried with an array for each count; a longer one at its ends."""


@dataclass(frozen=True, slots=True)
class Room:
    """An array of ``records`` for a list, and the counts that it goes with: ``least`` and above, or just that one."""

    records: int
    least: int
    beyond: bool


def print_driver(program: Program, kept: bool = False) -> str:
    """A translation unit with a ``main`` that calls every function with everything; ``kept``: with states in range."""
    names = name_module(program)
    layouts = [layout_of(program, f, names) for f in program.functions]
    lines = [f'#include "{names.header}"', ""]
    lines += [f"extern {t}_t volatile any_{t};" for t in ("uint8", "int8", "uint16", "int16", "uint32", "int32")]
    drives: list[str] = []
    for function, layout in zip(program.functions, layouts, strict=True):
        held = states_of(program, function) if kept else {}
        within = {s.member: (held[s.key].lo, held[s.key].hi) for s in layout.state if s.key in held}
        for rooms in _rooms(layout):
            drives.append(f"drive_{len(drives)}")
            lines += ["", *_drive(drives[-1], layout, names, rooms, within)]
        if layout.state:
            drives.append(f"drive_{len(drives)}")
            lines += ["", *_init(drives[-1], layout, names.functions[layout.function], within)]
    lines += ["", "int main(void)", "{", *(f"    {d}();" for d in drives), "    return 0;", "}"]
    return "\n".join(lines) + "\n"


def _rooms(layout: Layout) -> Iterator[tuple[Room, ...]]:
    """The arrays of each list for one drive; the longest first, with which the other lists stay when one varies."""
    full = tuple(Room(listed.capacity, listed.capacity, True) for listed in layout.lists)
    yield full
    for at, listed in enumerate(layout.lists):
        for size in _sizes(listed):
            yield (*full[:at], Room(size, size, False), *full[at + 1 :])


def _sizes(listed: ListSlot) -> list[int]:
    if listed.capacity <= SEPARATE:
        return list(range(listed.capacity + 1))
    return [0, 1, listed.capacity - 1, listed.capacity]


def _drive(
    name: str, layout: Layout, names: Names, rooms: tuple[Room, ...], within: Mapping[str, tuple[int, int]]
) -> Iterator[str]:
    c = names.functions[layout.function]
    yield f"static void {name}(void)"
    yield "{"
    yield f"    {c.input_t} in;"
    yield f"    {c.output_t} out;"
    if layout.state:
        yield f"    {c.state_t} state;"
    for slot in layout.inputs:
        if slot.list is None:
            yield f"    in.{slot.member} = any_{slot.ctype};"
    for listed, room in zip(layout.lists, rooms, strict=True):
        yield from _array(listed, room, layout, c)
    for slot in layout.state:
        yield f"    state.{slot.member} = any_{slot.ctype};"
    for member, (lo, hi) in within.items():
        yield f"    if (state.{member} < {lo}) return;"
        yield f"    if (state.{member} > {hi}) return;"
    yield f"    (void){c.function}({'&state, ' if layout.state else ''}&in, &out);"
    for slot in layout.outputs:
        yield f"    /*@ assert \\initialized(&out.{slot.member}); */"
    yield from _leaves(within)
    yield "}"


def _leaves(within: Mapping[str, tuple[int, int]]) -> Iterator[str]:
    for member, (lo, hi) in within.items():
        yield f"    /*@ assert {lo} <= state.{member} <= {hi}; */"


def _array(listed: ListSlot, room: Room, layout: Layout, c: FunctionNames) -> Iterator[str]:
    member, count = c.inputs[listed.name], c.counts[listed.name]
    if room.records == 0:
        yield f"    in.{member} = 0;"
    else:
        yield f"    {c.records[listed.name]} a_{member}[{room.records}];"
        yield f"    for (uint16_t i = 0; i < {room.records}; ++i) {{"
        for f in listed.fields:
            slot = layout.inputs[f]
            yield f"        a_{member}[i].{slot.member} = any_{slot.ctype};"
        yield "    }"
        yield f"    in.{member} = a_{member};"
    ctype = count_ctype(listed.capacity)
    if room.beyond:
        yield f"    in.{count} = any_{ctype};"
    else:
        yield f"    in.{count} = {room.least};"


def _init(name: str, layout: Layout, c: FunctionNames, within: Mapping[str, tuple[int, int]]) -> Iterator[str]:
    yield f"static void {name}(void)"
    yield "{"
    yield f"    {c.state_t} state;"
    yield f"    {c.init}(&state);"
    for slot in layout.state:
        yield f"    /*@ assert \\initialized(&state.{slot.member}); */"
    yield from _leaves(within)
    yield "}"
