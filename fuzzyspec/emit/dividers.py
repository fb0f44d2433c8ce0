"""The functions that divide, as data for their templates."""

from __future__ import annotations

from dataclasses import dataclass

from fuzzyspec.fixed.division import CELL_BITS, FIRST_CELL, INVERSE_SHIFT, LINE, REFLECTED, TOP_BITS, Kernel

QUOTIENT_BITS = 16


@dataclass(frozen=True, slots=True)
class Step:
    """A divisor of at most so many ``bits`` is shifted up by ``shift``, and the numerator with it."""

    bits: int
    shift: int


@dataclass(frozen=True, slots=True)
class Reciprocal:
    """Where the bits lie: ``cell`` and ``top`` in the divisor, ``scaled`` in a remainder, ``digit`` in its product.

    ``line``: what the first guess is taken from, where it does not come from the table.
    """

    tabled: bool
    line: int
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
    form = "reciprocal" if kernel.by == "newton" else kernel.by
    return Divider(
        name,
        f"quotient_{form}{suffix}.c.j2",
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
        case "newton" | "reciprocal":
            low = f"2^{kernel.smallest_bits - 1} <= " if kernel.smallest_bits > 1 else ""
            return f"{low}den <= 2^{kernel.width}"


def _reciprocal(kernel: Kernel) -> Reciprocal:
    tabled = kernel.by == "reciprocal"
    return Reciprocal(
        tabled=tabled,
        line=LINE,
        steps=tuple(Step(kernel.width - shift, shift) for shift in kernel.steps),
        cell=kernel.width - CELL_BITS,
        first_cell=FIRST_CELL,
        top=kernel.width - TOP_BITS,
        reflected=REFLECTED,
        inverse=INVERSE_SHIFT,
        scaled=kernel.width - TOP_BITS + 1,
        digit=(31 if tabled else 30) - kernel.digit_bits,
        settles=kernel.settles,
    )
