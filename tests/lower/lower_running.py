"""Runs pieces of lowered code as a function of their own, every value held against its interval."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from fuzzyspec.fixed.build import LIMITS, UINT32_MAX
from fuzzyspec.fixed.program import (
    CType,
    Define,
    Expr,
    Function,
    Local,
    Port,
    Program,
    ReadPort,
    SetOutput,
    Stmt,
    Table,
)
from fuzzyspec.fixed.run import run

Ints = npt.NDArray[np.int64]


def given(name: str, ctype: CType, lo: int | None = None, hi: int | None = None) -> tuple[Define, Local]:
    """A local that is read from an input of that name, known to lie in ``lo .. hi``."""
    low, high = LIMITS[ctype]
    low, high = low if lo is None else lo, high if hi is None else hi
    local = Local(name, ctype, low, high)
    return Define(local, ReadPort(name, ctype, low, high), True), local


def outcome(
    body: Sequence[Stmt], results: Mapping[str, Expr], inputs: Mapping[str, npt.ArrayLike], tables: Sequence[Table] = ()
) -> dict[str, Ints]:
    """The results after the statements, for arrays of inputs. Results are bound, so their intervals are checked too."""
    ports = tuple(Port(name, "int32", *LIMITS["int32"], None) for name in inputs)
    steps: list[Stmt] = list(body)
    for name, value in results.items():
        bound = Local(f"result_{name}", "int32" if value.lo < 0 else "uint32", value.lo, value.hi)
        steps += [Define(bound, value, True), SetOutput(name, bound)]
    outputs = tuple(Port(name, "uint32", 0, UINT32_MAX, None) for name in results)
    function = Function("piece", "controller", ports, outputs, (), (), (), tuple(tables), (), tuple(steps))
    arrays = {k: np.asarray(v, dtype=np.int64) for k, v in inputs.items()}
    return run(Program("p", (function,)), "piece", arrays, checked=True).outputs
