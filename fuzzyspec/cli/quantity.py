"""A quantity as typed on the command line: ``0.3``, ``30deg``, ``3 m/s``."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from fuzzyspec.diagnostics.refusal import Refusal

if TYPE_CHECKING:
    from fractions import Fraction

    from fuzzyspec.model.units import Unit
    from fuzzyspec.model.variable import Variable

_QUANTITY = re.compile(r"\s*([+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*\Z", re.DOTALL)


def quantity(text: str, variable: Variable, name: str) -> Fraction:
    """The value in the variable's unit; a bare number is in that unit already. Refusal where it has no meaning."""
    from fractions import Fraction

    match = _QUANTITY.match(text)
    if match is None:
        raise Refusal(f"{name}: `{text}` is no number", f"write {name}=1.5 or {name}={_example(variable)}")
    number, symbol = Fraction(match[1]), match[2]
    if not symbol or symbol == variable.unit.symbol:
        return number
    unit = _unit(symbol)
    if unit is None:
        raise Refusal(f"{name}: unknown unit `{symbol}`", f"write {name}={_example(variable)}")
    if unit.dims != variable.unit.dims:
        raise Refusal(f"{name} is not measured in {symbol}", f"write {name}={_example(variable)}")
    return variable.unit.from_coherent(unit.to_coherent(number))


def _unit(symbol: str) -> Unit | None:
    """A unit as a spec would read it; a file's own units are known to their variables only."""
    from fuzzyspec.check.units import Units
    from fuzzyspec.diagnostics.diagnostic import Source
    from fuzzyspec.syntax import parse, tree

    module, problems = parse(Source("unit", f"module unit\nparam x = 1 {symbol}\n"))
    for item in module.items:
        if not problems and isinstance(item, tree.Param) and isinstance(item.value, tree.Number) and item.value.unit:
            return Units().resolve(item.value.unit, lambda problem: None)
    return None


def _example(variable: Variable) -> str:
    return f"{float(variable.lo + variable.hi) / 2:g}{variable.unit.symbol}"
