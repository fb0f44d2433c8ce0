"""One system: params, inputs, lists, loops, lets and outputs, checked in the order of the text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from fuzzyspec.check.arithmetic import Value
from fuzzyspec.check.budgets import check_budgets
from fuzzyspec.check.calls import Calls
from fuzzyspec.check.constants import Constants
from fuzzyspec.check.controller import CheckedController
from fuzzyspec.check.names import Names, check_identifier, check_reserved, report_duplicate
from fuzzyspec.check.order import definitions, report_cycles
from fuzzyspec.check.outputs import Outputs
from fuzzyspec.check.quantities import number as shown
from fuzzyspec.check.scope import Context, Known, List, Record
from fuzzyspec.check.variables import Variables
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Span
from fuzzyspec.model.system import (
    CallOutput,
    Const,
    ForEach,
    Let,
    ListInput,
    ReadField,
    ReadInput,
    ReadLet,
    Statement,
    System,
)
from fuzzyspec.model.variable import Variable
from fuzzyspec.syntax import tree

RESERVED_FIELDS = {"count": "`list.count` is the number of elements"}

LARGEST_CAPACITY = 255


def check_system(
    decl: tree.SystemDecl,
    controllers: Mapping[str, CheckedController],
    constants: Constants,
    file_params: Mapping[str, tree.Name],
    torn: bool,
) -> System:
    """Check one system; what is returned is whole where nothing was reported."""
    return _SystemChecker(decl, controllers, constants, file_params, torn).check()


class _SystemChecker:
    def __init__(
        self,
        decl: tree.SystemDecl,
        controllers: Mapping[str, CheckedController],
        constants: Constants,
        file_params: Mapping[str, tree.Name],
        torn: bool,
    ) -> None:
        self._decl = decl
        self._torn = torn
        self._findings = constants.findings
        self._errors_before = constants.findings.errors
        self._report = constants.findings.report
        self._params: dict[str, Value | None] = dict(constants.params)
        params_at = {i.name.text: i.name.span for i in decl.items if isinstance(i, tree.Param)}
        self._constants = replace(constants, params=self._params, later=params_at)
        self._variables = Variables(self._constants)
        self._cyclic = report_cycles(decl.items, self._report)
        later = {key: span for key, (span, _, _) in definitions(decl.items).items()}
        self._scope = Calls(controllers, constants.units, constants.findings, later)
        self._spans: dict[str, Span] = {n: name.span for n, name in file_params.items()}
        for name, value in constants.params.items():
            self._scope.entries[name] = Known(value)
        self._ports = Names(self._report)
        self._inputs: list[Variable | ListInput] = []
        self._statements: list[Statement] = []
        self._lets: list[tuple[tuple[str | None, str], tree.Ref]] = []

    def check(self) -> System:
        outputs: list[tree.SystemOutput] = []
        for item in self._decl.items:
            match item:
                case tree.Param():
                    self._param(item)
                case tree.SystemInput():
                    self._input(item)
                case tree.ListInput():
                    self._list(item)
                case tree.Let():
                    self._let(item)
                case tree.ForEach():
                    self._for_each(item)
                case tree.SystemOutput():
                    outputs.append(item)
                case tree.BudgetBlock():
                    pass
        checked, calls = Outputs(self._scope, self._variables, self._ports).check(outputs)
        self._statements += calls
        if not outputs and not self._torn:
            self._say(
                "FZ232",
                f"system `{self._decl.name.text}` has no outputs",
                self._decl.name.span,
                "computes nothing" if self._decl.items else "is empty",
                "add one: `output v = ..`",
            )
        self._warn_unused()
        return System(
            self._decl.name.text,
            tuple(self._inputs),
            tuple(self._statements),
            tuple(checked),
            self._decl.span,
            check_budgets(self._decl.items, self._constants),
        )

    # --- declarations ------------------------------------------------------------------------

    def _fresh(self, what: str, name: tree.Name) -> bool:
        first = self._spans.get(name.text)
        if first is not None:
            report_duplicate(what, name, first, self._report)
            return False
        self._spans[name.text] = name.span
        return True

    def _param(self, item: tree.Param) -> None:
        if not self._fresh("param", item.name):
            return
        value = None
        if (None, item.name.text) not in self._cyclic:
            found = self._constants.checked(self._scope.expressions().number(item.value), item.value.span)
            value = None if found is None else replace(found, bare=False)
        self._params[item.name.text] = value
        self._scope.entries[item.name.text] = Known(value)

    def _input(self, item: tree.SystemInput) -> None:
        check_identifier("input", item.name, self._report)
        fresh = self._fresh("input", item.name) and self._ports.declare("input", item.name)
        variable = self._variables.variable(item.name, item.range, item.raw)
        if not fresh:
            return
        value = None
        if variable is not None:
            self._inputs.append(variable)
            self._scope.intervals.add_input(variable)
            value = Value(ReadInput(variable.name), variable.unit.dims, item.name.span)
        self._scope.entries[item.name.text] = Known(value)

    def _list(self, item: tree.ListInput) -> None:
        name = item.name
        check_identifier("input", name, self._report)
        fresh = self._fresh("input", name) and self._ports.declare("input", name)
        if fresh:
            self._ports.declare("input", tree.Name(f"{name.text}_count", name.span))
        capacity = self._capacity(item.capacity)
        known = Names(self._report)
        fields: list[Variable] = []
        for f in item.fields:
            check_identifier("field", f.name, self._report)
            check_reserved("field", f.name, RESERVED_FIELDS, self._report)
            variable = self._variables.variable(f.name, f.range, f.raw)
            if not known.declare("field", f.name):
                continue
            value = None
            if variable is not None:
                fields.append(variable)
                value = Value(ReadField(name.text, f.name.text), variable.unit.dims, f.name.span)
            if fresh:
                self._scope.fields[name.text, f.name.text] = value
        if not fresh:
            return
        self._scope.entries[name.text] = List(name.text)
        listed = ListInput(name.text, capacity, tuple(fields), item.span)
        self._inputs.append(listed)
        self._scope.intervals.add_input(listed)

    def _capacity(self, written: tree.Expr) -> int:
        value = self._constants.plain(written, "the capacity of a list")
        if value is None:
            return 1
        if value.denominator != 1 or not 1 <= value <= LARGEST_CAPACITY:
            self._say(
                "FZ406",
                f"a list holds a whole number of elements from 1 to {LARGEST_CAPACITY}",
                written.span,
                f"{shown(value)} is not",
            )
            return 1
        return int(value)

    # --- lets --------------------------------------------------------------------------------

    def _let(self, item: tree.Let) -> None:
        name = item.target.parts[0]
        if len(item.target.parts) > 1:
            self._say(
                "FZ244",
                f"`{name.text}.{item.target.parts[1].text}` can only be defined in a loop",
                item.target.span,
                "an element's field",
                f"write `for each {name.text} in list {{ let {name.text}.{item.target.parts[1].text} = .. }}`",
            )
            return
        fresh = self._fresh("let", name)
        self._scope.context = context = Context([])
        entry = self._defined(item, name)
        self._statements += context.block
        if fresh:
            self._scope.entries[name.text] = entry
            self._lets.append(((None, name.text), item.target))

    def _defined(self, item: tree.Let, name: tree.Name) -> Known | Record:
        if (None, name.text) in self._cyclic:
            return Known(None)
        value = item.value
        if isinstance(value, tree.Call) and value.field is None and value.callee.text in self._scope.controllers:
            return self._scope.record(value, name) or Known(None)
        found = self._scope.expressions().number(value)
        if found is None or isinstance(found.expr, Const | ReadInput | ReadLet | CallOutput):
            # Nothing to compute: the name is another name for what is there.
            return Known(None if found is None else replace(found, bare=False))
        if not self._scope.in_proportion(found, item.value.span):
            return Known(None)
        statement = Let(name.text, found.expr, item.span)
        self._scope.intervals.add_statement(statement, None)
        self._scope.context.block.append(statement)
        return Known(Value(ReadLet(name.text, None), found.dims, name.span))

    def _for_each(self, item: tree.ForEach) -> None:
        over = self._scope.list_named(item.over)
        if over is None or not self._scope.fresh_item(item.item):
            return
        context = Context([], {item.item.text: over}, over)
        for let in item.body:
            self._scope.context = context
            self._element_let(let, item.item.text, over, context)
        self._scope.context = Context([])
        if context.block:
            self._statements.append(ForEach(over, tuple(context.block), item.span))

    def _element_let(self, item: tree.Let, loop: str, over: str, context: Context) -> None:
        parts = item.target.parts
        if len(parts) != 2 or parts[0].text != loop:
            self._say(
                "FZ244",
                f"a loop over `{over}` defines fields of its element `{loop}`",
                item.target.span,
                "not a field of the element",
                f"write `let {loop}.{parts[-1].text} = ..`",
            )
            return
        name = parts[1]
        key = over, name.text
        fresh = self._fresh_field(key, name)
        value = item.value
        if key in self._cyclic:
            found = None
        elif isinstance(value, tree.Call) and value.field is None and value.callee.text in self._scope.controllers:
            found = self._scope.call(value)
        else:
            found = self._scope.expressions().number(value)
        if not fresh:
            return
        self._lets.append((key, item.target))
        if found is None or isinstance(found.expr, Const | ReadInput | ReadField | ReadLet):
            self._scope.fields[key] = None if found is None else replace(found, bare=False)
            return
        if not self._scope.in_proportion(found, item.value.span):
            self._scope.fields[key] = None
            return
        statement = Let(name.text, found.expr, item.span)
        self._scope.intervals.add_statement(statement, over)
        context.block.append(statement)
        self._scope.fields[key] = Value(ReadLet(name.text, over), found.dims, name.span)

    def _fresh_field(self, key: tuple[str, str], name: tree.Name) -> bool:
        if key not in self._scope.fields:
            return True
        first = next((t.parts[1].span for k, t in self._lets if k == key), None)
        declared = next((i for i in self._decl.items if isinstance(i, tree.ListInput) and i.name.text == key[0]), None)
        if first is None and declared is not None:
            first = next((f.name.span for f in declared.fields if f.name.text == name.text), declared.name.span)
        report_duplicate("field", name, first or name.span, self._report)
        return False

    def _warn_unused(self) -> None:
        if self._torn or self._findings.errors > self._errors_before:
            # What could not be read may use them.
            return
        for key, target in self._lets:
            if key in self._scope.read or key in self._cyclic:
                continue
            text = ".".join(p.text for p in target.parts)
            self._report(
                Diagnostic(
                    "FZ242",
                    f"`{text}` is never used",
                    target.span,
                    label="computed for nothing",
                    help="remove it, or use it",
                    severity="warning",
                )
            )

    def _say(self, code: str, message: str, span: Span, label: str = "", help: str | None = None) -> None:
        self._report(Diagnostic(code, message, span, label=label, help=help))
