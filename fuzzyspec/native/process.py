"""C that nobody vouches for yet: built as a program of its own, one run a batch, with a time limit."""

from __future__ import annotations

import os
import struct
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import numpy as np
import numpy.typing as npt

from fuzzyspec.emit.names import name_module
from fuzzyspec.fixed.program import Program
from fuzzyspec.native.layout import Layout, Packed, Result, layout_of, out_arrays, pack, unpack
from fuzzyspec.native.module import broadcast_initial
from fuzzyspec.native.toolchain import SANITIZERS, BuildError, Toolchain, find_toolchain, optimised
from fuzzyspec.native.workspace import Workspace

_ENVIRONMENT = {
    "ASAN_OPTIONS": "detect_leaks=0:abort_on_error=0:color=never",
    "UBSAN_OPTIONS": "print_stacktrace=0:color=never",
}


@dataclass(frozen=True, slots=True)
class Death:
    """A batch that did not come to its end: at which case, and what was seen."""

    case: int
    what: str
    output: str


@dataclass(frozen=True, slots=True)
class _Done:
    """A run of the program: what it printed, and how it died if it did."""

    stdout: str
    stderr: str
    death: str | None


class NativeProcess:
    """The C and its harness as a program. ``run`` gives the results of a batch, or how it died."""

    def __init__(
        self,
        program: Program,
        files: Mapping[str, bytes],
        toolchain: Toolchain | None = None,
        *,
        sanitize: bool = False,
        warnings_are_errors: bool = True,
        level: str = "O2",
        seconds: float = 20.0,
    ) -> None:
        """Build. Raises MissingTool where there is no compiler, BuildError where it rejects the C.

        With ``sanitize`` the best of the sanitizers that the compiler has is used; ``sanitizers`` tells which.
        """
        self.program = program
        self.seconds = seconds
        self.toolchain = find_toolchain() if toolchain is None else toolchain
        self._workspace = Workspace(program, files)
        self.sanitizers: tuple[str, ...] = ()
        self.said = ""
        flags = optimised(errors=warnings_are_errors, level=level)
        try:
            if sanitize:
                self._program = self._sanitized(flags)
            else:
                self._program, self.said = self._workspace.build(self.toolchain, "runner", flags, runner=True)
        except BaseException:
            self._workspace.close()
            raise
        names = name_module(program)
        self._layouts: dict[str, tuple[int, Layout]] = {
            f.name: (i, layout_of(program, f, names)) for i, f in enumerate(program.functions)
        }

    def _sanitized(self, flags: tuple[str, ...]) -> Path:
        """Try the sanitizers best first; BuildError of the last where none works."""
        for at, sanitizers in enumerate(SANITIZERS):
            try:
                made, self.said = self._workspace.build(
                    self.toolchain, f"runner-{at}", (*flags, *sanitizers), runner=True
                )
                subprocess.run([made, "--probe"], check=True, capture_output=True, timeout=self.seconds)
            except (BuildError, subprocess.CalledProcessError, subprocess.TimeoutExpired):
                if at + 1 == len(SANITIZERS):
                    raise
            else:
                self.sanitizers = tuple(sanitizers[0].partition("=")[2].split(","))
                return made
        raise AssertionError("no sanitizers are listed")

    def run(
        self, function: str, inputs: Mapping[str, npt.ArrayLike], state: Mapping[str, npt.ArrayLike] | None = None
    ) -> Result | Death:
        """As ``NativeModule.run``; a Death where the batch crashed, was stopped by a sanitizer, or ran out of time."""
        index, layout = self._layouts[function]
        if state is None and layout.state:
            state = broadcast_initial(self.program, function, inputs)
        packed = pack(layout, inputs, state)
        outs = out_arrays(layout, packed.n)
        folder = self._workspace.path
        cases, results, progress = folder / "cases.bin", folder / "results.bin", folder / "progress.bin"
        _write_cases(cases, index, packed, [a.nbytes for a in outs])
        progress.write_bytes(bytes(8))
        results.unlink(missing_ok=True)
        done = self._started(cases.name, results.name, progress.name)
        if done.death is not None:
            return Death(_at(progress, packed.n), done.death, done.stderr[-4000:])
        data = results.read_bytes()
        if len(data) != sum(a.nbytes for a in outs):
            return Death(_at(progress, packed.n), "the batch ended early", done.stderr[-4000:])
        offset = 0
        read = []
        for array in outs:
            read.append(np.frombuffer(data, dtype=array.dtype, count=packed.n, offset=offset))
            offset += array.nbytes
        return unpack(layout, tuple(read))

    def hashes(self, function: str, seed: int, blocks: range, n: int) -> list[int] | Death:
        """As ``NativeModule.hashes``. After a Death, ``case`` is the case of the first block that gave no hash."""
        index, _ = self._layouts[function]
        progress = self._workspace.path / "progress.bin"
        progress.write_bytes(bytes(8))
        words = [index, seed, blocks.start, blocks.stop, n]
        done = self._started("--hash", *(str(w) for w in words), progress.name)
        said = [int(line, 16) for line in done.stdout.split()]
        if done.death is not None or len(said) != len(blocks):
            what = done.death or "the batch ended early"
            return Death(len(said) * n + _at(progress, n), what, done.stderr[-4000:])
        return said

    def selftest(self) -> int | Death:
        """0, or 1 + the index of the first golden vector that differs; a Death where it did not end well."""
        done = self._started("--selftest")
        if done.death is not None:
            return Death(0, done.death, done.stderr[-4000:])
        return int(done.stdout)

    def _started(self, *arguments: str) -> _Done:
        """Run the program. It is told relative names: the folder's own may hold anything."""
        try:
            done = subprocess.run(
                [str(self._program), *arguments],
                cwd=self._workspace.path,
                env={**os.environ, **_ENVIRONMENT},
                capture_output=True,
                text=True,
                errors="replace",
                timeout=self.seconds,
                check=False,
            )
        except subprocess.TimeoutExpired as late:
            said = late.stdout.decode(errors="replace") if isinstance(late.stdout, bytes) else ""
            return _Done(said, "", f"no end after {self.seconds:g} s")
        death = _how(done.returncode, done.stderr) if done.returncode != 0 else None
        return _Done(done.stdout, done.stderr, death)

    def close(self) -> None:
        """Remove the program and its folder."""
        self._workspace.close()

    def __enter__(self) -> NativeProcess:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _write_cases(path: Path, index: int, packed: Packed, out_sizes: list[int]) -> None:
    words = [index, packed.n, len(packed.widths), len(packed.arrays), len(out_sizes), *packed.widths]
    words += [a.nbytes for a in packed.arrays] + out_sizes
    with path.open("wb") as file:
        file.write(struct.pack(f"={len(words)}Q", *words))
        for array in packed.arrays:
            file.write(array.tobytes())


def _at(progress: Path, n: int) -> int:
    """The case that was running."""
    return min(int(struct.unpack("=Q", progress.read_bytes()[:8])[0]), max(n - 1, 0))


def _how(status: int, said: str) -> str:
    """One line about a death, from the sanitizer's report if there is one."""
    for line in said.splitlines():
        if "runtime error:" in line:
            where, _, what = line.partition("runtime error:")
            return f"undefined behaviour: {what.strip()} ({Path(where.strip().rstrip(':')).name})"
        if "ERROR: AddressSanitizer:" in line:
            what = line.partition("ERROR: AddressSanitizer:")[2].split(" on ")[0].strip()
            return f"address sanitizer: {what}"
    if status < 0:
        import signal

        try:
            return f"crashed with {signal.Signals(-status).name}"
        except ValueError:
            return f"crashed with signal {-status}"
    return f"ended with exit status {status}"
