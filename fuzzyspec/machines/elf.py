"""What is read from an ELF file: sections to load, symbols, sizes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fuzzyspec.diagnostics.refusal import MissingTool

_ALLOCATED = 0x2


@dataclass(frozen=True, slots=True)
class Section:
    """An allocated section; ``data`` is None where it only reserves room (``.bss``)."""

    name: str
    address: int
    size: int
    data: bytes | None


@dataclass(frozen=True, slots=True)
class Object:
    """Data with a name: a table, a variable. The names of static ones may come more than once."""

    name: str
    address: int
    size: int


@dataclass(frozen=True, slots=True)
class Binary:
    """The allocated sections of a linked file, and its symbols: all of them, those of data, those of code.

    ``unnamed`` are the parts of sections that no symbol with a size covers.
    """

    sections: tuple[Section, ...]
    symbols: Mapping[str, int]
    objects: tuple[Object, ...]
    functions: Mapping[str, int]
    unnamed: tuple[Object, ...]

    def size(self, *names: str) -> int:
        """Bytes of the sections named."""
        return sum(s.size for s in self.sections if s.name in names)

    def span(self, name: str) -> range:
        """The addresses of a section; empty where there is none."""
        for section in self.sections:
            if section.name == name:
                return range(section.address, section.address + section.size)
        return range(0)


def read_elf(path: Path) -> Binary:
    """Read a linked file. Section headers are what counts: segments may overlap or carry headers along."""
    try:
        from elftools.elf.elffile import ELFFile
    except ImportError as error:
        raise MissingTool("the package pyelftools is needed to read what was built", WAY_OUT) from error

    with path.open("rb") as file:
        elf = ELFFile(file)
        sections = tuple(
            Section(s.name, s["sh_addr"], s["sh_size"], None if s["sh_type"] == "SHT_NOBITS" else s.data())
            for s in elf.iter_sections()
            if s["sh_flags"] & _ALLOCATED and s["sh_size"]
        )
        table = elf.get_section_by_name(".symtab")
        named = [] if table is None else [s for s in table.iter_symbols() if s.name]
    symbols = {s.name: s["st_value"] for s in named}
    objects = tuple(Object(s.name, s["st_value"], s["st_size"]) for s in named if _kind(s) == "STT_OBJECT")
    # Code written in assembly often has no type; names that begin with $ or . are marks of the assembler.
    code = [s for s in named if _kind(s) in ("STT_FUNC", "STT_NOTYPE") and _placed(s) and s.name[0] not in "$."]
    covered = sorted((s["st_value"] & ~1, s["st_size"]) for s in named if s["st_size"])
    return Binary(sections, symbols, objects, {s.name: s["st_value"] for s in code}, _gaps(sections, covered))


def patched(linked: bytes, data: Mapping[str, bytes]) -> bytes:
    """A linked file with other bytes where symbols stand. KeyError where there is no such symbol with a place."""
    from io import BytesIO

    from elftools.elf.elffile import ELFFile

    elf = ELFFile(BytesIO(linked))
    table = elf.get_section_by_name(".symtab")
    places = {s.name: s for s in ([] if table is None else table.iter_symbols()) if s.name in data and _placed(s)}
    changed = bytearray(linked)
    for name, content in data.items():
        symbol = places[name]
        section = elf.get_section(symbol["st_shndx"])
        if len(content) > symbol["st_size"]:
            raise ValueError(f"{len(content)} bytes do not fit `{name}`")
        at = section["sh_offset"] + symbol["st_value"] - section["sh_addr"]
        changed[at : at + len(content)] = content
    return bytes(changed)


def _gaps(sections: tuple[Section, ...], covered: list[tuple[int, int]]) -> tuple[Object, ...]:
    """What of the sections lies in none of the (address, size), under the section's name."""
    found: list[Object] = []
    for section in sections:
        at, end = section.address, section.address + section.size
        for start, size in covered:
            if section.address <= start < end:
                if start > at:
                    found.append(Object(section.name, at, start - at))
                at = max(at, start + size)
        if at < end:
            found.append(Object(section.name, at, end - at))
    return tuple(found)


def _placed(symbol: Any) -> bool:
    """Whether it stands in a section: not a plain number."""
    return symbol["st_shndx"] not in ("SHN_ABS", "SHN_UNDEF")


def _kind(symbol: Any) -> str:
    return str(symbol["st_info"]["type"])


WAY_OUT = "run `pip install 'fuzzyc[targets]'`"
