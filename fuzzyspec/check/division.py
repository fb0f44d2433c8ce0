"""Quotients: which divisors are allowed, and what settles 0/0."""

from __future__ import annotations

from fractions import Fraction
from typing import Protocol

from fuzzyspec.check.arithmetic import Value, common_dims, number, scaled
from fuzzyspec.check.findings import Report
from fuzzyspec.check.quantities import interval
from fuzzyspec.check.units import Dims, coherent, times
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Span
from fuzzyspec.model.interval import Interval, Intervals
from fuzzyspec.model.system import Div
from fuzzyspec.syntax import tree


class Scope(Protocol):
    """What a quotient needs to know of its surroundings."""

    def key(self, kind: str) -> str: ...

    @property
    def intervals(self) -> Intervals: ...


def divided(
    left: Value,
    right: Value,
    otherwise: Value | None,
    place: Interval | None,
    span: Span,
    scope: Scope,
    report: Report,
) -> Value | None:
    """The quotient; ``place`` is the range that it goes straight into, if any.

    A divisor's range must not hold both signs. One that can be 0 needs a place to saturate into, and where the
    dividend can be 0 at the same time, an ``otherwise``.
    """
    of = times(left.dims, right.dims, -1)
    if otherwise is not None:
        quotient = number(Fraction(0), of, span)
        if common_dims((quotient, otherwise), "cannot choose between", report) is None:
            return None
    if (c := right.constant) is not None:
        if c == 0:
            report(Diagnostic("FZ434", "this divides by 0", right.span, label="always 0"))
            return None
        if otherwise is not None:
            _needless(otherwise, "the divisor is never 0", report)
        return scaled(left, 1 / c, of, span, left.bare and right.bare)
    divisor = scope.intervals.of(right.expr)
    dividend = scope.intervals.of(left.expr)
    if divisor[0] < 0 < divisor[1]:
        report(
            Diagnostic(
                "FZ430",
                "the divisor can have both signs",
                right.span,
                label=f"ranges over {_range(divisor, right.dims)}",
                help="divide by its size, as in `x / max(abs(d), ..)`, or choose a range on one side of 0",
            )
        )
        return None
    if not divisor[0] <= 0 <= divisor[1]:
        if otherwise is not None:
            _needless(otherwise, f"the divisor lies in {_range(divisor, right.dims)}, so it is never 0", report)
        return Value(Div(left.expr, right.expr, None, None, scope.key("ratio"), span), of, span)
    if divisor[0] == divisor[1]:
        report(Diagnostic("FZ434", "this divides by 0", right.span, label="always 0"))
        return None
    settled = _settled(dividend, divisor, left, right, otherwise, span, report)
    if place is None:
        report(
            Diagnostic(
                "FZ431",
                "the divisor can be 0, and the quotient has no range to end at",
                right.span,
                label=f"ranges over {_range(divisor, right.dims)}",
                help="put the quotient straight into a controller's input, a `clamp(a / b, lo, hi)` or an output "
                "with a range, or keep the divisor away from 0: `max(b, ..)`",
            )
        )
        return None
    if not settled:
        return None
    needed = otherwise is not None and dividend[0] <= 0 <= dividend[1]
    fallback = otherwise.expr if needed and otherwise is not None else None
    return Value(Div(left.expr, right.expr, place, fallback, scope.key("ratio"), span), of, span)


def _settled(
    dividend: Interval,
    divisor: Interval,
    left: Value,
    right: Value,
    otherwise: Value | None,
    span: Span,
    report: Report,
) -> bool:
    """Whether 0/0 either cannot be or is settled; reports where not."""
    possible = dividend[0] <= 0 <= dividend[1]
    if possible and otherwise is None:
        report(
            Diagnostic(
                "FZ432",
                "this quotient can be 0/0",
                span,
                label=f"{_range(dividend, left.dims)} divided by {_range(divisor, right.dims)}",
                help="say what it is then: `a / b otherwise ..`",
            )
        )
        return False
    if not possible and otherwise is not None:
        _needless(otherwise, f"the dividend lies in {_range(dividend, left.dims)}, so it is never 0", report)
    return True


def not_a_quotient(expr: tree.Otherwise, report: Report) -> None:
    """``otherwise`` settles the 0/0 of one quotient, nothing else."""
    if isinstance(expr.value, tree.Fold):
        way_out = "inside a fold it is the last part: `max(.. for o in list, otherwise ..)`"
    else:
        way_out = "write it right after the quotient: `a / b otherwise ..`, in parentheses where more follows"
    report(
        Diagnostic(
            "FZ253",
            "this `otherwise` does not follow a quotient",
            expr.fallback.span,
            label="settles nothing",
            help=way_out,
        )
    )


def _needless(otherwise: Value, why: str, report: Report) -> None:
    report(
        Diagnostic(
            "FZ433",
            "this `otherwise` is never used",
            otherwise.span,
            label=why,
            help="drop it",
            severity="warning",
        )
    )


def _range(of: Interval, dims: Dims) -> str:
    return interval(*of, coherent(dims))
