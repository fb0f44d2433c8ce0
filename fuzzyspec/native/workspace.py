"""The temporary folder of a host build: the C, the harness, and what the compiler made of them."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from types import TracebackType

from fuzzyspec.fixed.program import Program
from fuzzyspec.native.harness import print_harness
from fuzzyspec.native.toolchain import Toolchain

PRODUCT, HARNESS = "product", "harness"


class Workspace:
    """A folder that vanishes with ``close`` (or at the end of ``with``).

    ``files`` are the compiler's output by name: ``<prefix>.h``, ``<prefix>.c`` and ``<prefix>_selftest.c``.
    """

    def __init__(self, program: Program, files: Mapping[str, bytes]) -> None:
        self.program = program
        self._folder = tempfile.TemporaryDirectory(prefix="fuzzyc-")
        self.path = Path(self._folder.name).resolve()
        # Apart, so that a module may have any name that its files can have.
        (self.path / PRODUCT).mkdir()
        (self.path / HARNESS).mkdir()
        for name, content in files.items():
            (self.path / PRODUCT / name).write_bytes(content)
        self._write("harness.c", print_harness(program))
        for name in ("batches.h", "bulk.c", "runner.c"):
            self._write(name, resources.files("fuzzyspec.native").joinpath(name).read_text(encoding="utf-8"))
        self.product = tuple(self.path / PRODUCT / name for name in sorted(files) if name.endswith(".c"))

    def _write(self, name: str, text: str) -> None:
        (self.path / HARNESS / name).write_text(text, encoding="utf-8", newline="\n")

    def build(self, toolchain: Toolchain, target: str, flags: tuple[str, ...], *, runner: bool) -> tuple[Path, str]:
        """Compile the C and its harness, with ``runner`` to a program of its own; the file made, and what was said."""
        needed = ["harness.c", "bulk.c", *(["runner.c"] if runner else [])]
        sources = [*self.product, *(self.path / HARNESS / name for name in needed)]
        made = self.path / target
        return made, toolchain.build(sources, made, flags)

    def close(self) -> None:
        """Remove the folder."""
        self._folder.cleanup()

    def __enter__(self) -> Workspace:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
