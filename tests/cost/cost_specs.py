"""Specs and stand-in C for the tests of ``cost``."""

from __future__ import annotations

from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.machines.machine import emulator_of
from fuzzyspec.machines.toolchains import TARGETS, CrossCompiler, Kind, find_compiler
from tests.conftest import required_package, required_tool, without

PLAIN = """\
module plain
controller fan {
    input x in [0, 10] { partition low high }
    input y in [-5, 5] { partition low high }
    output z in [0, 1] { partition off on }
    table z by x, y {
              low  high
        low:  off  off
        high: off  on
    }
}
"""

KEEPING = """\
module keeping
controller hold {
    input  x in [-1, 1] { term low = ramp_down(-0.8, -0.3)  term high = ramp_up(0.2, 0.9) }
    output y in [0, 5] V { singletons A B  otherwise hold initial 2 V }
    infer { defuzzify = weighted_average }
    rules {
        if x is low then y is A
        if x is high then y is B
    }
}
system both {
    input x in [-1, 1]
    input parts[3] { size in [0, 2] m, kind in [0, 9] }
    let a = hold(x: x)
    output y = a.y
    output big = max(p.size for p in parts if p.kind >= 4.5, otherwise 0 m)
}
"""


def compiler_for(target: str, kind: Kind | None = None) -> CrossCompiler:
    """The compiler, or the test is skipped; likewise where the target's emulator is not here."""
    try:
        found = find_compiler(TARGETS[target], kind)
    except MissingTool as error:
        without(str(error))
    if emulator_of(found) == "simavr":
        required_tool("simavr")
    else:
        required_package(emulator_of(found))
    required_package("elftools")
    return found


def stand_in(body: str) -> dict[str, bytes]:
    """C with PLAIN's interface and a body of our own (``in`` and ``out`` as always, tables before it)."""
    tables, _, statements = body.rpartition("@")
    return {
        "plain.h": b"""\
#include <stdint.h>
typedef uint16_t plain_status_t;
typedef struct { uint16_t x; int16_t y; } plain_fan_input_t;
typedef struct { uint16_t z; } plain_fan_output_t;
plain_status_t plain_fan(const plain_fan_input_t *in, plain_fan_output_t *out);
""",
        "plain.c": f"""\
#include "plain.h"
{tables}
plain_status_t plain_fan(const plain_fan_input_t *in, plain_fan_output_t *out)
{{
    {statements}
}}
""".encode(),
    }
