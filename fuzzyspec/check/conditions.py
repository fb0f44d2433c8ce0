"""Conditions: comparisons, chains and sectors, joined by and, or and not."""

from __future__ import annotations

from collections.abc import Callable
from typing import assert_never

from fuzzyspec.check.arithmetic import Value, common_dims, fitted
from fuzzyspec.check.division import Scope
from fuzzyspec.check.findings import Findings
from fuzzyspec.check.quantities import interval
from fuzzyspec.check.units import Units, coherent
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Span
from fuzzyspec.model.interval import Interval
from fuzzyspec.model.system import Both, Compare, CompareOp, Either, Neither, Test
from fuzzyspec.syntax import tree

_FLIPPED: dict[CompareOp, CompareOp] = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}
_OPPOSITE: dict[CompareOp, CompareOp] = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}


def always(op: CompareOp, left: Interval, right: Interval) -> bool:
    """Whether a comparison holds wherever its sides may be."""
    match op:
        case "<":
            return left[1] < right[0]
        case "<=":
            return left[1] <= right[0]
        case ">":
            return left[0] > right[1]
        case ">=":
            return left[0] >= right[1]
        case "==":
            return left[0] == left[1] == right[0] == right[1]
        case "!=":
            return left[1] < right[0] or right[1] < left[0]
        case _:
            assert_never(op)


class Conditions:
    """Types conditions; ``number`` types the numbers in them."""

    def __init__(
        self, number: Callable[[tree.Expr], Value | None], scope: Scope, units: Units, findings: Findings
    ) -> None:
        self._number = number
        self._scope = scope
        self._units = units
        self._report = findings.report

    def test(self, expr: tree.Expr) -> Test | None:
        """A condition, or None with a diagnostic."""
        match expr:
            case tree.Compare():
                return self._chain(expr)
            case tree.InRange():
                return self._in_range(expr)
            case tree.Logic():
                return self._logic(expr)
            case _:
                if self._number(expr) is not None:
                    self._say(
                        "FZ247",
                        "a number stands where a condition is needed",
                        expr.span,
                        "this is a number",
                        "compare it, as in `x > 0`",
                    )
                return None

    def _logic(self, expr: tree.Logic) -> Test | None:
        operands = [self.test(o) for o in expr.operands]
        good = tuple(o for o in operands if o is not None)
        if not good or len(good) < len(operands):
            return None
        match expr.op:
            case "and":
                return Both(good)
            case "or":
                return Either(good)
            case "not":
                return Neither(good[0])
            case _:
                assert_never(expr.op)

    def _chain(self, expr: tree.Compare) -> Test | None:
        values = [self._number(o) for o in expr.operands]
        known = [v for v in values if v is not None]
        if len(known) < len(values) or len(known) < 2:
            return None
        pairs = list(zip(expr.ops, known, known[1:], strict=False))
        if any(common_dims((left, right), "cannot compare", self._report) is None for _, left, right in pairs):
            return None
        if len(pairs) == 1:
            self._warn_decided(*pairs[0], expr.span)
        else:
            self._warn_never(pairs, expr.span)
        parts = tuple(self._compare(op, left, right, expr.span) for op, left, right in pairs)
        return parts[0] if len(parts) == 1 else Both(parts)

    def _in_range(self, expr: tree.InRange) -> Test | None:
        value = self._number(expr.value)
        lo, hi = self._number(expr.lo), self._number(expr.hi)
        if expr.unit is not None:
            unit = self._units.resolve(expr.unit, self._report)
            if unit is None:
                return None
            lo, hi = (
                None if end is None else fitted(end, unit, expr.unit.span, "the interval", self._report)
                for end in (lo, hi)
            )
        if value is None or lo is None or hi is None:
            return None
        if common_dims((value, lo, hi), "cannot compare", self._report) is None:
            return None
        low, high = lo.constant, hi.constant
        if low is not None and high is not None and low > high:
            self._say(
                "FZ401",
                "this interval is empty",
                lo.span.to(hi.span),
                "the low end is above the high end",
                "swap the ends",
            )
            return None
        pairs: list[tuple[CompareOp, Value, Value]] = [(">=", value, lo), ("<=", value, hi)]
        self._warn_never(pairs, expr.span)
        return Both(tuple(self._compare(op, left, right, expr.span) for op, left, right in pairs))

    def _compare(self, op: CompareOp, left: Value, right: Value, span: Span) -> Compare:
        """With a literal on the right, whichever side it was written on."""
        if left.constant is not None and right.constant is None:
            op, left, right = _FLIPPED[op], right, left
        return Compare(op, left.expr, right.expr, self._scope.key("test"), span)

    # --- conditions that never change --------------------------------------------------------

    def _warn_never(self, pairs: list[tuple[CompareOp, Value, Value]], span: Span) -> None:
        """A sector may well reach beyond the range at one end, but not lie outside of it."""
        for op, left, right in pairs:
            if self._holds(_OPPOSITE[op], left, right):
                self._warn(False, left, right, span)
                return

    def _warn_decided(self, op: CompareOp, left: Value, right: Value, span: Span) -> None:
        if self._holds(op, left, right):
            self._warn(True, left, right, span)
        elif self._holds(_OPPOSITE[op], left, right):
            self._warn(False, left, right, span)

    def _holds(self, op: CompareOp, left: Value, right: Value) -> bool:
        intervals = self._scope.intervals
        return always(op, intervals.of(left.expr), intervals.of(right.expr))

    def _warn(self, outcome: bool, left: Value, right: Value, span: Span) -> None:
        varies = right if left.constant is not None else left
        unit = coherent(varies.dims)
        self._report(
            Diagnostic(
                "FZ436",
                f"this condition is always {'true' if outcome else 'false'}",
                span,
                label="decided by the declared ranges",
                labels=(Label(varies.span, f"ranges over {interval(*self._scope.intervals.of(varies.expr), unit)}"),),
                help="50 % is 0.5: a number to compare with % needs the unit too" if not varies.dims else None,
                severity="warning",
            )
        )

    def _say(self, code: str, message: str, span: Span, label: str, help: str) -> None:
        self._report(Diagnostic(code, message, span, label=label, help=help))
