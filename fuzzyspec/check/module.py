"""A whole file: its units and params, then its controllers, then the systems that call them."""

from __future__ import annotations

from dataclasses import replace

from fuzzyspec.check.arithmetic import Value
from fuzzyspec.check.constants import Constants
from fuzzyspec.check.controller import CheckedController, check_controller
from fuzzyspec.check.damage import Damage
from fuzzyspec.check.expressions import FOLDS, FUNCTIONS
from fuzzyspec.check.findings import Findings
from fuzzyspec.check.limits import check_limits
from fuzzyspec.check.names import Names, check_header, check_identifier, check_reserved, report_duplicate
from fuzzyspec.check.system import check_system
from fuzzyspec.check.units import Units
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Source
from fuzzyspec.model.system import Module, System
from fuzzyspec.model.units import Unit
from fuzzyspec.syntax import tree

RESERVED_CONTROLLERS = dict.fromkeys((*FUNCTIONS, *FOLDS), "a built-in function")

_CONSTANT = (tree.UnitDecl, tree.Param)


def check(
    module: tree.Module, source: Source, parse_diagnostics: tuple[Diagnostic, ...] = ()
) -> tuple[Module | None, tuple[Diagnostic, ...]]:
    """The checked model of a file, and everything that was found, in the order of the text.

    The model is None where anything is an error, be it the parser's (``parse_diagnostics``, which are not repeated
    in the result). What a syntax error left out of the tree is not reported as missing.
    """
    damage = Damage(module, source, parse_diagnostics)
    findings = Findings(damage)
    checked = _ModuleChecker(module, findings, damage).check()
    return (None if findings.errors or damage else checked), findings.sorted()


class _ModuleChecker:
    def __init__(self, module: tree.Module, findings: Findings, damage: Damage) -> None:
        self._module = module
        self._report = findings.report
        self._damage = damage
        self._params: dict[str, Value | None] = {}
        self._param_names: dict[str, tree.Name] = {}
        units, later = Units(), {i.name.text: i.name.span for i in module.items if isinstance(i, tree.Param)}
        units.later.update({i.name.text: i.name.span for i in module.items if isinstance(i, tree.UnitDecl)})
        self._constants = Constants(units, findings, self._params, later)
        self._unit_names: dict[str, tree.Name] = {}

    def check(self) -> Module:
        self._head()
        for item in self._module.items:
            if isinstance(item, tree.UnitDecl):
                self._unit(item)
            elif isinstance(item, tree.Param):
                self._param(item)
        taken = Names(self._report)
        controllers: dict[str, CheckedController] = {}
        for item in self._module.items:
            if isinstance(item, tree.ControllerDecl):
                check_identifier("controller", item.name, self._report, field=False)
                free = check_reserved("controller", item.name, RESERVED_CONTROLLERS, self._report)
                fresh = taken.declare("controller", item.name)
                checked = check_controller(item, self._constants, self._damage.tears(item.span))
                if fresh and free:
                    controllers[item.name.text] = checked
        systems: list[System] = []
        for item in self._module.items:
            if isinstance(item, tree.SystemDecl):
                check_identifier("system", item.name, self._report, field=False)
                taken.declare("system", item.name)
                systems.append(
                    check_system(item, controllers, self._constants, self._param_names, self._damage.tears(item.span))
                )
        name = "" if self._module.name is None else self._module.name.text
        model = Module(name, tuple(c.controller for c in controllers.values()), tuple(systems))
        if not self._damage:
            functions_at = {i.name.text: i.name.span for i in self._module.items if not isinstance(i, _CONSTANT)}
            check_limits(model, functions_at, self._report)
        return model

    def _head(self) -> None:
        module = self._module
        if module.name is not None:
            check_identifier("module", module.name, self._report)
            check_header(module.name, self._report)
        functions = [i for i in module.items if isinstance(i, tree.ControllerDecl | tree.SystemDecl)]
        if not functions and not self._damage:
            self._report(
                Diagnostic(
                    "FZ234",
                    "there is nothing to compile in this file",
                    module.span if module.name is None else module.name.span,
                    label="no controller, no system",
                    help="add a `controller NAME { .. }`",
                )
            )

    # --- units and params --------------------------------------------------------------------

    def _unit(self, item: tree.UnitDecl) -> None:
        name = item.name
        if name.text in self._unit_names:
            report_duplicate("unit", name, self._unit_names[name.text].span, self._report)
            return
        if name.text in self._constants.units:
            self._report(
                Diagnostic(
                    "FZ210",
                    f"unit `{name.text}` is built in",
                    name.span,
                    label="cannot be declared again",
                    help="choose another name",
                )
            )
            return
        self._unit_names[name.text] = name
        value = self._constants.value(item.value)
        self._constants.units.later.pop(name.text, None)
        scale = None if value is None else value.constant
        if value is None or scale is None:
            # Known all the same, so that its uses are not reported too.
            self._constants.units.add_broken(name.text)
            return
        if scale <= 0:
            self._report(
                Diagnostic(
                    "FZ222",
                    f"unit `{name.text}` must be worth more than 0",
                    item.value.span,
                    label="not above 0",
                    help="write, for instance, `unit tick = 0.012 rad`",
                )
            )
            self._constants.units.add_broken(name.text)
            return
        self._constants.units.add(Unit(name.text, value.dims, scale))

    def _param(self, item: tree.Param) -> None:
        first = self._param_names.get(item.name.text)
        if first is not None:
            self._report(
                Diagnostic(
                    "FZ210",
                    f"param `{item.name.text}` is declared twice",
                    item.name.span,
                    label="declared again here",
                    labels=(Label(first.span, "first declared here"),),
                    help="rename one of them",
                )
            )
            return
        self._param_names[item.name.text] = item.name
        value = self._constants.value(item.value)
        self._params[item.name.text] = None if value is None else replace(value, bare=False)
