"""What is read from an ELF file: sections to load, symbols, sizes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

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
class Binary:
    """The allocated sections of a linked file, and its symbols."""

    sections: tuple[Section, ...]
    symbols: Mapping[str, int]

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
        symbols = {} if table is None else {s.name: s["st_value"] for s in table.iter_symbols() if s.name}
    return Binary(sections, symbols)


WAY_OUT = "run `pip install 'fuzzyc[targets]'`"
