"""All inputs of a function, numbered: every bit pattern of its raws, of its counts, and every legal state.

What lies outside the legal raws counts too, since saturation is behaviour; so do list elements beyond the count, which
must not matter. A state is what the function itself wrote, so it is legal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fuzzyspec.fixed.build import LIMITS
from fuzzyspec.native.layout import count_ctype
from fuzzyspec.verify.cases import Batch
from fuzzyspec.verify.draw import c_limits
from fuzzyspec.verify.points import Raws
from fuzzyspec.verify.subject import Subject


@dataclass(frozen=True, slots=True)
class _Digit:
    """One raw: ``size`` values from ``low`` on. ``element``: its column, in a list."""

    key: str
    low: int
    size: int
    element: int | None = None
    state: bool = False


@dataclass(frozen=True, slots=True)
class Space:
    """The inputs of one function. An input's number has a digit for every raw, the first one lowest."""

    subject: Subject
    digits: tuple[_Digit, ...]

    @property
    def inputs(self) -> int:
        """How many there are."""
        return math.prod(d.size for d in self.digits)

    def batch(self, numbers: Raws) -> Batch:
        """The inputs of these numbers, (N,) int64."""
        inputs: dict[str, Raws] = {}
        state: dict[str, Raws] = {}
        rest = numbers
        for digit in self.digits:
            values = digit.low + rest % digit.size
            rest = rest // digit.size
            if digit.state:
                state[digit.key] = values
            elif digit.element is None:
                inputs[digit.key] = values
            else:
                column = values[:, None]
                inputs[digit.key] = np.hstack((inputs[digit.key], column)) if digit.element else column
        return Batch("every input", inputs, state)


def space_of(subject: Subject) -> Space:
    """All inputs of a function."""
    digits: list[_Digit] = []
    for port in subject.scalars:
        low, high = c_limits(port)
        digits.append(_Digit(port.name, low, high - low + 1))
    for listed in subject.lists:
        low, high = LIMITS[count_ctype(listed.capacity)]
        digits.append(_Digit(f"{listed.name}.count", low, high - low + 1))
        for field in listed.fields:
            low, high = c_limits(field)
            key = f"{listed.name}.{field.name}"
            digits += (_Digit(key, low, high - low + 1, element) for element in range(listed.capacity))
    digits += (_Digit(k, p.lo, p.hi - p.lo + 1, state=True) for k, p in subject.state.items())
    return Space(subject, tuple(digits))


def spoken_count(inputs: int) -> str:
    """A number of inputs for people: in full, or as a power of 2 where it has more digits than one reads."""
    return f"{inputs:,}" if inputs < 10**15 else f"about 2^{inputs.bit_length() - 1}"
