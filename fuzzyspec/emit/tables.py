"""Static const tables and the macros that read them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from fuzzyspec.emit.cprinter import literal, reader_name
from fuzzyspec.emit.ctypes import signed, spelled, width
from fuzzyspec.emit.layout import rows
from fuzzyspec.fixed.program import CType

_PRIMITIVES = {8: "pgm_read_byte", 16: "pgm_read_word", 32: "pgm_read_dword"}


@dataclass(frozen=True, slots=True)
class Printed:
    """A table as its template wants it."""

    name: str
    ctype: str
    size: int
    rows: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Reader:
    """A macro that reads one element of a type."""

    macro: str
    ctype: str
    primitive: str


def printed(name: str, ctype: CType, values: Iterable[int]) -> Printed:
    """The table's initialiser, filled into lines."""
    items = [literal(value, signed(ctype)).text for value in values]
    return Printed(name, spelled(ctype), len(items), tuple(rows(items)))


def readers(macro: str, ctypes: Iterable[CType]) -> tuple[Reader, ...]:
    """The macros for the element types that are used, narrow before wide."""
    used = sorted(set(ctypes), key=lambda c: (width(c), signed(c)))
    return tuple(Reader(reader_name(f"{macro}_READ", c), spelled(c), _PRIMITIVES[width(c)]) for c in used)
