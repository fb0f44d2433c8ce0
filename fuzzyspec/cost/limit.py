"""The counted limit: how little a controller of fuzzyc's design can take, by counting its operations.

It is a yardstick and not a proof: what the arithmetic needs, as instructions or cycles of a core, without the moves,
constants and branches that a compiler adds. ``docs/cost.md`` has the formula with its reasons.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from math import ceil, factorial, log2

from fuzzyspec.cost.measure import Measured, Record
from fuzzyspec.model.controller import And, Antecedent, CellRules, Controller, Input, Is, Not, Or, Output
from fuzzyspec.model.system import System

Counts = dict[str, float]


@dataclass(frozen=True, slots=True)
class Prices:
    """What an operation takes on a core: ``load`` of a raw or ``store`` of a result, ``test`` (compare and branch),
    ``add`` (or subtract, combine, shift by a few places), ``multiply`` (16 by 16 to 32 bits, its sum with a term
    where the core adds in one), ``look`` (a table's entry), ``divide`` (a 16-bit quotient), ``spill`` (a value that
    finds no register: stored and loaded) and ``call`` (of the step itself). ``registers`` hold values."""

    load: int
    store: int
    test: int
    add: int
    multiply: int
    look: int
    divide: int
    spill: int
    call: int
    registers: int


PRICES: Mapping[str, Prices] = {
    "cortex-m0plus": Prices(1, 1, 2, 1, 2, 2, 12, 2, 3, 8),
    "cortex-m4": Prices(1, 1, 2, 1, 1, 1, 3, 2, 3, 12),
    "cortex-m7": Prices(1, 1, 2, 1, 1, 1, 3, 2, 3, 12),
    "rv32imc": Prices(1, 1, 1, 1, 1, 2, 3, 2, 3, 24),
    "avr": Prices(4, 4, 3, 4, 20, 8, 100, 8, 8, 12),
}
"""Instructions; on AVR cycles, of values of 16 bits and sums of 32."""


def limit(controller: Controller, target: str) -> int:
    """What a call takes at the least, in instructions of the target, or in cycles on AVR."""
    prices = PRICES[target]
    counts: Counts = {}
    for part in _parts(controller):
        for name, times in part.items():
            counts[name] = counts.get(name, 0) + times
    beyond = max(0.0, counts.pop("values", 0) - prices.registers)
    price: Mapping[str, int] = asdict(prices)
    return ceil(prices.call + beyond * prices.spill + sum(price[name] * n for name, n in counts.items()))


def with_limits(measured: Measured, functions: Mapping[str, Controller | System]) -> Measured:
    """The records with the limits of the controllers; a system's crisp arithmetic is not counted."""
    return replace(measured, records=tuple(_limited(r, functions[r.function]) for r in measured.records))


def _limited(record: Record, function: Controller | System) -> Record:
    if not isinstance(function, Controller):
        return record
    found = limit(function, record.target)
    if record.target == "avr":
        return replace(record, cycles_limit=found)
    return replace(record, instructions_limit=found)


def _parts(controller: Controller) -> Iterator[Counts]:
    """The operations, step by step."""
    for given in controller.inputs:
        yield _placed(given)
    cells = controller.cells
    multilinear = controller.infer.and_ == "product" and controller.infer.defuzzify == "weighted_average"
    if cells is not None and multilinear and all(i.peaks is not None for i in controller.inputs):
        yield from _interpolated(len(controller.inputs), len(controller.outputs))
        return
    levels = len(controller.sentences)
    if cells is not None:
        yield _fired(cells)
        levels = len(cells.shape) + 1
    for rule in controller.sentences:
        yield {"test": 2 * (_literals(rule.antecedent) - 1) + len(rule.consequents)}
    for output in controller.outputs:
        yield _defuzzified(output, levels, looked_up=cells is not None and len(cells.shape) > 2)


def _placed(given: Input) -> Counts:
    """Load a raw, saturate it, find its piece among the terms', and scale it to a degree."""
    raw = given.variable.raw
    sides = (raw.lo > _LEAST[raw.ctype]) + (raw.hi < _MOST[raw.ctype])
    if not sides:  # a mask and a shift may do
        return {"load": 1, "add": 2, "values": 1}
    pieces = max(1, len(given.terms) - 1)
    return {"load": 1, "test": sides + ceil(log2(pieces)), "add": 2, "multiply": 1, "values": 1}


_LEAST = {"uint8": 0, "int8": -(2**7), "uint16": 0, "int16": -(2**15)}
_MOST = {"uint8": 2**8 - 1, "int8": 2**7 - 1, "uint16": 2**16 - 1, "int16": 2**15 - 1}


def _fired(cells: CellRules) -> Counts:
    """Which degree of each input is the smaller, their order, and the consequents of the 2^n cells.

    With one or two inputs a jump leads to code of the block of cells; from three on that is too much code, and every
    cell's consequents are looked up and added to those of its level.
    """
    n = len(cells.shape)
    counts: Counts = {"test": n + ceil(log2(factorial(n))), "add": n}
    if n <= 2:
        return counts | {"look": 1}
    return counts | {"look": 2**n, "add": n + 2 * 2**n, "values": 2 * n + 2}


def _literals(antecedent: Antecedent) -> int:
    match antecedent:
        case Is(_, terms):
            return len(terms)
        case Not(operand):
            return _literals(operand)
        case And(operands) | Or(operands):
            return sum(_literals(o) for o in operands)


def _interpolated(n: int, outputs: int) -> Iterator[Counts]:
    """Multilinear interpolation between the 2^n corners: each step halves them. Two outputs share a word, and so the
    first step, which is half of all."""
    corners = 2**n
    words = ceil(outputs / 2)
    steps = words * corners / 2 + outputs * (corners / 2 - 1)
    yield {"look": words * corners, "add": 2 * steps, "multiply": steps, "store": outputs, "values": n}


def _defuzzified(output: Output, levels: int, *, looked_up: bool) -> Counts:
    """Area and moment of what was fired, their quotient, the raw.

    Each of the strengths that may differ adds a polynomial of the second degree to the area and one to the moment,
    with coefficients that stand in the code or, ``looked_up``, go by the set of terms fired so far.
    """
    used = min(levels, len(output.terms))
    counts: Counts = {"multiply": 3 * used + 1, "add": 2 * used + 2, "divide": 1, "store": 1, "values": used}
    return counts | {"look": 3 * used, "add": 3 * used + 2} if looked_up else counts
