"""What calls take on an emulated ATmega328P: its timers are read around each, and ``simavr`` counts every cycle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fuzzyspec.machines.avr_harness import print_avr_harness
from fuzzyspec.machines.image import EmulationError, Image
from fuzzyspec.machines.simavr import AvrFeed, DoesNotFit
from fuzzyspec.machines.stream import decode, encode, result_size
from fuzzyspec.native.layout import Result, layout_of

Ints = npt.NDArray[np.int64]

_RETURN = 4
"""Cycles of RET: what the empty function takes."""
_SECONDS = 300


@dataclass(frozen=True, slots=True)
class AvrCalls:
    """N measured calls. ``cycles``: (N,), from the function's first instruction to its return.

    ``stack``: the deepest that any call wrote, its return address included.
    """

    result: Result
    cycles: Ints
    stack: int


def measure_avr(
    image: Image,
    function: str,
    inputs: Mapping[str, npt.ArrayLike],
    state: Mapping[str, npt.ArrayLike] | None,
    *,
    long_calls: bool = False,
) -> AvrCalls | None:
    """N calls of the function named as in the spec; None where it does not fit the device together with its inputs.

    With ``long_calls`` they may take more than half a million cycles (``print_avr_harness``).
    Raises BuildError, EmulationError.
    """
    layout = layout_of(image.program, image.program.function(function), image.names)
    try:
        feed = AvrFeed(image, function, print_avr_harness(image.program, function, long_calls=long_calls))
    except DoesNotFit:
        return None
    cases = encode(layout, inputs, state)
    results, cycles, stack = [], [], 0
    for lines in feed.lines(cases, _SECONDS):
        empty = _cycles(lines[0]) - _RETURN
        for line in lines[1:-1]:
            words = line.split()
            results.append(bytes.fromhex(words[0]))
            cycles.append(_cycles(words[1]) - empty)
        stack = max(stack, int.from_bytes(bytes.fromhex(lines[-1][1:]), "little"))
    if len(results) != len(cases) or any(len(r) != result_size(layout) for r in results):
        raise EmulationError(f"{function}: simavr returned {len(results)} results for {len(cases)} cases")
    return AvrCalls(decode(layout, b"".join(results), len(cases)), np.array(cycles, dtype=np.int64), stack)


def _cycles(times: str) -> int:
    """From the two timers: the fine one's difference, modulo 2^16, nearest to what the coarse one says."""
    read = bytes.fromhex(times)
    fine = (int.from_bytes(read[2:4], "little") - int.from_bytes(read[0:2], "little")) % 65536
    coarse = (read[4] + 256 * read[5]) * 1024
    return fine + 65536 * max(0, round((coarse - fine) / 65536))
