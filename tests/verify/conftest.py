"""A module written by hand, program and C, so that the host build is tested without the compiler."""

from __future__ import annotations

from fractions import Fraction

import pytest

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.fixed.program import (
    Assign,
    Binary,
    Const,
    Define,
    Each,
    Function,
    ListPort,
    Local,
    Port,
    Program,
    ReadField,
    ReadPort,
    ReadState,
    SetOutput,
    SetState,
    StatePort,
    StatusBit,
)
from fuzzyspec.model.units import ONE
from fuzzyspec.model.variable import Raw, Variable

HEADER = b"""\
#include <stdint.h>
typedef uint16_t sums_status_t;
typedef struct { uint8_t value; } sums_item_t;
typedef struct { int16_t offset; const sums_item_t *items; uint8_t items_count; } sums_input_t;
typedef struct { uint16_t total; } sums_output_t;
typedef struct { uint16_t total; } sums_state_t;
void sums_init(sums_state_t *state);
sums_status_t sums_step(sums_state_t *state, const sums_input_t *in, sums_output_t *out);
uint16_t sums_selftest(void);
"""

SOURCE = b"""\
#include "sums.h"
void sums_init(sums_state_t *state)
{
    state->total = 7u;
}
sums_status_t sums_step(sums_state_t *state, const sums_input_t *in, sums_output_t *out)
{
    uint8_t count = in->items_count;
    uint32_t total = (uint32_t)(in->offset + 1000);
    sums_status_t status = 0u;
    uint8_t i;
    if (count > 3u) {
        count = 3u;
        status = 1u;
    }
    for (i = 0u; i < count; ++i) {
        total += in->items[i].value;
    }
    out->total = (uint16_t)((total + state->total) & 1023u);
    state->total = (uint16_t)(total & 255u);
    return status;
}
"""

SELFTEST = b"""\
#include "sums.h"
uint16_t sums_selftest(void)
{
    return 0u;
}
"""


def _variable(name: str) -> Variable:
    raw = Raw("uint16", Fraction(1), Fraction(0), 0, 1023)
    return Variable(name, Fraction(0), Fraction(1023), ONE, raw, Span(0, 0))


def _modulo(value: Binary | Local, n: int) -> Binary:
    whole = Binary("/", value, Const(n), 0, 4095)
    return Binary("-", value, Binary("*", whole, Const(n), 0, 65535), 0, n - 1)


@pytest.fixture
def sums() -> Program:
    """``total = (offset + 1000 + the first three items + the last total mod 256) mod 1024``."""
    total = Local("total", "uint32", 0, 40000)
    item = ReadField("items", "value", "uint8", 0, 255)
    start = Binary("+", ReadPort("offset", "int16", -1000, 1000), Const(1000), 0, 2000)
    all_ = Binary("+", total, ReadState("total", "uint16", 0, 255), 0, 65535)
    items = ListPort("items", 3, (Port("value", "uint8", 0, 255, _variable("value")),))
    step = Function(
        name="sums",
        kind="system",
        inputs=(Port("offset", "int16", -1000, 1000, _variable("offset")), items),
        outputs=(Port("total", "uint16", 0, 1023, _variable("total")),),
        state=(StatePort("total", "uint16", 7, 0, 255, _variable("total")),),
        nested=(),
        status=(StatusBit("OVERRUN_ITEMS", "more than 3 items"),),
        tables=(),
        behaviors=(),
        body=(
            Define(total, start, False),
            Each("items", Local("i", "uint8", 0, 2), (Assign(total, Binary("+", total, item, 0, 40000)),)),
            SetOutput("total", _modulo(all_, 1024)),
            SetState("total", _modulo(total, 256)),
        ),
    )
    return Program("sums", (step,))


@pytest.fixture
def sums_files() -> dict[str, bytes]:
    """The C of ``sums``."""
    return {"sums.h": HEADER, "sums.c": SOURCE, "sums_selftest.c": SELFTEST}
