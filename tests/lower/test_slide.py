"""Raws to cells and degrees, every raw of the C type."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
import pytest

from fuzzyspec.fixed.build import LIMITS
from fuzzyspec.fixed.program import (
    Assign,
    Const,
    Define,
    Expr,
    Function,
    Local,
    Port,
    Program,
    ReadPort,
    SetOutput,
    StatusBit,
    Stmt,
)
from fuzzyspec.fixed.run import Run, run
from fuzzyspec.lower.fuzzify import fuzzify
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.saturation import saturated
from fuzzyspec.lower.scope import Scope
from fuzzyspec.lower.slide import Cell, form_of, fuzzified, highest, slide, slides
from fuzzyspec.model.controller import Input
from fuzzyspec.model.units import ONE
from fuzzyspec.model.variable import Raw, Variable
from tests.lower.lower_models import NOWHERE, input_of

F = Fraction


def evenly(raw: Raw, count: int) -> Input:
    """A partition over the whole range of a raw."""
    lo, hi = sorted((raw.value(raw.lo), raw.value(raw.hi)))
    own = Variable("x", lo, hi, ONE, raw, NOWHERE)
    return input_of(own, tuple(lo + (hi - lo) * F(k, count - 1) for k in range(count)))


def over_all_raws(item: Input, body: Sequence[Stmt], cell: Expr, degree: Expr) -> Run:
    """Cell, degree and status at every raw of the C type."""
    raw = item.variable.raw
    low, high = LIMITS[raw.ctype]
    ports = (Port("x", raw.ctype, raw.lo, raw.hi, item.variable),)
    outputs = (Port("cell", "uint8", 0, 255, None), Port("d", "uint16", 0, 65535, None))
    status = (StatusBit("OUT", "outside"),)
    steps = (*body, SetOutput("cell", cell), SetOutput("d", degree))
    function = Function("f", "controller", ports, outputs, (), (), status, (), (), steps)
    return run(Program("p", (function,)), "f", {"x": np.arange(low, high + 1)}, checked=True)


@pytest.mark.parametrize(
    ("raw", "count", "form"),
    [
        (Raw("uint16", F(1, 32768), F(0), 0, 32768), 3, "slide"),
        (Raw("int16", F(-1, 256), F(5), -23040, 23040), 3, "slide"),
        (Raw("uint16", F(1), F(0), 0, 65535), 2, "slide"),
        (Raw("uint16", F(1), F(0), 0, 65535), 3, "scale"),
        (Raw("uint16", F(1), F(0), 0, 40960), 7, "scale"),
        (Raw("int16", F(-1, 3), F(2), -32768, 32767), 8, "scale"),
        (Raw("int8", F(1), F(0), -100, 100), 5, "scale"),
        (Raw("int8", F(1), F(0), -3, 3), 7, "scale"),
    ],
)
@pytest.mark.parametrize("bits", [15, 13])
def test_every_raw_finds_its_cell_and_degree(raw: Raw, count: int, form: str, bits: int) -> None:
    """For all raws of the C type: cell and degree together are the place on the axis, within the stated error, and
    exactly so on peaks that are raws, where the line does not drift by a unit."""
    item = evenly(raw, count)
    assert form_of(item) == form
    scope = Scope()
    top = highest(item)
    cell = Cell(Local(scope.name("cell"), "uint8", 0, top) if top else None)
    found = fuzzified(item, 1 << bits, cell, 1, "OUT", scope)
    start = [] if cell.local is None else [Define(cell.local, Const(0), False)]
    got = over_all_raws(item, [*start, *found.steps, *found.told], cell.local or Const(0), found.degree)
    raws = np.arange(LIMITS[raw.ctype][0], LIMITS[raw.ctype][1] + 1)
    along = got.outputs["cell"] * (1 << bits) + got.outputs["d"]
    legal = np.clip(raws, raw.lo, raw.hi)
    counts = legal - raw.lo if raw.step > 0 else raw.hi - legal
    pieces, whole = count - 1, raw.hi - raw.lo
    # In units of 1 / whole, so that all is integers.
    off = along * whole - counts * pieces * (1 << bits)
    assert np.abs(off).max() <= found.error * (1 << bits) * whole
    # A factor that leaves a product with 16 bits of raws in 32 is good to 2^-s, where pieces << (bits + s) >= 2^31.
    assert found.error * (1 << bits) <= max(1, F(pieces << bits, 1 << 15))
    peaks = counts * pieces % whole == 0
    if form == "slide" or bits == 13:
        assert peaks.any() and not off[peaks].any()
    assert np.array_equal(got.status != 0, raws != legal)


@pytest.mark.parametrize(
    "raw",
    [
        Raw("uint16", F(1, 32768), F(0), 0, 32768),
        Raw("uint16", F(1, 8192), F(0), 0, 49152),
        Raw("int16", F(-1, 256), F(5), -23040, 23040),
        Raw("int8", F(1), F(0), -126, 127),
        Raw("uint16", F(1), F(0), 1, 65535),
    ],
)
@pytest.mark.parametrize("count", [2, 3, 5, 7])
def test_sliding_gives_the_integers_of_the_chain(raw: Raw, count: int) -> None:
    """Term, degree and status are those of a saturated raw that goes through the chain of pieces, at every raw."""
    item = evenly(raw, count)
    if (raw.hi - raw.lo) % (count - 1):
        assert not slides(item)
        return
    assert slides(item)
    scope = Scope()
    given = ReadPort("x", raw.ctype, *LIMITS[raw.ctype])
    body, value, told = saturated(item.variable, given, "x", "OUT", scope)
    steps, chain = fuzzify(item, value, scope, dense=False, bare=True)
    assert chain.upper is not None
    wanted = over_all_raws(item, [*body, *steps, *told], chain.first, chain.upper)
    scope = Scope()
    first = Local(scope.name("first"), "uint8", 0, count - 2)
    found = slide(item, DEGREE_ONE, lambda k: [Assign(first, Const(k))], "OUT", scope)
    got = over_all_raws(item, [Define(first, Const(0), False), *found.steps], first, found.degree)
    assert np.array_equal(got.outputs["cell"], wanted.outputs["cell"])
    assert np.array_equal(got.outputs["d"], wanted.outputs["d"])
    assert np.array_equal(got.status, wanted.status)
    assert set(chain.errors) == {found.error}
