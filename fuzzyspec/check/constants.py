"""Constant expressions: numbers, units and params, evaluated exactly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

from fuzzyspec.check.arithmetic import Value
from fuzzyspec.check.expressions import Expressions
from fuzzyspec.check.findings import Findings
from fuzzyspec.check.names import too_early
from fuzzyspec.check.similar import hint
from fuzzyspec.check.units import Units, describe
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Span
from fuzzyspec.model.interval import Intervals
from fuzzyspec.model.units import Unit
from fuzzyspec.syntax import tree

LARGEST = Fraction(10) ** 18
"""A magnitude beyond which (and below whose inverse) a number is taken for a slip."""


@dataclass
class Constants:
    """The params in scope (None for one that failed) and what is needed to evaluate an expression over them."""

    units: Units
    findings: Findings
    params: Mapping[str, Value | None] = field(default_factory=dict)
    later: Mapping[str, Span] = field(default_factory=dict)
    """Params that are defined further down."""

    def value(self, expr: tree.Expr) -> Value | None:
        """A constant with its dimensions, or None with a diagnostic."""
        value = Expressions(_ConstantScope(self), self.units, self.findings).number(expr)
        return self.checked(value, expr.span)

    def placed(self, expr: tree.Expr, unit: Unit, where: Span, what: str) -> Fraction | None:
        """A constant of a place with a unit, counted in that unit."""
        value = Expressions(_ConstantScope(self), self.units, self.findings).placed(expr, unit, where, what)
        value = self.checked(value, expr.span)
        if value is None or value.constant is None:
            return None
        return unit.from_coherent(value.constant)

    def plain(self, expr: tree.Expr, what: str) -> Fraction | None:
        """A constant without a unit: a weight, a priority, a capacity."""
        value = self.value(expr)
        if value is None or value.constant is None:
            return None
        if value.dims:
            self.findings.report(
                Diagnostic(
                    "FZ220",
                    f"{what} is a plain number, but gets a value {describe(value.dims)}",
                    value.span,
                    label=f"this is {describe(value.dims)}",
                    help="drop the unit",
                )
            )
            return None
        return value.constant

    def checked(self, value: Value | None, span: Span) -> Value | None:
        """A value that is constant and in proportion, or None with a diagnostic."""
        if value is None:
            return None
        if value.constant is None:
            self.not_constant(span)
            return None
        if value.constant and not 1 / LARGEST <= abs(value.constant) <= LARGEST:
            self.findings.report(
                Diagnostic(
                    "FZ443",
                    "this number is too large or too small",
                    span,
                    label="beyond 10^18 or below 10^-18",
                    help="measure in a unit that suits the quantity",
                )
            )
            return None
        return value

    def not_constant(self, span: Span) -> None:
        self.findings.report(
            Diagnostic(
                "FZ248",
                "a constant is needed here",
                span,
                label="this is not known before the step runs",
                help="use numbers and params",
            )
        )


class _ConstantScope:
    """Only params have names here."""

    def __init__(self, constants: Constants) -> None:
        self._constants = constants

    @property
    def intervals(self) -> Intervals:
        return Intervals()

    def name(self, ref: tree.Ref) -> Value | None:
        c = self._constants
        name = ref.parts[0].text
        if len(ref.parts) == 1 and name in c.params:
            known = c.params[name]
            return None if known is None else replace(known, span=ref.span)
        if len(ref.parts) > 1:
            c.not_constant(ref.span)
            return None
        if name in c.later:
            c.findings.report(too_early("param", name, ref.span, c.later[name]))
            return None
        c.findings.report(
            Diagnostic(
                "FZ201",
                f"unknown name `{name}`",
                ref.span,
                label="not a param known here",
                help=hint(name, c.params, "params"),
            )
        )
        return None

    def call(self, call: tree.Call) -> Value | None:
        self._constants.not_constant(call.span)
        return None

    def fold(self, fold: tree.Fold, expected: Unit | None) -> Value | None:
        self._constants.not_constant(fold.span)
        return None

    def callables(self) -> Sequence[str]:
        return ()

    def key(self, kind: str) -> str:
        return kind
