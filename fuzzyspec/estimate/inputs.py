"""The inputs that a cost is a mean over: one stream of numbers, the same for everybody.

    s = 1664525 s + 1013904223 mod 2^32, from s = 12345;    u = floor(s / 2^8) / 2^24

A case draws in the order of the function's inputs. A scalar takes one u and becomes the raw nearest to
``lo + (hi - lo) u``. A list takes one u for its count, ``floor((capacity + 1) u)``, then one for every field of each of
its ``capacity`` records, used or not. Where the function remembers, each number of its state takes one u last, over its
legal raws.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from fuzzyspec.fixed.program import Function, ListPort, Port, Program, StatePort
from fuzzyspec.fixed.quantise import quantise

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]

SEED = 12345


def unit_numbers(count: int, seed: int = SEED) -> Floats:
    """The first ``count`` values of u."""
    found = np.empty(count)
    state = seed
    for i in range(count):
        state = (1664525 * state + 1013904223) % 2**32
        found[i] = (state >> 8) / 2**24
    return found


def draw_cases(program: Program, function: Function, n: int) -> tuple[dict[str, Ints], dict[str, Ints] | None]:
    """N cases of raws by signal, and N states (None where the function does not remember)."""
    states = list(states_of(program, function))
    width = sum(1 + p.capacity * len(p.fields) if isinstance(p, ListPort) else 1 for p in function.inputs)
    width += len(states)
    numbers = unit_numbers(n * width).reshape(n, width)
    at = 0
    inputs: dict[str, Ints] = {}
    for port in function.inputs:
        match port:
            case Port():
                inputs[port.name] = _raws(port, numbers[:, at])
                at += 1
            case ListPort(name, capacity, fields):
                inputs[f"{name}.count"] = np.floor(numbers[:, at] * (capacity + 1)).astype(np.int64)
                records = numbers[:, at + 1 : at + 1 + capacity * len(fields)].reshape(n, capacity, len(fields))
                for k, field in enumerate(fields):
                    inputs[f"{name}.{field.name}"] = _raws(field, records[:, :, k])
                at += 1 + capacity * len(fields)
    state: dict[str, Ints] = {}
    for key, held in states:
        state[key] = held.lo + np.floor(numbers[:, at] * (held.hi - held.lo + 1)).astype(np.int64)
        at += 1
    return inputs, state or None


def states_of(program: Program, function: Function) -> Iterator[tuple[str, StatePort]]:
    """What survives a call, by state key."""
    for port in function.state:
        yield port.name, port
    for name, callee in function.nested:
        for port in program.function(callee).state:
            yield f"{name}.{port.name}", port


def _raws(port: Port, u: Floats) -> Ints:
    variable = port.variable
    if variable is None:  # of a program that no spec stands behind
        raws: Ints = port.lo + np.floor(u * (port.hi - port.lo + 1)).astype(np.int64)
        return raws
    lo, hi = float(variable.lo), float(variable.hi)
    return quantise(variable, lo + (hi - lo) * u)
