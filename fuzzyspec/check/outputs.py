"""The outputs of a system: their ranges, their raws, and controllers' outputs handed on."""

from __future__ import annotations

from dataclasses import replace

from fuzzyspec.check.arithmetic import Value
from fuzzyspec.check.calls import Calls
from fuzzyspec.check.expressions import NOWHERE
from fuzzyspec.check.names import Names, check_identifier
from fuzzyspec.check.scope import Context, Record
from fuzzyspec.check.units import coherent
from fuzzyspec.check.variables import Variables
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Span
from fuzzyspec.model.interval import Interval
from fuzzyspec.model.system import ActingOutput, Call, CallOutput, Let, SystemOutput
from fuzzyspec.model.units import Unit
from fuzzyspec.model.variable import Variable
from fuzzyspec.syntax import tree


class Outputs:
    """Checks the outputs once everything else of the system is known."""

    def __init__(self, scope: Calls, variables: Variables, ports: Names) -> None:
        self._scope = scope
        self._variables = variables
        self._ports = ports

    def check(self, outputs: list[tree.SystemOutput]) -> tuple[list[SystemOutput | ActingOutput], list[Let | Call]]:
        """The outputs in order, and the calls that stand inside of them."""
        self._scope.context = context = Context([])
        checked: list[SystemOutput | ActingOutput] = []
        for item in outputs:
            check_identifier("output", item.name, self._scope.findings.report)
            self._ports.declare("output", item.name)
            found = self._acting(item) or self._number(item)
            if found is not None:
                checked.append(found)
        return checked, context.block

    def _acting(self, item: tree.SystemOutput) -> ActingOutput | None:
        """``output acting = drive.acting``: the code of a behavior handed on."""
        value = item.value
        if not isinstance(value, tree.Ref) or len(value.parts) != 2 or value.parts[1].text != "acting":
            return None
        record = self._scope.entries.get(value.parts[0].text)
        if not isinstance(record, Record) or not record.callee.controller.behaviors:
            return None
        if item.range is not None or item.raw is not None:
            where = item.raw.span if item.range is None and item.raw is not None else item.name.span
            self._say(
                "FZ245",
                "`acting` is a code from 0 to 255, without range or raw",
                where,
                "not wanted here",
                f"write `output {item.name.text} = {value.parts[0].text}.acting`",
            )
        self._scope.read.add((None, value.parts[0].text))
        return ActingOutput(item.name.text, record.call, item.span)

    def _number(self, item: tree.SystemOutput) -> SystemOutput | None:
        if item.range is not None:
            return self._ranged(item, item.range)
        value = self._scope.expressions().number(item.value)
        if value is None:
            return None
        if not self._scope.in_proportion(value, item.value.span):
            return None
        source = self._bare(value)
        if source is not None:
            variable = replace(source[1], name=item.name.text, span=item.name.span)
            if item.raw is None:
                return SystemOutput(variable, value.expr, source[0], False)
            ends, unit = (variable.lo, variable.hi), variable.unit
        else:
            ends, unit = self._scope.intervals.of(value.expr), coherent(value.dims)
        if ends[0] == ends[1]:
            self._say(
                "FZ435",
                f"output `{item.name.text}` is always the same",
                item.value.span,
                "a constant",
                "leave it out, or declare a range: `output x in [lo, hi] = ..`",
            )
            return None
        return self._with_raw(item, value, ends, unit, False)

    def _ranged(self, item: tree.SystemOutput, written: tree.Range) -> SystemOutput | None:
        unit, ends = self._variables.range(written)
        if unit is None or ends is None:
            self._scope.expressions().number(item.value, None, NOWHERE)
            return None
        place: Interval = unit.to_coherent(ends[0]), unit.to_coherent(ends[1])
        where = written.span if written.unit is None else written.unit.span
        value = self._scope.expressions().placed(item.value, unit, where, f"output `{item.name.text}`", place)
        if value is None:
            self._variables.raw(ends, unit, item.raw, written.span)
            return None
        lo, hi = self._scope.intervals.of(value.expr)
        return self._with_raw(item, value, ends, unit, lo < place[0] or hi > place[1])

    def _with_raw(
        self, item: tree.SystemOutput, value: Value, ends: Interval, unit: Unit, saturates: bool
    ) -> SystemOutput | None:
        where = item.range.span if item.range is not None else item.name.span
        raw = self._variables.raw(ends, unit, item.raw, where)
        if raw is None:
            return None
        return SystemOutput(Variable(item.name.text, *ends, unit, raw, item.name.span), value.expr, None, saturates)

    def _bare(self, value: Value) -> tuple[tuple[str, str], Variable] | None:
        """The call and variable of a controller's output that is handed on as it is."""
        if not isinstance(value.expr, CallOutput):
            return None
        variable = self._scope.returned[value.expr.call, value.expr.output]
        return (value.expr.call, value.expr.output), variable

    def _say(self, code: str, message: str, span: Span, label: str = "", help: str | None = None) -> None:
        self._scope.findings.report(Diagnostic(code, message, span, label=label, help=help))
