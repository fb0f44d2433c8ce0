"""The lemma that quotients by reciprocals rest on (docs/numbers.md), by exhaustion."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fuzzyspec.fixed import build
from fuzzyspec.fixed.division import (
    CELL_BITS,
    CELLS,
    FIRST_CELL,
    INVERSE_SHIFT,
    LINE,
    MISSING,
    REFLECTED,
    TOP_BITS,
    Kernel,
    kernel_of,
    reciprocals,
    shared,
)
from fuzzyspec.fixed.program import Division, Local, Quotient

LOSS = Fraction(11, 10_000)
"""What docs/numbers.md says: an inverse is at most this part too small."""
LOSS_FROM_LINE = Fraction(11, 100_000)
"""The same without a table."""


def node(lo: int, hi: int, division: Division) -> Quotient:
    """A quotient whose divisor lies in ``lo .. hi``."""
    found = build.quotient(Local("num", "uint32", 0, 2**32 - 1), Local("den", "uint32", lo, hi), division)
    assert isinstance(found, Quotient)
    return found


def test_an_inverse_is_never_too_large_and_hardly_too_small() -> None:
    """Every top of a divisor: the inverse times any divisor with that top lies in 2**32 times [1 - LOSS, 1]."""
    table = reciprocals()
    assert len(table) == CELLS and max(table) < 256
    assert FIRST_CELL + CELLS == 2**CELL_BITS + 1
    for top in range(2 ** (TOP_BITS - 1 - MISSING["reciprocal"]), 2**TOP_BITS + 1):
        guess = table[(top >> (TOP_BITS - CELL_BITS)) - FIRST_CELL]
        assert top * guess <= REFLECTED and guess * (REFLECTED - top * guess) < 2**32
        inverse = (guess * (REFLECTED - top * guess)) >> INVERSE_SHIFT
        assert inverse * (top + 1) <= 2**32
        assert Fraction(inverse * top, 2**32) >= 1 - LOSS
        assert inverse <= 2**19


def test_an_inverse_from_a_line_is_as_good() -> None:
    """The same for two steps of Newton's method from a straight line, where every product fits 32 bits."""
    for top in range(2 ** (TOP_BITS - 1) + 1, 2**TOP_BITS + 2):
        inverse = LINE - top
        for _ in range(2):
            assert 0 < inverse < 2**16 and top * inverse < 2**32
            factor = (2**32 - 1 - top * inverse) >> 16
            assert inverse * factor < 2**32
            inverse = (inverse * factor) >> 15
        assert inverse * top <= 2**31
        assert Fraction(inverse * (top - 1), 2**31) >= 1 - LOSS_FROM_LINE
        assert inverse <= 2**16


@pytest.mark.parametrize("bits", [4, 8])
def test_what_a_digit_leaves(bits: int) -> None:
    """From the lemma's inequality: every remainder is below two divisors, and fits 32 bits where it is shifted up."""
    most = Fraction(1)
    for _ in range(16 // bits):
        width = {4: 27, 8: 23}[bits]
        assert most * 2**width * 2**bits <= 2**32
        most = 1 + most * 2**bits * LOSS + Fraction(2**bits, 2**12)
        assert most < 2


@pytest.mark.parametrize("by", MISSING)
@given(a=st.integers(0, 2**27), b=st.integers(0, 2**27))
@example(a=0, b=2**20)
@example(a=1, b=2**27)
def test_every_divisor_is_shifted_up(by: Division, a: int, b: int) -> None:
    """Any divisor of an interval comes to lie between ``2**(width - 1 - MISSING)`` and ``2**width``."""
    lo, hi = min(a, b), max(a, b)
    kernel = kernel_of(node(lo, hi, by))
    assert kernel.by == by and hi <= 2**kernel.width
    assert kernel.smallest_bits <= max(lo, 1).bit_length()
    for den in {max(lo, 1), hi, (lo + hi + 1) // 2, *(2**k for k in range(28) if lo <= 2**k <= hi)} - {0}:
        for step in kernel.steps:
            if den < 2 ** (kernel.width - step):
                den <<= step
        assert 2 ** (kernel.width - 1 - MISSING[by]) <= den <= 2**kernel.width


@pytest.mark.parametrize("by", MISSING)
@given(a=st.integers(1, 2**27), b=st.integers(1, 2**27))
def test_sharing_costs_no_step(by: Division, a: int, b: int) -> None:
    """A kernel that covers more divisors than those of an interval shifts no oftener than its own would."""
    lo, hi = min(a, b), max(a, b)
    kernel = kernel_of(node(lo, hi, by))
    width = max((hi - 1).bit_length(), TOP_BITS + 1)
    assert len(kernel.steps) == len(replace(kernel, width=width, missing=width - lo.bit_length()).steps)


def test_divisors_that_are_too_large_are_divided_otherwise() -> None:
    """What leaves no room for a digit is divided bit by bit; a remainder without room to be larger is settled."""
    assert node(0, 2**27 + 1, "reciprocal").by == node(0, 2**28, "hardware").by == "rounds"
    assert node(0, 2**27, "reciprocal").by == "reciprocal" and node(0, 2**28 - 1, "hardware").by == "hardware"
    assert kernel_of(node(0, 2**31 - 1, "unrolled")) == Kernel("unrolled", 1)
    assert [kernel_of(node(1, 2**bits, "reciprocal")).settles for bits in (23, 24, 25)] == [False, True, False]
    assert kernel_of(node(2**20, 2**23, "reciprocal")).steps == ()


def test_one_function_of_newtons_method_serves_a_module() -> None:
    """Whatever divisors there are, one kernel covers them all; tables keep theirs, which are shared already."""
    intervals = [(2**20, 2**23), (3, 70_000), (2**21, 2**24)]
    own = {kernel_of(node(lo, hi, by)) for lo, hi in intervals for by in MISSING}
    found = shared(own)
    assert found.keys() == own
    assert {k for k in found.values() if k.by == "reciprocal"} == {k for k in own if k.by == "reciprocal"}
    (one,) = {k for k in found.values() if k.by == "newton"}
    for kernel in own:
        if kernel.by == "newton":
            assert one.width >= kernel.width and one.smallest_bits <= kernel.smallest_bits
