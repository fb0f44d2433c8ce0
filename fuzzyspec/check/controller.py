"""One controller: its variables, terms and settings are checked here, its rules by ``check.rules``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.check.budgets import check_budgets
from fuzzyspec.check.constants import Constants
from fuzzyspec.check.findings import Report
from fuzzyspec.check.inference import resolve_inference
from fuzzyspec.check.names import Names, check_identifier, check_reserved
from fuzzyspec.check.quantities import interval, quantity
from fuzzyspec.check.rules import resolve_rules
from fuzzyspec.check.shapes import first_gap
from fuzzyspec.check.sizes import oversized
from fuzzyspec.check.terms import TermChecker, Terms
from fuzzyspec.check.variables import Variables
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label
from fuzzyspec.model.controller import Controller, Fallback, Inference, Input, Output
from fuzzyspec.model.term import PiecewiseLinear
from fuzzyspec.model.units import Unit
from fuzzyspec.model.variable import Variable
from fuzzyspec.syntax import tree

FIRES_AT = Fraction(1, 64)
"""The strength at which a controller fires where the spec does not say."""

NOT_ACTING = {"acting": "a controller with behaviors reports the acting one under this name"}


@dataclass(frozen=True, slots=True)
class CheckedController:
    """``controller`` holds what could be checked; it is whole where ``sound``.

    ``vague`` names the inputs and outputs that were declared but did not survive.
    """

    controller: Controller
    vague: frozenset[str]
    sound: bool
    name: tree.Name


def check_controller(decl: tree.ControllerDecl, constants: Constants, torn: bool) -> CheckedController:
    """Check one controller; ``torn`` where a syntax error left a part of it out of the tree."""
    excess = oversized(decl)
    for diagnostic in excess:
        constants.findings.report(diagnostic)
    if excess:
        return _unread(decl)
    return _ControllerChecker(decl, constants, torn).check()


def _unread(decl: tree.ControllerDecl) -> CheckedController:
    """Stands for a controller that is not looked into: nothing is known of its variables but their names."""
    nothing = Controller(decl.name.text, (), (), Inference(), FIRES_AT, None, (), (), (), decl.span)
    names = frozenset(n.text for i in decl.items if isinstance(i, tree.VariableDecl) for n in i.names)
    return CheckedController(nothing, names, False, decl.name)


class _ControllerChecker:
    def __init__(self, decl: tree.ControllerDecl, constants: Constants, torn: bool) -> None:
        self._decl = decl
        self._constants = constants
        self._torn = torn
        self._report = constants.findings.report
        self._variables = Variables(constants)
        self._inputs: list[Input] = []
        self._outputs: list[Output] = []
        self._vague: set[str] = set()

    def check(self) -> CheckedController:
        decl = self._decl
        before = self._constants.findings.errors
        declared = [i for i in decl.items if isinstance(i, tree.VariableDecl)]
        names = Names(self._report)
        behaviors = any(isinstance(i, tree.BehaviorDecl) for i in decl.items)
        for item in declared:
            self._declare(item, names, behaviors)
        if not self._torn:
            self._require("input", declared)
            self._require("output", declared)
        inputs, outputs = tuple(self._inputs), tuple(self._outputs)
        infer = resolve_inference(decl, outputs, self._report)
        fires_at = self._fires_at()
        rules = resolve_rules(
            decl,
            inputs,
            outputs,
            infer,
            fires_at,
            lambda expr: self._constants.plain(expr, "a weight or priority"),
            self._rule_report(declared),
        )
        if rules.cells is not None and self._constants.findings.errors == before:
            self._report_gaps(inputs)
        controller = Controller(
            decl.name.text,
            inputs,
            outputs,
            infer,
            fires_at,
            rules.cells,
            rules.sentences,
            rules.behaviors,
            rules.always_fires,
            decl.span,
            rules.account,
            check_budgets(decl.items, self._constants),
        )
        sound = self._constants.findings.errors == before and not self._torn
        return CheckedController(controller, frozenset(self._vague), sound, decl.name)

    # --- variables ---------------------------------------------------------------------------

    def _require(self, kind: str, declared: list[tree.VariableDecl]) -> None:
        if not any(d.kind == kind for d in declared):
            self._report(
                Diagnostic(
                    "FZ231",
                    f"controller `{self._decl.name.text}` has no {kind}s",
                    self._decl.name.span,
                    label=f"nothing {'to look at' if kind == 'input' else 'to say'}",
                    help=f"declare one: `{kind} x in [0, 1] {{ partition A B C }}`",
                )
            )

    def _declare(self, item: tree.VariableDecl, names: Names, behaviors: bool) -> None:
        fresh: list[tree.Name] = []
        for name in item.names:
            check_identifier(item.kind, name, self._report)
            if item.kind == "output" and behaviors:
                check_reserved(item.kind, name, NOT_ACTING, self._report)
            if names.declare(item.kind, name):
                fresh.append(name)
        first = item.names[0]
        variable = self._variables.variable(first, item.range, item.raw)
        if variable is None:
            self._vague.update(n.text for n in item.names)
            self._check_terms_alone(item)
            return
        terms = self._terms(item, variable)
        if not terms.names:
            self._vague.update(n.text for n in item.names)
        fallback = self._fallback(item, variable)
        for name in fresh if terms.names else ():
            own = self._variables.renamed(variable, name)
            if item.kind == "input":
                self._inputs.append(Input(own, terms.terms, terms.peaks))
            else:
                self._outputs.append(_output(own, terms, fallback))

    def _terms(self, item: tree.VariableDecl, variable: Variable) -> Terms:
        checker = TermChecker(
            self._constants, variable.unit, (variable.lo, variable.hi), item.range.span, item.kind == "output"
        )
        terms = checker.check(item.members)
        if not terms.names and not self._torn:
            self._report(
                Diagnostic(
                    "FZ233",
                    f"{item.kind} `{item.names[0].text}` has no terms",
                    item.names[0].span,
                    label="rules have nothing to speak of",
                    help="add terms, such as `partition LOW MID HIGH`",
                )
            )
        return terms

    def _check_terms_alone(self, item: tree.VariableDecl) -> None:
        """Where the range is wrong, term names can still be declared twice."""
        known = Names(self._report, cased=True)
        for member in item.members:
            match member:
                case tree.Partition() | tree.Singletons():
                    for t in member.terms:
                        known.declare("term", t.name)
                case tree.TermDecl():
                    known.declare("term", member.name)
                case tree.OtherwiseClause():
                    pass

    def _fallback(self, item: tree.VariableDecl, variable: Variable) -> Fallback | None:
        clauses = [m for m in item.members if isinstance(m, tree.OtherwiseClause)]
        if not clauses:
            return None
        if item.kind == "input":
            self._report(
                Diagnostic(
                    "FZ424",
                    "an input has no `otherwise`",
                    clauses[0].span,
                    label="only an output needs a value when nothing fires",
                    help="move it to the output",
                )
            )
            return None
        for extra in clauses[1:]:
            self._report(
                Diagnostic(
                    "FZ210",
                    "`otherwise` is given twice",
                    extra.span,
                    label="given again here",
                    labels=(Label(clauses[0].span, "first given here"),),
                    help="drop one of them",
                )
            )
        clause = clauses[0]
        value = self._constants.placed(clause.value, variable.unit, item.range.span, "the output")
        if value is None:
            return None
        if not variable.lo <= value <= variable.hi:
            self._report(
                Diagnostic(
                    "FZ422",
                    "this `otherwise` is outside of the range",
                    clause.value.span,
                    label=f"{quantity(value, variable.unit)} is not in "
                    + interval(variable.lo, variable.hi, variable.unit),
                    labels=(Label(item.range.span, "the range"),),
                    help="choose a value inside of the range",
                )
            )
            return None
        return Fallback(value, clause.hold)

    # --- settings ----------------------------------------------------------------------------

    def _fires_at(self) -> Fraction:
        given = [i for i in self._decl.items if isinstance(i, tree.FiresAt)]
        for extra in given[1:]:
            self._report(
                Diagnostic(
                    "FZ210",
                    "`fires at` is given twice",
                    extra.span,
                    label="given again here",
                    labels=(Label(given[0].span, "first given here"),),
                    help="drop one of them",
                )
            )
        if not given:
            return FIRES_AT
        value = self._constants.plain(given[0].value, "the strength of `fires at`")
        if value is None:
            return FIRES_AT
        if not 0 < value <= 1:
            self._report(
                Diagnostic(
                    "FZ423",
                    "`fires at` is a strength above 0 and at most 1",
                    given[0].value.span,
                    label=f"{quantity(value, Unit(''))} is not",
                    help="the default is `fires at 1/64`",
                )
            )
            return FIRES_AT
        return value

    # --- rules -------------------------------------------------------------------------------

    def _rule_report(self, declared: list[tree.VariableDecl]) -> Report:
        """Where a part of the controller is missing, nothing is concluded from what the rest does not say."""
        whole = not self._torn and {d.kind for d in declared} == {"input", "output"}
        return self._report if whole else _only(self._report, _ABOUT_NAMES)

    def _report_gaps(self, inputs: tuple[Input, ...]) -> None:
        """Stretches of an input where no term has any degree: no cell can fire there."""
        for i in inputs:
            shapes = [t.shape.points for t in i.terms if isinstance(t.shape, PiecewiseLinear)]
            if i.peaks is not None or not shapes:
                continue
            v = i.variable
            gap = first_gap(shapes, v.lo, v.hi)
            if gap is None:
                continue
            middle = (gap[0] + gap[1]) / 2
            where = f"at {quantity(gap[0], v.unit)}" if gap[0] == gap[1] else f"in {interval(*gap, v.unit)}"
            self._report(
                Diagnostic(
                    "FZ418",
                    f"no term of `{v.name}` has any degree {where}",
                    v.span,
                    label="its terms leave a gap",
                    help="let neighbouring terms overlap; in the gap no cell fires and `otherwise` applies",
                    severity="warning",
                    point={v.name: quantity(middle, v.unit)},
                )
            )


_ABOUT_NAMES = frozenset(f"FZ{n}" for n in (310, 311, 312, 313, 314))


def _only(report: Report, codes: frozenset[str]) -> Callable[[Diagnostic], None]:
    def passed(diagnostic: Diagnostic) -> None:
        if diagnostic.code in codes or not diagnostic.code.startswith("FZ3"):
            report(diagnostic)

    return passed


def _output(variable: Variable, terms: Terms, fallback: Fallback | None) -> Output:
    lo, hi = variable.lo, variable.hi
    if terms.full and terms.peaks is not None:
        lo -= terms.peaks[1] - terms.peaks[0]
        hi += terms.peaks[-1] - terms.peaks[-2]
    return Output(variable, terms.terms, terms.peaks, terms.full, lo, hi, fallback)
