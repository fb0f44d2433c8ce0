"""The functions that divide, as data for their templates."""

from __future__ import annotations

from dataclasses import dataclass

from fuzzyspec.fixed.division import CELL_BITS, FIRST_CELL, INVERSE_SHIFT, REFLECTED, TOP_BITS, Kernel

QUOTIENT_BITS = 16


@dataclass(frozen=True, slots=True)
class Step:
    """A divisor below ``limit`` is shifted up by ``shift``, and the numerator with it."""

    limit: int
    shift: int


@dataclass(frozen=True, slots=True)
class Reciprocal:
    """Where the bits lie: ``cell`` and ``top`` in the divisor, ``scaled`` in a remainder, ``digit`` in its product."""

    steps: tuple[Step, ...]
    cell: int
    first_cell: int
    top: int
    reflected: int
    inverse: int
    scaled: int
    digit: int
    settles: bool


@dataclass(frozen=True, slots=True)
class Divider:
    """A function and its template, the ``domain`` of its divisor in words. The ``digits`` have ``bits`` bits each."""

    name: str
    template: str
    domain: str
    bits: int
    digits: int
    reciprocal: Reciprocal


def divider(kernel: Kernel, name: str) -> Divider:
    """What the template of a kernel lays out."""
    suffix = f"_{kernel.digit_bits}" if kernel.by == "hardware" else ""
    return Divider(
        name,
        f"quotient_{kernel.by}{suffix}.c.j2",
        _domain(kernel),
        kernel.digit_bits,
        QUOTIENT_BITS // kernel.digit_bits,
        _reciprocal(kernel),
    )


def _domain(kernel: Kernel) -> str:
    match kernel.by:
        case "loop" | "rounds" | "unrolled":
            return "den < 2^31"
        case "hardware":
            return f"den < 2^{32 - kernel.digit_bits}"
        case "reciprocal":
            low = f"2^{kernel.smallest_bits - 1} <= " if kernel.smallest_bits > 1 else ""
            return f"{low}den <= 2^{kernel.width}"


def _reciprocal(kernel: Kernel) -> Reciprocal:
    return Reciprocal(
        steps=tuple(Step(2 ** (kernel.width - shift), shift) for shift in kernel.steps),
        cell=kernel.width - CELL_BITS,
        first_cell=FIRST_CELL,
        top=kernel.width - TOP_BITS,
        reflected=REFLECTED,
        inverse=INVERSE_SHIFT,
        scaled=kernel.width - TOP_BITS + 1,
        digit=31 - kernel.digit_bits,
        settles=kernel.settles,
    )
