"""Units: the built-in ones, a file's own, and their algebra.

A unit is a product of powers of the base dimensions m, kg, s, A, K and deg with an exact scale. rad is 1, deg is a
dimension of its own, so that mixing the two is found; ``to_rad`` goes from one to the other.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from fuzzyspec.check.findings import Report
from fuzzyspec.check.names import too_early
from fuzzyspec.check.similar import listing, nearest
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Span
from fuzzyspec.model.units import ONE, Unit
from fuzzyspec.syntax import tree

Dims = tuple[tuple[str, int], ...]

PI = Fraction(245850922, 78256779)
"""The rational that stands for pi: a convergent, 7.8e-17 below it. Both meanings use it."""

TURN_PER_MINUTE = 2 * PI / 60


def dims(**exponents: int) -> Dims:
    """Dimensions from exponents, in the form that Unit keeps them."""
    return tuple(sorted((name, e) for name, e in exponents.items() if e))


def times(left: Dims, right: Dims, sign: int = 1) -> Dims:
    """Dimensions of a product, or with ``sign=-1`` of a quotient."""
    exponents = dict(left)
    for name, e in right:
        exponents[name] = exponents.get(name, 0) + sign * e
    return dims(**exponents)


def exponent(of: Dims, name: str) -> int:
    """The exponent of one base dimension."""
    return dict(of).get(name, 0)


BUILT_IN: dict[str, Unit] = {
    u.symbol: u
    for u in (
        Unit("m", dims(m=1)),
        Unit("mm", dims(m=1), Fraction(1, 1000)),
        Unit("cm", dims(m=1), Fraction(1, 100)),
        Unit("km", dims(m=1), Fraction(1000)),
        Unit("kg", dims(kg=1)),
        Unit("s", dims(s=1)),
        Unit("ms", dims(s=1), Fraction(1, 1000)),
        Unit("us", dims(s=1), Fraction(1, 1000000)),
        Unit("min", dims(s=1), Fraction(60)),
        Unit("A", dims(A=1)),
        Unit("K", dims(K=1)),
        Unit("degC", dims(K=1), Fraction(1), Fraction(27315, 100)),
        Unit("rad"),
        Unit("deg", dims(deg=1)),
        Unit("rpm", dims(s=-1), TURN_PER_MINUTE),
        Unit("%", (), Fraction(1, 100)),
        Unit("Hz", dims(s=-1)),
        Unit("N", dims(kg=1, m=1, s=-2)),
        Unit("Pa", dims(kg=1, m=-1, s=-2)),
        Unit("W", dims(kg=1, m=2, s=-3)),
        Unit("V", dims(kg=1, m=2, s=-3, A=-1)),
    )
}


def written(factors: tuple[tuple[str, int], ...]) -> str:
    """``(m, 1) (s, -2)`` as ``m/s^2``."""

    def power(symbol: str, e: int) -> str:
        return symbol if e == 1 else f"{symbol}^{e}"

    above = "*".join(power(s, e) for s, e in factors if e > 0)
    below = "".join("/" + power(s, -e) for s, e in factors if e < 0)
    return (above or "1") + below if above or below else ""


_DERIVED = {
    u.dims: u.symbol for u in BUILT_IN.values() if u.scale == 1 and not u.offset and u.symbol not in ("Hz", "rad")
}


def coherent(of: Dims) -> Unit:
    """The unit in which expressions of these dimensions are computed: m, m/s, N .."""
    return Unit(_DERIVED.get(of) or written(of), of)


def describe(of: Dims) -> str:
    """Dimensions in a sentence: ``in m/s`` or ``a plain number``."""
    return f"in {coherent(of).symbol}" if of else "a plain number"


_SPELT_OUT = {
    "meter": "m", "metre": "m", "second": "s", "sec": "s", "minute": "min", "degree": "deg", "radian": "rad",
    "percent": "%", "volt": "V", "watt": "W", "newton": "N", "kelvin": "K", "celsiu": "degC", "c": "degC",
    "amp": "A", "ampere": "A", "hertz": "Hz", "pascal": "Pa", "centimeter": "cm", "millimeter": "mm",
    "kilometer": "km", "millisecond": "ms",
}  # fmt: skip


class Units:
    """The units that a file knows: the built-in ones and those it declares."""

    def __init__(self) -> None:
        self._known = dict(BUILT_IN)
        self._broken: set[str] = set()
        self.later: dict[str, Span] = {}
        """Units that the file declares further down."""

    def __contains__(self, symbol: str) -> bool:
        return symbol in self._known

    def extended(self, more: Iterable[Unit]) -> Units:
        """These units and some that are known in one place only."""
        extended = Units()
        extended._known = self._known | {u.symbol: u for u in more}
        extended._broken = self._broken
        extended.later = self.later
        return extended

    def add(self, unit: Unit) -> None:
        self._known[unit.symbol] = unit

    def add_broken(self, symbol: str) -> None:
        """A unit whose declaration failed: using it fails silently."""
        self._broken.add(symbol)

    def resolve(self, expr: tree.UnitExpr, report: Report) -> Unit | None:
        """The unit that was written, or None with a diagnostic for every symbol that is unknown."""
        of: Dims = ()
        scale = Fraction(1)
        good = True
        for symbol, e in expr.factors:
            if symbol == "1":
                continue
            unit = self._known.get(symbol)
            if unit is None:
                good = False
                if symbol in self.later:
                    report(too_early("unit", symbol, expr.span, self.later[symbol]))
                elif symbol not in self._broken:
                    self._unknown(symbol, expr, report)
                continue
            if unit.offset:
                if len(expr.factors) == 1 and e == 1:
                    return unit
                good = False
                self._affine(symbol, expr, report)
                continue
            scale *= unit.scale**e
            for _ in range(abs(e)):
                of = times(of, unit.dims, 1 if e > 0 else -1)
        if not good:
            return None
        return Unit(written(expr.factors), of, scale) if expr.factors else ONE

    def _unknown(self, symbol: str, expr: tree.UnitExpr, report: Report) -> None:
        report(
            Diagnostic(
                "FZ204",
                f"unknown unit `{symbol}`",
                expr.span,
                label="not a unit that is built in or declared above",
                help=self._way_out(symbol),
            )
        )

    def _way_out(self, symbol: str) -> str:
        near = _SPELT_OUT.get(symbol.lower().rstrip("s")) or nearest(symbol, self._known)
        guess = f"did you mean `{near}`?" if near is not None else f"known units: {listing(self._known, most=99)}."
        return f"{guess} A unit of your own is declared at the top: `unit {symbol} = ..`"

    def _affine(self, symbol: str, expr: tree.UnitExpr, report: Report) -> None:
        report(
            Diagnostic(
                "FZ221",
                f"`{symbol}` has its zero elsewhere, so it cannot be part of a product",
                expr.span,
                label="a product with an offset has no meaning",
                help="write `K` here: a difference of 1 degC is 1 K",
            )
        )
