"""Operands for the constructors: intervals near every edge of the 32-bit types, and values inside them."""

from __future__ import annotations

import random
from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st

from fuzzyspec.fixed.build import INT32_MIN, UINT32_MAX
from fuzzyspec.fixed.program import Const, Define, Expr, Function, Local, Port, Program, ReadPort, SetOutput, Stmt
from fuzzyspec.fixed.run import run

EDGES = sorted(
    {s * (2**k) + d for k in (0, 1, 7, 8, 15, 16, 24, 30, 31, 32) for s in (-1, 1) for d in (-1, 0, 1)} | {0, 3, 1000}
)


@dataclass(frozen=True)
class Operand:
    """An atom and some of its values, both ends among them."""

    expr: Const | Local
    values: tuple[int, ...]


def numbers(low: int = INT32_MIN, high: int = UINT32_MAX) -> st.SearchStrategy[int]:
    """Any number of the interval, the edges often."""
    edges = [e for e in EDGES if low <= e <= high]
    return st.sampled_from(edges) | st.integers(low, high)


@st.composite
def operands(draw: st.DrawFn, name: str, low: int = INT32_MIN, high: int = UINT32_MAX) -> Operand:
    """A constant or a local whose interval one 32-bit type holds."""
    if draw(st.booleans()) and draw(st.booleans()):
        # -2**31 is left out: its magnitude is no int32, so a sum with it is refused although it would fit.
        value = draw(numbers(max(low, INT32_MIN + 1), high))
        return Operand(Const(value), (value,) * 5)
    lo = draw(numbers(low, high))
    hi = draw(numbers(lo, high if lo >= 0 else min(high, 2**31 - 1)))
    dice = random.Random(draw(st.integers(0, 2**16)))
    inner = (dice.randint(lo, hi) for _ in range(3))
    return Operand(Local(name, "int32" if lo < 0 else "uint32", lo, hi), (lo, hi, *inner))


def computed(node: Expr, left: Operand, right: Operand) -> list[int]:
    """What ``run`` makes of the node for every pair of values, each held against the interval that the node claims."""
    pairs = [(a, b) for a in left.values for b in right.values]
    if isinstance(node, Const):  # folded in Python's integers, of any size: what uses it is refused if it must be
        return [node.value] * len(pairs)
    ports, body, inputs = [], [], {}
    for operand, values in ((left, [a for a, _ in pairs]), (right, [b for _, b in pairs])):
        if isinstance(operand.expr, Local):
            e = operand.expr
            ports.append(Port(e.name, e.ctype, e.lo, e.hi, None))
            body.append(Define(e, ReadPort(e.name, e.ctype, e.lo, e.hi), True))
            inputs[e.name] = np.array(values)
    if not ports:
        ports, inputs = [Port("unused", "uint8", 0, 255, None)], {"unused": np.zeros(len(pairs))}
    result = Local("result", "int32" if node.lo < 0 else "uint32", node.lo, node.hi)
    body += [Define(result, node, True), SetOutput("result", result)]
    return outputs(ports, body, inputs)["result"].tolist()


def outputs(ports: list[Port], body: list[Stmt], inputs: dict[str, object]) -> dict[str, np.ndarray]:
    """Run statements as a function with one output ``result``."""
    result = Port("result", "uint32", 0, UINT32_MAX, None)
    function = Function("f", "controller", tuple(ports), (result,), (), (), (), (), (), tuple(body))
    return run(Program("p", (function,)), "f", inputs, checked=True).outputs
