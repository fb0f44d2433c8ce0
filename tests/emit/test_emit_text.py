"""Numbers, comments, lines and conversion macros as text."""

from __future__ import annotations

import subprocess
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.diagnostics.numerals import exact, nearest, upper
from fuzzyspec.emit.conversion import conversion
from fuzzyspec.emit.layout import COLUMNS, code, comment
from fuzzyspec.model.units import Unit
from fuzzyspec.model.variable import RAW_LIMITS, CType, Raw, Variable
from fuzzyspec.native import find_toolchain

POSITIVE = st.fractions(min_value=Fraction(1, 10**9), max_value=10**9)


@given(st.fractions(max_denominator=10**9))
def test_exact_numbers_read_back(value: Fraction) -> None:
    """Whether printed as a decimal or as a quotient, the text is the number."""
    assert Fraction(exact(value)) == value


@given(POSITIVE)
def test_bounds_are_rounded_up(value: Fraction) -> None:
    """The text of a bound is never below it, and at most one unit of the second digit above."""
    told = Fraction(upper(value))
    assert value <= told <= value * Fraction(11, 10)
    assert len(upper(value).replace(".", "").strip("0")) <= 2


@pytest.mark.parametrize(
    ("value", "text"), [("0", "0"), ("1/3", "0.34"), ("0.0996", "0.1"), ("99.5", "100"), ("120", "120"), ("121", "130")]
)
def test_bounds_at_the_edges_of_a_digit(value: str, text: str) -> None:
    """Rounding up carries into the next place without losing it."""
    assert upper(Fraction(value)) == text


@given(st.fractions(max_denominator=10**6), st.integers(0, 8))
def test_nearest_is_within_half_a_place(value: Fraction, places: int) -> None:
    """A rounded number is at most half its last place away."""
    assert abs(Fraction(nearest(value, places)) - value) * 10**places <= Fraction(1, 2)


@given(st.text(max_size=300), st.integers(0, 3))
def test_nothing_escapes_a_comment(text: str, depth: int) -> None:
    """Whatever a spec says, its comment opens and closes once, and holds no trigraph."""
    whole = "\n".join(comment(text, depth))
    assert whole.count("/*") == 1 and whole.count("*/") == 1
    assert whole.endswith("*/") and "??" not in whole


@given(st.lists(st.sampled_from(["alpha", "(b + c)", "f(x, y)", "(d ? e : (g * h))"]), min_size=1, max_size=40))
def test_broken_lines_say_the_same(operands: list[str]) -> None:
    """A long statement is broken at spaces only, and each of its lines fits."""
    text = f"value = {' + '.join(operands)};"
    lines = code(text, 1)
    assert " ".join(line.strip() for line in lines) == text
    assert all(len(line) <= COLUMNS for line in lines)


def _variable(ctype: CType, unit: str, lo: Fraction, hi: Fraction, step: Fraction, origin: Fraction) -> Variable | None:
    ends = sorted(((lo - origin) / step, (hi - origin) / step))
    first, last = -(-ends[0].numerator // ends[0].denominator), ends[1].numerator // ends[1].denominator
    if first >= last or first < RAW_LIMITS[ctype][0] or last > RAW_LIMITS[ctype][1]:
        return None
    return Variable("x", lo, hi, Unit(unit), Raw(ctype, step, origin, first, last), Span(0, 0))


def _variables() -> list[Variable]:
    """Binary and decimal steps, counts that run backwards, ends that are no raws, all raw types."""
    found: list[Variable | None] = []
    for ctype in RAW_LIMITS:
        for unit in ("m", "m/s", "deg", "", "%", "kg", "rpm"):
            for lo, hi in (("0", "0.7"), ("-0.3", "0.3"), ("-180", "180"), ("0", "8"), ("20", "100")):
                for step in ("1/65536", "1/100", "1/128", "-1/3", "0.7/255", "2"):
                    for origin in ("0", lo, hi):
                        size = Fraction(step) if "0." not in step else Fraction(7, 2550)
                        found.append(_variable(ctype, unit, Fraction(lo), Fraction(hi), size, Fraction(origin)))
    return [v for v in found if v is not None]


def test_conversion_macros_round_to_the_nearest_legal_raw(tmp_path: Path) -> None:
    """FROM gives the nearest legal raw and TO the nearest thousandth, at the range's ends too, as constants."""
    lines = ["#include <stdint.h>", "typedef char proof[1];"]
    checked = 0
    for index, variable in enumerate(_variables()):
        raw = variable.raw
        found = conversion(variable, raw.ctype)
        if found is None:
            continue
        lines += [f"#define FROM{index}(x) {found.from_body}", f"#define TO{index}(raw) {found.to_body}"]
        spread = {found.lo, found.lo + 1, (found.lo + found.hi) // 2, found.hi - 1, found.hi}
        for x in sorted(spread):
            want = raw.nearest(Fraction(x, found.per_unit))
            lines.append(f"extern char c{checked}[(FROM{index}({x}) == ({want})) ? 1 : -1];")
            checked += 1
        for r in sorted({raw.lo, raw.lo + 1, (raw.lo + raw.hi) // 2, raw.hi}):
            exact_value = raw.value(r) * found.per_unit + Fraction(1, 2)
            want = exact_value.numerator // exact_value.denominator
            lines.append(f"extern char c{checked}[(TO{index}({r}) == ({want})) ? 1 : -1];")
            checked += 1
    assert checked > 1000
    (tmp_path / "macros.c").write_text("\n".join(lines) + "\n")
    command = [*find_toolchain().command, "-std=c99", "-Wall", "-Wextra", "-Werror", "-c", "macros.c", "-o", "macros.o"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]
