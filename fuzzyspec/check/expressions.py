"""Typed expressions: syntax trees with names become model expressions in coherent units.

One walk serves constants (only params are in scope) and systems; what a name, a call or a fold means is the scope's
affair. Where a part cannot be typed it has been reported, and None stands for it, so nothing is reported twice.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Protocol, assert_never

from fuzzyspec.check import arithmetic
from fuzzyspec.check.arithmetic import Value, common_dims, fitted, number
from fuzzyspec.check.conditions import Conditions
from fuzzyspec.check.division import divided, not_a_quotient
from fuzzyspec.check.findings import Findings
from fuzzyspec.check.similar import hint
from fuzzyspec.check.units import PI, Units, describe, exponent, times
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Span
from fuzzyspec.model.interval import Interval, Intervals
from fuzzyspec.model.system import (
    Abs,
    Clamp,
    Const,
    Greatest,
    If,
    Least,
    Test,
)
from fuzzyspec.model.units import Unit
from fuzzyspec.syntax import tree

FUNCTIONS = ("min", "max", "abs", "clamp", "to_rad", "to_deg")
FOLDS = ("max", "min", "sum", "count")

NOWHERE: Interval = (Fraction(0), Fraction(0))
"""The place of a value that is looked at for its own faults only, because where it should go is wrong itself."""


class Scope(Protocol):
    """What names mean where an expression stands."""

    def name(self, ref: tree.Ref) -> Value | None: ...

    def call(self, call: tree.Call) -> Value | None:
        """Of a controller (the functions are ours)."""

    def fold(self, fold: tree.Fold, expected: Unit | None) -> Value | None: ...

    def callables(self) -> Sequence[str]:
        """Names of controllers, to suggest."""

    def key(self, kind: str) -> str:
        """A fresh key for a decision."""

    @property
    def intervals(self) -> Intervals: ...


class Expressions:
    """Types expressions in a scope."""

    def __init__(self, scope: Scope, units: Units, findings: Findings) -> None:
        self._scope = scope
        self._units = units
        self._findings = findings

    # --- numbers -----------------------------------------------------------------------------

    def number(self, expr: tree.Expr, expected: Unit | None = None, place: Interval | None = None) -> Value | None:
        """Type a number.

        ``expected`` is the unit that a bare number takes where it stands for the whole value; ``place`` the range
        (coherent) that the value goes straight into, which is what allows a divisor that can be 0.
        """
        match expr:
            case tree.Number():
                return self._literal(expr)
            case tree.Ref():
                return self._scope.name(expr)
            case tree.Unary():
                operand = self.number(expr.operand)
                return None if operand is None else arithmetic.negated(operand, expr.span)
            case tree.Binary():
                return self._binary(expr, None, expected, place)
            case tree.Otherwise():
                return self._otherwise(expr, expected, place)
            case tree.Conditional():
                return self._conditional(expr, expected, place)
            case tree.Call():
                return self._call(expr)
            case tree.Fold():
                return self._scope.fold(expr, expected)
            case tree.Compare() | tree.InRange() | tree.Logic():
                self._report(
                    "FZ247",
                    "a condition stands where a number is needed",
                    expr.span,
                    "this is true or false",
                    "choose between two numbers: `a if condition else b`",
                )
                return None
            case _:
                assert_never(expr)

    def placed(
        self, expr: tree.Expr, unit: Unit, where: Span, what: str, place: Interval | None = None
    ) -> Value | None:
        """Type a number that goes into a place with a unit."""
        value = self.number(expr, unit, place)
        return None if value is None else fitted(value, unit, where, what, self._findings.report)

    def _literal(self, expr: tree.Number) -> Value | None:
        if expr.unit is None:
            return number(expr.value, (), expr.span, bare=True)
        unit = self._units.resolve(expr.unit, self._findings.report)
        return None if unit is None else number(unit.to_coherent(expr.value), unit.dims, expr.span)

    def _binary(
        self, expr: tree.Binary, fallback: tree.Expr | None, expected: Unit | None, place: Interval | None
    ) -> Value | None:
        left, right = self.number(expr.left), self.number(expr.right)
        settled = None if fallback is None else self.number(fallback, expected)
        if left is None or right is None or (fallback is not None and settled is None):
            return None
        match expr.op:
            case "+" | "-":
                return arithmetic.summed(left, right, expr.op == "-", expr.span, self._findings.report)
            case "*":
                return arithmetic.multiplied(left, right, expr.span)
            case "/":
                if settled is not None and expected is not None and settled.bare:
                    settled = fitted(settled, expected, settled.span, "", self._findings.report)
                return divided(left, right, settled, place, expr.span, self._scope, self._findings.report)
            case _:
                assert_never(expr.op)

    def _otherwise(self, expr: tree.Otherwise, expected: Unit | None, place: Interval | None) -> Value | None:
        if isinstance(expr.value, tree.Binary) and expr.value.op == "/":
            return self._binary(expr.value, expr.fallback, expected, place)
        self.number(expr.value, expected, place)
        self.number(expr.fallback, expected)
        not_a_quotient(expr, self._findings.report)
        return None

    def _conditional(self, expr: tree.Conditional, expected: Unit | None, place: Interval | None) -> Value | None:
        test = self.test(expr.test)
        branches = [self.number(e, expected, place) for e in (expr.then, expr.other)]
        then, other = (self._bare_in(b, expected) for b in branches)
        if test is None or then is None or other is None:
            return None
        of = common_dims((then, other), "cannot choose between", self._findings.report)
        return None if of is None else Value(If(test, then.expr, other.expr), of, expr.span)

    def _bare_in(self, value: Value | None, expected: Unit | None) -> Value | None:
        """A bare branch of a choice takes the unit of the place that the choice goes into."""
        if value is None or expected is None or not value.bare:
            return value
        return fitted(value, expected, value.span, "", self._findings.report)

    # --- functions ---------------------------------------------------------------------------

    def _call(self, expr: tree.Call) -> Value | None:
        name = expr.callee.text
        if name not in FUNCTIONS:
            if name in self._scope.callables():
                return self._scope.call(expr)
            self._report_unknown(expr)
            return None
        if expr.field is not None:
            self._report("FZ203", f"`{name}(..)` is a number and has no fields", expr.field.span, "no such field")
            return None
        named = [a for a in expr.arguments if a.name is not None]
        for a in named:
            self._report("FZ216", f"`{name}` takes its arguments by position", a.span, "drop the name")
        values = [self._argument(name, i, a.value) for i, a in enumerate(expr.arguments)]
        if named:
            return None
        if not self._right_count(expr):
            return None
        known = [v for v in values if v is not None]
        return self._apply(name, known, expr) if len(known) == len(values) else None

    def _argument(self, function: str, index: int, expr: tree.Expr) -> Value | None:
        # The operand of a clamp goes straight into a range, which is known once its ends are.
        if function == "clamp" and index == 0:
            return number(Fraction(0), (), expr.span, bare=True)
        return self.number(expr)

    def _right_count(self, expr: tree.Call) -> bool:
        name, given = expr.callee.text, len(expr.arguments)
        wants = {"abs": 1, "to_rad": 1, "to_deg": 1, "clamp": 3}.get(name)
        if given == wants or (wants is None and given >= 2):
            return True
        usage = {"clamp": "clamp(x, lo, hi)", "min": "min(a, b)", "max": "max(a, b)"}.get(name, f"{name}(x)")
        wanted = "two or more arguments" if wants is None else f"{wants} argument{'s' if wants > 1 else ''}"
        self._report("FZ217", f"`{name}` takes {wanted}, not {given}", expr.span, "", f"write `{usage}`")
        return False

    def _apply(self, name: str, values: list[Value], expr: tree.Call) -> Value | None:
        match name:
            case "min" | "max":
                return self._extreme(name, values, expr.span)
            case "abs":
                (x,) = values
                c = x.constant
                return replace(x, expr=Abs(x.expr) if c is None else Const(abs(c)), span=expr.span)
            case "clamp":
                return self._clamp(expr, values[1], values[2])
            case _:
                return self._turn(name, values[0], expr.span)

    def _extreme(self, name: str, values: list[Value], span: Span) -> Value | None:
        of = common_dims(values, f"`{name}` cannot compare", self._findings.report)
        if of is None:
            return None
        constants = [c for v in values if (c := v.constant) is not None]
        pick: Callable[[list[Fraction]], Fraction] = min if name == "min" else max
        if len(constants) == len(values):
            return number(pick(constants), of, span, all(v.bare for v in values))
        operands = tuple(v.expr for v in values)
        return Value(Least(operands) if name == "min" else Greatest(operands), of, span)

    def _clamp(self, expr: tree.Call, lo: Value, hi: Value) -> Value | None:
        low, high = lo.constant, hi.constant
        for end, c in ((lo, low), (hi, high)):
            if c is None:
                self._report(
                    "FZ248",
                    "the ends of a `clamp` must be constants",
                    end.span,
                    "this changes at run time",
                    "for ends that move, use `min` and `max`",
                )
        place = (low, high) if low is not None and high is not None and low <= high else None
        operand = self.number(expr.arguments[0].value, None, place)
        if operand is None or low is None or high is None:
            return None
        of = common_dims((operand, lo, hi), "cannot clamp", self._findings.report)
        if of is None:
            return None
        if low > high:
            self._report(
                "FZ401",
                "the ends of this `clamp` are in the wrong order",
                lo.span.to(hi.span),
                "the low end is above the high end",
                "write `clamp(x, lo, hi)`",
            )
            return None
        c = operand.constant
        if c is not None:
            return number(min(max(c, low), high), of, expr.span, operand.bare and lo.bare and hi.bare)
        return Value(Clamp(operand.expr, low, high), of, expr.span)

    def _turn(self, name: str, value: Value, span: Span) -> Value | None:
        if name == "to_deg":
            if exponent(value.dims, "deg"):
                self._report(
                    "FZ223",
                    "`to_deg` gets a value that is in degrees already",
                    value.span,
                    f"this is {describe(value.dims)}",
                )
                return None
            return arithmetic.scaled(value, 180 / PI, times(value.dims, (("deg", 1),)), span)
        if exponent(value.dims, "deg") != 1:
            self._report(
                "FZ223", "`to_rad` gets a value that is not in degrees", value.span, f"this is {describe(value.dims)}"
            )
            return None
        return arithmetic.scaled(value, PI / 180, times(value.dims, (("deg", 1),), -1), span)

    def _report_unknown(self, expr: tree.Call) -> None:
        name = expr.callee
        known = [*self._scope.callables(), *FUNCTIONS]
        for a in expr.arguments:
            self.number(a.value, place=NOWHERE)
        if name.text in FOLDS:
            self._report(
                "FZ252",
                f"`{name.text}` goes over a list",
                expr.span,
                "nothing to go over",
                f"write `{name.text}({'o' if name.text == 'count' else 'o.field'} for o in list)`",
            )
            return
        self._report(
            "FZ202",
            f"unknown controller or function `{name.text}`",
            name.span,
            "not defined in this file",
            hint(name.text, known, "controllers and functions"),
        )

    # --- conditions --------------------------------------------------------------------------

    def test(self, expr: tree.Expr) -> Test | None:
        """Type a condition."""
        return Conditions(self.number, self._scope, self._units, self._findings).test(expr)

    # -----------------------------------------------------------------------------------------

    def _report(self, code: str, message: str, span: Span, label: str = "", help: str | None = None) -> None:
        self._findings.report(Diagnostic(code, message, span, label=label, help=help))
