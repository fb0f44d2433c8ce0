"""The generated C inside this process: built for the host, loaded, and called over arrays."""

from __future__ import annotations

from collections.abc import Mapping
from types import TracebackType
from typing import Any

import cffi
import numpy as np
import numpy.typing as npt

from fuzzyspec.emit.names import name_module
from fuzzyspec.fixed.program import Program
from fuzzyspec.fixed.run import initial_state
from fuzzyspec.native.layout import Layout, Result, layout_of, out_arrays, pack, unpack
from fuzzyspec.native.toolchain import Toolchain, find_toolchain, optimised, shared
from fuzzyspec.native.workspace import Workspace

_CDEF = """
typedef int fuzzycharness_batch(size_t, const size_t *, const void *const *, void *const *, volatile uint64_t *);
extern fuzzycharness_batch *const fuzzycharness_batches[];
unsigned fuzzycharness_selftest(void);
void fuzzycharness_widths(size_t, uint64_t, size_t *);
void fuzzycharness_draw(size_t, uint64_t, uint64_t, size_t, const size_t *, void *const *);
uint64_t fuzzycharness_hash(size_t, uint64_t, uint64_t, size_t, volatile uint64_t *, int *);
"""
"""What is called of ``batches.h``."""


class NativeModule:
    """A module's C, compiled with strict flags at -O2 and loaded through cffi's ABI mode.

    It stays loaded until ``close`` (or the end of ``with``, or the object's own end). The C runs in this process:
    code that nobody vouches for belongs into a ``NativeProcess``.
    """

    def __init__(self, program: Program, files: Mapping[str, bytes], toolchain: Toolchain | None = None) -> None:
        """Build and load. Raises MissingTool where there is no compiler, BuildError where it rejects the C."""
        self.program = program
        self.toolchain = find_toolchain() if toolchain is None else toolchain
        self._ffi = cffi.FFI()
        self._ffi.cdef(_CDEF)
        with Workspace(program, files) as workspace:
            flags = (*optimised(errors=True), *shared())
            made, _ = workspace.build(self.toolchain, f"{program.name}.so", flags, runner=False)
            # Once mapped, the library no longer needs its file.
            self._library: Any = self._ffi.dlopen(str(made))
        names = name_module(program)
        self._layouts: dict[str, tuple[int, Layout]] = {
            f.name: (i, layout_of(program, f, names)) for i, f in enumerate(program.functions)
        }

    def run(
        self, function: str, inputs: Mapping[str, npt.ArrayLike], state: Mapping[str, npt.ArrayLike] | None = None
    ) -> Result:
        """N calls of the function named as in the spec.

        ``inputs`` holds raws by signal: (N,) for a scalar and for ``<list>.count``, (N, M) for ``<list>.<field>``;
        anything that fits the C type is allowed. ``state`` holds (N,) raws where the function remembers; None
        is its first state. Raises ValueError where a signal is missing, unknown, or does not fit.
        """
        if self._library is None:
            raise ValueError("the module was closed")
        index, layout = self._layouts[function]
        if state is None and layout.state:
            state = broadcast_initial(self.program, function, inputs)
        packed = pack(layout, inputs, state)
        outs = out_arrays(layout, packed.n)
        ffi = self._ffi
        widths = ffi.new("size_t[]", list(packed.widths) or [0])
        ins_c = ffi.new("const void *[]", [ffi.cast("const void *", a.ctypes.data) for a in packed.arrays] or 1)
        outs_c = ffi.new("void *[]", [ffi.cast("void *", a.ctypes.data) for a in outs])
        at = ffi.new("uint64_t *")
        if self._library.fuzzycharness_batches[index](packed.n, widths, ins_c, outs_c, at) != 0:
            raise MemoryError("the batch ran out of memory")
        return unpack(layout, outs)

    def hashes(self, function: str, seed: int, blocks: range, n: int) -> list[int]:
        """A hash of the results of each block of n cases that the build makes up; other builds make up the same."""
        index, _ = self._layouts[function]
        at, failed = self._ffi.new("uint64_t *"), self._ffi.new("int *")
        found = [int(self._library.fuzzycharness_hash(index, seed, block, n, at, failed)) for block in blocks]
        if failed[0]:
            raise MemoryError("a block ran out of memory")
        return found

    def block(
        self, function: str, seed: int, block: int, n: int
    ) -> tuple[dict[str, npt.NDArray[np.int64]], dict[str, npt.NDArray[np.int64]]]:
        """The inputs and states of such a block."""
        index, layout = self._layouts[function]
        ffi = self._ffi
        widths = ffi.new("size_t[]", max(len(layout.lists), 1))
        self._library.fuzzycharness_widths(index, block, widths)
        slots = layout.inputs + layout.state
        arrays = [np.zeros((n,) if s.list is None else (n, widths[s.list]), dtype=s.dtype) for s in slots]
        pointers = ffi.new("void *[]", [ffi.cast("void *", a.ctypes.data) for a in arrays])
        self._library.fuzzycharness_draw(index, seed, block, n, widths, pointers)
        wide = [(s.key, a.astype(np.int64)) for s, a in zip(slots, arrays, strict=True)]
        return dict(wide[: len(layout.inputs)]), dict(wide[len(layout.inputs) :])

    def selftest(self) -> int:
        """0, or 1 + the index of the first golden vector that differs."""
        return int(self._library.fuzzycharness_selftest())

    def close(self) -> None:
        """Unload the library; the object is of no use afterwards."""
        if self._library is not None:
            self._ffi.dlclose(self._library)
            self._library = None

    def __enter__(self) -> NativeModule:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "_library", None) is not None:
            self.close()


def broadcast_initial(program: Program, function: str, inputs: Mapping[str, npt.ArrayLike]) -> dict[str, npt.ArrayLike]:
    """The first state, once for each case."""
    n = max((len(np.atleast_1d(np.asarray(v))) for v in inputs.values()), default=0)
    return {k: np.full(n, v) for k, v in initial_state(program, program.function(function)).items()}
