"""What a reader of the header is told of signals and bounds, in plain words."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from fuzzyspec.diagnostics.numerals import exact, upper
from fuzzyspec.fixed.certificate import Band, Certificate, OutputBound
from fuzzyspec.fixed.program import Port, StatePort
from fuzzyspec.model.variable import Variable


def quantity(value: str, variable: Variable) -> str:
    """``0.5 m/s``; without a unit the number alone."""
    symbol = variable.unit.symbol
    return f"{value} {symbol}" if symbol else value


def signal(port: Port | StatePort) -> str:
    """``0 .. 8 m, raw 0 .. 32768, 1/4096 m a count``."""
    variable = port.variable
    if variable is None:
        return f"{port.lo} .. {port.hi}, a code"
    span = quantity(f"{exact(variable.lo)} .. {exact(variable.hi)}", variable)
    count = quantity(exact(variable.raw.step), variable)
    text = f"{span}, raw {port.lo} .. {port.hi}, {count} a count"
    origin = variable.raw.origin
    return f"{text}, raw 0 is {quantity(exact(origin), variable)}" if origin != 0 else text


def bound(found: OutputBound, variable: Variable | None) -> str:
    """``error <= 0.00013 m/s, 0.019 % of range``, or why there is none."""
    if found.error is None:
        return f"no certified error: {found.reason}"
    error = upper(found.error)
    text = f"certified error {quantity(error, variable) if variable is not None else error}"
    return text if found.percent_of_range is None else f"{text}, {upper(found.percent_of_range)} % of range"


def band(found: Band) -> str:
    """``front is taken: both meanings agree beyond 0.0021``."""
    return f"{found.what} [{found.key}]: within {upper(found.width)}"


def interval(lo: Fraction, hi: Fraction, variable: Variable) -> str:
    """Two ends with at most six places, the lower rounded down and the upper up."""
    scale = 10**6
    low = Fraction((lo * scale).__floor__(), scale)
    high = Fraction((hi * scale).__ceil__(), scale)
    return quantity(f"{exact(low)} .. {exact(high)}", variable)


def certificate_lines(
    certificate: Certificate | None, ports: tuple[Port, ...], reachable: Mapping[str, str]
) -> list[str]:
    """A line an output, and one for each decision on a computed value."""
    lines: list[str] = []
    found = {} if certificate is None else {o.output: o for o in certificate.outputs}
    for port in ports:
        told = [bound(found[port.name], port.variable)] if port.name in found and port.variable is not None else []
        if port.name in reachable:
            told.append(f"reaches {reachable[port.name]} while a rule fires")
        if told:
            lines.append(f"{port.name}: {'; '.join(told)}")
    lines.extend(_origins([o for o in found.values() if o.error is not None]))
    if certificate is not None and certificate.bands:
        lines.append("decisions on computed values, where the exact meaning may decide otherwise only this near a tie:")
        lines.extend(f"  {band(b)}" for b in certificate.bands)
    return lines


def _origins(bounds: list[OutputBound]) -> list[str]:
    """Where the errors come from; once where all outputs say the same."""
    reasons = list(dict.fromkeys(o.reason for o in bounds if o.reason))
    if len(reasons) == 1:
        return [f"errors by origin: {reasons[0]}"]
    return [f"errors of {o.output} by origin: {o.reason}" for o in bounds if o.reason]
