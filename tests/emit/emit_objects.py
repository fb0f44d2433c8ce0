"""What is in an object file: symbols, sections that are written to, whether it counts in floating point."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from elftools.elf.elffile import ELFFile
from elftools.elf.sections import SymbolTableSection

ALLOCATED, WRITABLE = 0x2, 0x1
FLOAT = 0x04
"""DWARF's encoding of floating point."""


@dataclass(frozen=True)
class Object:
    """``written``: bytes of sections that a program may write to, by name. ``floats``: how many of the C's base
    types are floating point."""

    exported: frozenset[str]
    wanted: frozenset[str]
    written: dict[str, int]
    floats: int


def read(path: Path) -> Object:
    """The object file at ``path``, compiled with ``-g``."""
    exported: set[str] = set()
    wanted: set[str] = set()
    with path.open("rb") as stream:
        elf = ELFFile(stream)
        tables = [s for s in elf.iter_sections() if isinstance(s, SymbolTableSection)]
        for symbol in (symbol for table in tables for symbol in table.iter_symbols()):
            if symbol["st_info"]["bind"] != "STB_LOCAL":
                (wanted if symbol["st_shndx"] == "SHN_UNDEF" else exported).add(symbol.name)
        written = {
            s.name: s["sh_size"]
            for s in elf.iter_sections()
            if s["sh_flags"] & ALLOCATED and s["sh_flags"] & WRITABLE and s["sh_size"]
        }
        floats = 0
        # Names would need relocations that are not known for every machine; encodings stand in the entries.
        for unit in elf.get_dwarf_info(relocate_dwarf_sections=False).iter_CUs():
            for entry in unit.iter_DIEs():
                if entry.tag == "DW_TAG_base_type":
                    floats += entry.attributes["DW_AT_encoding"].value == FLOAT
    return Object(frozenset(exported), frozenset(wanted), written, floats)
