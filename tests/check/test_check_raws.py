"""Ranges and raws: the default, steps and counts."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from fuzzyspec.check.variables import counted, default_ctype, default_raw, finest_exponent, stepped
from fuzzyspec.model.variable import RAW_LIMITS, CType, Raw
from tests.check.checking import complaints, fuzzy, sound

CTYPES: st.SearchStrategy[CType] = st.sampled_from(sorted(RAW_LIMITS))
RATIONALS = st.fractions(min_value=-(10**6), max_value=10**6, max_denominator=10**6)
RANGES = st.tuples(RATIONALS, RATIONALS).map(sorted).filter(lambda r: r[0] < r[1])


@given(RANGES)
def test_the_default_step_is_the_finest(ends: list[Fraction]) -> None:
    """Both ends times 2**f lie within the raw type, and for f + 1 one of them does not."""
    lo, hi = ends
    ctype = default_ctype(lo)
    low, high = RAW_LIMITS[ctype]
    f = finest_exponent(lo, hi, ctype)
    assert all(low <= end * Fraction(2) ** f <= high for end in ends)
    assert not all(low <= end * Fraction(2) ** (f + 1) <= high for end in ends)


def legal_raws_are_those_inside(raw: Raw, lo: Fraction, hi: Fraction) -> None:
    """The first and last legal raw lie inside of the range, the next ones outside."""
    inside = sorted((raw.value(raw.lo), raw.value(raw.hi)))
    outside = sorted((raw.value(raw.lo - 1), raw.value(raw.hi + 1)))
    assert outside[0] < lo <= inside[0]
    assert inside[1] <= hi < outside[1]


@given(RANGES)
def test_default_raws_lie_inside_the_range(ends: list[Fraction]) -> None:
    """Every legal raw of a default raw stands for a value of the range, and no other does."""
    raw = default_raw(*ends)
    assume(raw.lo <= raw.hi)
    low, high = RAW_LIMITS[raw.ctype]
    assert low <= raw.lo and raw.hi <= high
    legal_raws_are_those_inside(raw, *ends)


@given(RANGES, st.fractions(min_value=Fraction(1, 1000), max_value=1000, max_denominator=1000))
def test_stepped_raws_lie_inside_the_range(ends: list[Fraction], step: Fraction) -> None:
    """The same with a step."""
    raw = stepped(ends[0], ends[1], "int16", step)
    assume(raw.lo <= raw.hi)
    legal_raws_are_those_inside(raw, *ends)
    assert raw.value(0) == 0


@given(RANGES, st.integers(0, 65535), st.integers(0, 65535))
def test_counts_map_onto_the_range(ends: list[Fraction], first: int, last: int) -> None:
    """The first count is the low end, the last the high end, whichever is greater."""
    assume(first != last)
    raw = counted(ends[0], ends[1], "uint16", first, last)
    assert (raw.value(first), raw.value(last)) == tuple(ends)
    assert (raw.lo, raw.hi) == (min(first, last), max(first, last))
    legal_raws_are_those_inside(raw, *ends)


def test_default_raws_of_known_ranges() -> None:
    """The ranges of nav.fz: eta_t, ddc, v, a bearing and a distance."""

    def exponent(lo: str, hi: str) -> tuple[str, int]:
        raw = default_raw(Fraction(lo), Fraction(hi))
        return raw.ctype, raw.step.denominator.bit_length() - 1

    assert exponent("0", "6") == ("uint16", 13)
    assert exponent("0", "1") == ("uint16", 15)
    assert exponent("0", "0.7") == ("uint16", 16)
    assert exponent("-180", "180") == ("int16", 7)
    assert exponent("0", "8") == ("uint16", 12)


def test_a_range_of_millions_has_a_coarse_step() -> None:
    """f may be negative."""
    raw = default_raw(Fraction(0), Fraction(10**7))
    assert raw.step == 256
    assert raw.hi == 10**7 // 256


def test_a_written_raw_is_kept() -> None:
    """`raw int16 step 0.01` and `raw uint16 4095..0` mean what they say."""
    model = sound(
        fuzzy(
            "[-10, 10] K raw int16 step 0.01 { partition NEAR FAR }", "[0, 1] raw uint16 4095..0 { partition LOW HIGH }"
        )
    )
    e, u = model.controllers[0].inputs[0].variable, model.controllers[0].outputs[0].variable
    assert e.raw == Raw("int16", Fraction(1, 100), Fraction(0), -1000, 1000)
    assert u.raw == Raw("uint16", Fraction(-1, 4095), Fraction(1), 0, 4095)


def test_ranges_are_constant_expressions_with_params() -> None:
    """Range ends, steps and counts may be computed from params and other units."""
    model = sound(
        "param half = 0.5 m\n" + fuzzy("[-half, 2 * half + 100 cm] m raw int16 step half / 50 { partition NEAR FAR }")
    )
    v = model.controllers[0].inputs[0].variable
    assert (v.lo, v.hi, v.raw.step) == (Fraction(-1, 2), 2, Fraction(1, 100))


@pytest.mark.parametrize(
    ("given_range", "code", "marked"),
    [
        ("[4, 4]", "FZ401", "[4, 4]"),
        ("[4, -4]", "FZ401", "[4, -4]"),
        ("[0, 4 m] s", "FZ220", "4 m"),
        ("[0, x]", "FZ201", "x"),
        ("[0, 4] raw int", "FZ208", "int"),
        ("[0, 4] raw uint16_t", "FZ208", "uint16_t"),
        ("[-1, 4] raw uint8", "FZ402", "uint8"),
        ("[0, 100] raw uint8 step 0.1", "FZ402", "raw uint8 step 0.1"),
        ("[0, 4] raw int16 step -0.1", "FZ403", "-0.1"),
        ("[0, 4] m raw int16 step 1 s", "FZ220", "1 s"),
        ("[0, 4] raw uint8 0..256", "FZ402", "256"),
        ("[0, 4] raw uint8 0..2.5", "FZ404", "2.5"),
        ("[0, 4] raw uint8 -1..2", "FZ402", "-1"),
        ("[1000000, 1000001]", "FZ405", "[1000000, 1000001]"),
        ("[0, 1] raw int8 step 2", "FZ405", "[0, 1]"),
        ("[0, 0.00000000000000000000001]", "FZ443", "0.00000000000000000000001"),
    ],
)
def test_ranges_and_raws_that_are_refused(given_range: str, code: str, marked: str) -> None:
    """Each slip is reported once, at its place, and nothing follows from it."""
    assert complaints(fuzzy(given_range + " { partition NEAR FAR }")) == [(code, marked)]
