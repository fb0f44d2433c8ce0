"""Cases and results as streams of bytes, little-endian and without gaps, which a harness on any target can read.

A case: every input slot, then every state slot; a list's field is written for all ``capacity`` records. A result: every
output, the status (4 bytes), the state after the call.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from fuzzyspec.native.layout import Layout, Result, out_arrays, pack, unpack

Bytes = npt.NDArray[np.uint8]


def case_size(layout: Layout) -> int:
    """Bytes of one case."""
    sizes = [np.dtype(s.dtype).itemsize for s in layout.inputs + layout.state]
    counts = [1 if s.list is None else layout.lists[s.list].capacity for s in layout.inputs]
    return sum(size * count for size, count in zip(sizes, [*counts, *[1] * len(layout.state)], strict=True))


def result_size(layout: Layout) -> int:
    """Bytes of one result."""
    return sum(a.itemsize for a in out_arrays(layout, 0))


def encode(layout: Layout, inputs: Mapping[str, npt.ArrayLike], state: Mapping[str, npt.ArrayLike] | None) -> Bytes:
    """N cases as an array (N, ``case_size``). Raises ValueError as ``native.layout.pack``."""
    packed = pack(layout, inputs, state)
    columns: list[Bytes] = []
    for slot, array in zip(layout.inputs + layout.state, packed.arrays, strict=True):
        if slot.list is not None:
            array = _of_width(array, layout.lists[slot.list].capacity)
        columns.append(_bytes_of(array, packed.n))
    return np.concatenate(columns, axis=1) if columns else np.zeros((packed.n, 0), dtype=np.uint8)


def decode(layout: Layout, results: bytes, n: int) -> Result:
    """N results by name. ValueError where the stream has another length."""
    table = np.frombuffer(results, dtype=np.uint8).reshape(n, result_size(layout))
    found = []
    at = 0
    for array in out_arrays(layout, n):
        part = np.ascontiguousarray(table[:, at : at + array.itemsize])
        found.append(part.view(array.dtype.newbyteorder("<")).reshape(n).astype(array.dtype))
        at += array.itemsize
    return unpack(layout, tuple(found))


def _of_width(array: npt.NDArray[Any], width: int) -> npt.NDArray[Any]:
    """Columns cut, or filled up with zeros: no count reaches them."""
    kept = array[:, :width]
    return np.pad(kept, ((0, 0), (0, width - kept.shape[1])))


def _bytes_of(array: npt.NDArray[Any], n: int) -> Bytes:
    little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
    return little.view(np.uint8).reshape(n, -1)
