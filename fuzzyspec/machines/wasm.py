"""Runs an image built for WebAssembly in ``wasmtime``, as ``emulate`` does for other machines."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.machines.elf import WAY_OUT
from fuzzyspec.machines.harness import LEFT, batch_symbol
from fuzzyspec.machines.image import EmulationError, Image
from fuzzyspec.machines.stream import decode, encode, result_size
from fuzzyspec.native.layout import Result, layout_of

_PAGE = 0x10000
_CHUNK = 1 << 14


class WasmEmulation:
    """An image in wasmtime. Every run starts an instance of its own."""

    def __init__(self, image: Image, seconds: float) -> None:
        """Link the image. Raises MissingTool where wasmtime is not installed, BuildError."""
        try:
            import wasmtime
        except ImportError as error:
            raise MissingTool("the package wasmtime is needed to run what was built for wasm32", WAY_OUT) from error
        self.image = image
        self._seconds = seconds
        config = wasmtime.Config()
        config.epoch_interruption = True
        self._engine = wasmtime.Engine(config)
        self._module = wasmtime.Module(self._engine, image.emulated(selftest=True).read_bytes())

    def run(
        self, function: str, inputs: Mapping[str, npt.ArrayLike], state: Mapping[str, npt.ArrayLike] | None = None
    ) -> Result:
        """As ``emulate.Emulation.run``."""
        layout = layout_of(self.image.program, self.image.program.function(function), self.image.names)
        index = [f.name for f in self.image.program.functions].index(function)
        cases = encode(layout, inputs, state)
        found: list[bytes] = []
        for at in range(0, len(cases), _CHUNK):
            try:
                found.append(self._batch(batch_symbol(index), cases[at : at + _CHUNK], result_size(layout)))
            except EmulationError as error:
                raise EmulationError(f"{function}: {error}", at + error.case, late=error.late) from error
        return decode(layout, b"".join(found), len(cases))

    def selftest(self) -> int:
        """What the self-test returns."""
        store, exports = self._instance()
        return int(self._call(store, exports[self.image.names.selftest])) & 0xFFFF

    def _batch(self, symbol: str, cases: npt.NDArray[np.uint8], size: int) -> bytes:
        """One chunk through the harness."""
        store, exports = self._instance()
        memory, n = exports["memory"], len(cases)
        start = exports["__heap_base"].value(store)
        end = start + cases.size + n * size
        missing = end - memory.data_len(store)
        if missing > 0:
            memory.grow(store, -(-missing // _PAGE))
        memory.write(store, cases.tobytes(), start)
        try:
            self._call(store, exports[symbol], n, start, start + cases.size)
        except EmulationError as error:
            at = exports[LEFT].value(store)
            left = int.from_bytes(memory.read(store, at, at + 4), "little")
            raise EmulationError(str(error), n - left if 0 < left <= n else 0, late=error.late) from error
        return bytes(memory.read(store, start + cases.size, end))

    def _instance(self) -> tuple[Any, Any]:
        import wasmtime

        store = wasmtime.Store(self._engine)
        store.set_epoch_deadline(1)
        return store, wasmtime.Instance(store, self._module, []).exports(store)

    def _call(self, store: Any, function: Any, *arguments: int) -> Any:
        """Call into an instance; the epoch's end stops it where it takes too long."""
        import wasmtime

        clock = threading.Timer(self._seconds, self._engine.increment_epoch)
        clock.start()
        try:
            return function(store, *arguments)
        except (wasmtime.Trap, wasmtime.WasmtimeError) as error:
            said = str(error).strip().splitlines()[-1].strip()
            late = "interrupt" in said
            raise EmulationError(f"no end after {self._seconds:g} s" if late else said, late=late) from error
        finally:
            clock.cancel()
