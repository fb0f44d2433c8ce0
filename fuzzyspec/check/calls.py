"""Controllers called inside a system, and folds over its lists."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

from fuzzyspec.check.arithmetic import Value, common_dims, fitted
from fuzzyspec.check.constants import LARGEST
from fuzzyspec.check.controller import CheckedController
from fuzzyspec.check.expressions import FOLDS, NOWHERE, Expressions
from fuzzyspec.check.findings import Findings
from fuzzyspec.check.order import Key
from fuzzyspec.check.quantities import interval
from fuzzyspec.check.scope import Context, List, Record, SystemScope
from fuzzyspec.check.similar import hint, listing
from fuzzyspec.check.units import Units, coherent
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Span
from fuzzyspec.model.interval import range_of
from fuzzyspec.model.system import Call, Expr, Fold
from fuzzyspec.model.units import Unit
from fuzzyspec.model.variable import Variable
from fuzzyspec.syntax import tree


class Calls(SystemScope):
    """The scope of a system's expressions, with calls hoisted into the block of the current context."""

    def __init__(
        self,
        controllers: Mapping[str, CheckedController],
        units: Units,
        findings: Findings,
        later: Mapping[Key, Span],
    ) -> None:
        super().__init__(controllers, findings, later)
        self.units = units
        self.findings = findings
        self.returned: dict[tuple[str, str], Variable] = {}
        self._taken = {name for _, name in later}

    def expressions(self) -> Expressions:
        return Expressions(self, self.units, self.findings)

    def in_proportion(self, value: Value, span: Span) -> bool:
        """Whether a value stays within bounds that arithmetic can serve; reports it where not."""
        lo, hi = self.intervals.of(value.expr)
        if max(-lo, hi) <= LARGEST:
            return True
        self._say(
            "FZ443",
            "this can be larger than 10^18",
            span,
            f"ranges over {interval(lo, hi, coherent(value.dims))}",
            "`clamp` what grows",
        )
        return False

    # --- calls -------------------------------------------------------------------------------

    def call(self, call: tree.Call) -> Value | None:
        """A call inside of an expression: the output that it names."""
        record = self.record(call, None)
        if record is None:
            return None
        if call.field is not None:
            return self.output(record, call.field)
        outputs = [o.name for o in record.callee.controller.outputs]
        self._say(
            "FZ246",
            f"`{call.callee.text}(..)` returns all of its outputs, not a number",
            call.span,
            "has outputs",
            f"name one: `{call.callee.text}(..).{outputs[0]}`" if outputs else None,
        )
        return None

    def record(self, call: tree.Call, bound: tree.Name | None) -> Record | None:
        """Hoist a call into the current block; ``bound`` is the ``let`` that takes its name to all outputs."""
        callee = self.controllers[call.callee.text]
        if self.context.fold:
            self._say(
                "FZ250",
                "a controller is called inside of a fold",
                call.callee.span,
                "cannot stand here",
                "call it in a loop before: `for each o in list { let o.x = "
                f"{call.callee.text}(..).y }}`, then fold over `o.x`",
            )
            return None
        if callee.controller.holds and self.context.loop is not None:
            held = next(o for o in callee.controller.outputs if o.fallback is not None and o.fallback.hold)
            self._report(
                Diagnostic(
                    "FZ249",
                    f"controller `{call.callee.text}` remembers, so it cannot be called for each element",
                    call.callee.span,
                    label="one memory, many elements",
                    labels=(Label(held.variable.span, f"`{held.name}` holds"),),
                    help="use `otherwise VALUE` without `hold`, or call it once outside of the loop",
                )
            )
        arguments = self._arguments(call, callee)
        name = self._id(call, bound)
        statement = Call(name, callee.controller, arguments, call.span)
        self.context.block.append(statement)
        self.intervals.add_statement(statement, self.context.loop)
        self.returned.update({(name, o.name): o.variable for o in callee.controller.outputs})
        return Record(name, callee)

    def _id(self, call: tree.Call, bound: tree.Name | None) -> str:
        if bound is not None:
            return bound.text
        n = 1
        while (name := f"{call.callee.text}_{n}") in self._taken:
            n += 1
        self._taken.add(name)
        return name

    def _arguments(self, call: tree.Call, callee: CheckedController) -> tuple[Expr, ...]:
        """The arguments in the order of the controller's inputs; short of those that could not be typed."""
        inputs = {i.name: i for i in callee.controller.inputs}
        given: dict[str, tree.Argument] = {}
        typed: dict[str, Expr] = {}
        clear = True
        for a in call.arguments:
            if a.name is None:
                clear = False
                self._say(
                    "FZ216",
                    "a controller takes its arguments by name",
                    a.span,
                    "which input?",
                    "write `" + ", ".join(f"{n}: .." for n in inputs) + "`",
                )
            elif a.name.text in given:
                self._report(
                    Diagnostic(
                        "FZ215",
                        f"argument `{a.name.text}` is given twice",
                        a.name.span,
                        label="given again here",
                        labels=(Label(given[a.name.text].span, "first given here"),),
                        help="drop one of them",
                    )
                )
            elif a.name.text in inputs:
                given[a.name.text] = a
                v = inputs[a.name.text].variable
                what = f"`{v.name}` of `{callee.name.text}`"
                value = self.expressions().placed(a.value, v.unit, v.span, what, range_of(v))
                if value is not None:
                    typed[v.name] = value.expr
                continue
            elif a.name.text not in callee.vague:
                clear = False
                self._say(
                    "FZ209",
                    f"controller `{callee.name.text}` has no input `{a.name.text}`",
                    a.name.span,
                    "no such input",
                    hint(a.name.text, inputs, "inputs"),
                )
            self.expressions().number(a.value, place=NOWHERE)
        missing = [n for n in inputs if n not in given]
        if missing and clear and callee.sound:
            self._report(
                Diagnostic(
                    "FZ214",
                    f"the call of `{callee.name.text}` lacks {listing(missing)}",
                    call.callee.span,
                    label="not all inputs are given",
                    labels=(Label(inputs[missing[0]].variable.span, "declared here"),),
                    help="add " + ", ".join(f"`{n}: ..`" for n in missing),
                )
            )
        return tuple(typed[n] for n in inputs if n in typed)

    # --- folds -------------------------------------------------------------------------------

    def fold(self, fold: tree.Fold, expected: Unit | None) -> Value | None:
        """A fold over a list; ``expected`` is the unit of the place that it goes straight into."""
        kind = fold.kind.text
        if kind not in FOLDS:
            self._say(
                "FZ252", f"`{kind}` does not go over a list", fold.kind.span, "unknown fold", hint(kind, FOLDS, "folds")
            )
            return None
        over = self.list_named(fold.over)
        if self.context.fold or self.context.loop is not None:
            where = "another fold" if self.context.fold else "a loop"
            self._say(
                "FZ250",
                f"a fold stands inside of {where}",
                fold.span,
                "cannot stand here",
                "compute it in a `let` before, where it does not depend on the element",
            )
            return None
        if over is None or not self.fresh_item(fold.item):
            return None
        outer = self.context
        self.context = Context(outer.block, {fold.item.text: over}, fold=True)
        body = self._fold_body(fold, kind)
        test = None if fold.test is None else self.expressions().test(fold.test)
        self.context = outer
        fallback = None if fold.fallback is None else self.expressions().number(fold.fallback, expected)
        if fallback is not None and fallback.bare and expected is not None:
            fallback = fitted(fallback, expected, fallback.span, "", self._report)
        settled = self._fallback_needed(fold, kind, over)
        if (fold.test is not None and test is None) or (fold.fallback is not None and fallback is None) or not settled:
            return None
        if kind == "count":
            return Value(Fold("count", over, None, test, None), (), fold.span)
        if body is None:
            return None
        if kind == "sum":
            return Value(Fold("sum", over, body.expr, test, None), body.dims, fold.span)
        if fallback is None:
            return None
        of = common_dims((body, fallback), f"`{kind}` cannot choose between", self._report)
        if of is None:
            return None
        which: Literal["max", "min"] = "max" if kind == "max" else "min"
        return Value(Fold(which, over, body.expr, test, fallback.expr), of, fold.span)

    def _fold_body(self, fold: tree.Fold, kind: str) -> Value | None:
        if kind != "count":
            value = self.expressions().number(fold.body)
            return None if value is None else replace(value, bare=False)
        if not (isinstance(fold.body, tree.Ref) and [p.text for p in fold.body.parts] == [fold.item.text]):
            self._say(
                "FZ252",
                "`count` counts elements, so it takes the element alone",
                fold.body.span,
                "not the element",
                f"write `count({fold.item.text} for {fold.item.text} in {fold.over.text} if ..)`",
            )
        return None

    def _fallback_needed(self, fold: tree.Fold, kind: str, over: str) -> bool:
        if kind in ("max", "min") and fold.fallback is None:
            self._say(
                "FZ251",
                f"this `{kind}` has no value where no element passes",
                fold.span,
                f"`{over}` can be empty",
                f"say what it is then: `{kind}(.. for {fold.item.text} in {over}, otherwise ..)`",
            )
            return False
        if kind in ("sum", "count") and fold.fallback is not None:
            self._report(
                Diagnostic(
                    "FZ433",
                    "this `otherwise` is never used",
                    fold.fallback.span,
                    label=f"the {kind} of no elements is 0",
                    help="drop it",
                    severity="warning",
                )
            )
        return True

    def list_named(self, name: tree.Name) -> str | None:
        """The list of that name; reports it where there is none."""
        match self.entry(name):
            case List(name=found):
                return found
            case None:
                return None
            case _:
                lists = [n for n, e in self.entries.items() if isinstance(e, List)]
                self._say(
                    "FZ243",
                    f"`{name.text}` is not a list",
                    name.span,
                    "nothing to go over",
                    hint(name.text, lists, "lists"),
                )
                return None

    def fresh_item(self, item: tree.Name) -> bool:
        """Whether a loop variable's name is free."""
        if item.text not in self.entries:
            return True
        self._say(
            "FZ210",
            f"`{item.text}` has a meaning already",
            item.span,
            "cannot be a loop variable too",
            "choose another name for the element",
        )
        return False
