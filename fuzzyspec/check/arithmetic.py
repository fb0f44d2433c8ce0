"""Typed values: model expressions with their dimensions, and the unit rules of sums and products.

Constants are folded as they arise, exactly; a constant factor always ends up on the right of its product.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from fuzzyspec.check.findings import Report
from fuzzyspec.check.units import Dims, coherent, describe, exponent, times
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Span
from fuzzyspec.model.system import Add, Const, Expr, Mul, Neg, Sub
from fuzzyspec.model.units import Unit


@dataclass(frozen=True, slots=True)
class Value:
    """An expression in coherent units.

    ``bare`` is a constant made of numbers without a unit: it takes the unit of the place that it is put into.
    """

    expr: Expr
    dims: Dims
    span: Span
    bare: bool = False

    @property
    def constant(self) -> Fraction | None:
        return self.expr.value if isinstance(self.expr, Const) else None

    @property
    def zero(self) -> bool:
        """A bare 0, which fits any unit."""
        return self.bare and self.constant == 0


def number(value: Fraction, of: Dims, span: Span, bare: bool = False) -> Value:
    """A constant."""
    return Value(Const(value), of, span, bare)


def mismatch_help(has: Dims, wants: Dims, bare: bool) -> str | None:
    """The likeliest way out where dimensions differ."""
    if bare and wants:
        return f"give the number a unit, such as `{coherent(wants).symbol}`"
    if exponent(has, "deg") == 1 and times(has, (("deg", 1),), -1) == wants:
        return "turn degrees into radians with `to_rad(..)`"
    if exponent(wants, "deg") == 1 and times(wants, (("deg", 1),), -1) == has:
        return "turn radians into degrees with `to_deg(..)`"
    return None


def common_dims(values: Sequence[Value], what: str, report: Report) -> Dims | None:
    """The dimensions that all values share (a bare 0 fits any), or None with a diagnostic showing both spans."""
    wanted = [v for v in values if not v.zero]
    if not wanted:
        return ()
    first = next((v for v in wanted if not v.bare), wanted[0])
    for v in wanted:
        if v.dims != first.dims:
            left, right = (v, first) if v.span < first.span else (first, v)
            bare = v.bare or first.bare
            has, wants = (v.dims, first.dims) if not v.dims or exponent(v.dims, "deg") else (first.dims, v.dims)
            report(
                Diagnostic(
                    "FZ220",
                    f"{what} a value {describe(left.dims)} and one {describe(right.dims)}".replace(
                        "value a plain", "plain"
                    ).replace("one a plain", "a plain"),
                    right.span,
                    label=f"this is {describe(right.dims)}",
                    labels=(Label(left.span, f"this is {describe(left.dims)}"),),
                    help=mismatch_help(has, wants, bare),
                )
            )
            return None
    return first.dims


def negated(value: Value, span: Span) -> Value:
    """Minus a value."""
    c = value.constant
    return replace(value, expr=Neg(value.expr) if c is None else Const(-c), span=span)


def summed(left: Value, right: Value, subtract: bool, span: Span, report: Report) -> Value | None:
    """Sum or difference; both must have one unit."""
    of = common_dims((left, right), "cannot subtract" if subtract else "cannot add", report)
    if of is None:
        return None
    a, b = left.constant, right.constant
    if a is not None and b is not None:
        return number(a - b if subtract else a + b, of, span, left.bare and right.bare)
    expr = Sub(left.expr, right.expr) if subtract else Add(left.expr, right.expr)
    return Value(expr, of, span)


def scaled(value: Value, factor: Fraction, of: Dims, span: Span, bare: bool = False) -> Value:
    """A value times a constant; neighbouring constant factors become one."""
    match value.expr:
        case Const(value=c):
            return number(c * factor, of, span, bare)
        case Mul(left=left, right=Const(value=c)):
            return Value(left if c * factor == 1 else Mul(left, Const(c * factor)), of, span)
        case expr:
            return Value(expr if factor == 1 else Mul(expr, Const(factor)), of, span)


def multiplied(left: Value, right: Value, span: Span) -> Value:
    """Product."""
    of = times(left.dims, right.dims)
    bare = left.bare and right.bare
    if (c := right.constant) is not None:
        return scaled(left, c, of, span, bare)
    if (c := left.constant) is not None:
        return scaled(right, c, of, span, bare)
    return Value(Mul(left.expr, right.expr), of, span)


def fitted(value: Value, unit: Unit, place: Span, what: str, report: Report) -> Value | None:
    """A value put into a place that has a unit: a bare number takes that unit, anything else must have it."""
    c = value.constant
    if value.bare and c is not None:
        return number(unit.to_coherent(c), unit.dims, value.span)
    if value.dims == unit.dims:
        return value
    wanted = f"in {unit.symbol}" if unit.symbol else describe(unit.dims)
    report(
        Diagnostic(
            "FZ220",
            f"{what} is {wanted}, but gets {_got(value.dims)}",
            value.span,
            label=f"this is {describe(value.dims)}",
            labels=(Label(place, f"this is {wanted}"),),
            help=mismatch_help(value.dims, unit.dims, False),
        )
    )
    return None


def _got(of: Dims) -> str:
    return f"a value {describe(of)}" if of else describe(of)
