"""A checked system becomes one integer function: crisp arithmetic, one fused loop a list, calls of controllers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import assert_never

from fuzzyspec.fixed import build
from fuzzyspec.fixed.certificate import Band, Dominant
from fuzzyspec.fixed.program import (
    AllOf,
    AnyOf,
    Branch,
    CallFunction,
    Comment,
    Division,
    Each,
    Expr,
    Function,
    ListPort,
    Local,
    NotTest,
    Port,
    ReadField,
    ReadPort,
    Record,
    SetOutput,
    SetStatus,
    StatusBit,
    Stmt,
    Test,
)
from fuzzyspec.lower import folding
from fuzzyspec.lower.controller import port_of
from fuzzyspec.lower.decisions import decide
from fuzzyspec.lower.places import place, read
from fuzzyspec.lower.quotients import divide, settle, zero_over_zero
from fuzzyspec.lower.saturation import saturated
from fuzzyspec.lower.scaled import Arithmetic, Scaled, cause_of, constant
from fuzzyspec.lower.scope import Scope
from fuzzyspec.lower.walk import folds, needs, needs_of_element
from fuzzyspec.model import system as m
from fuzzyspec.model.controller import Controller
from fuzzyspec.model.interval import Intervals
from fuzzyspec.model.system import ActingOutput, Call, ForEach, Let, ListInput, System, SystemOutput
from fuzzyspec.model.variable import Variable


@dataclass(frozen=True)
class CallBounds:
    """What a controller's certificate says for given input errors (in the inputs' units)."""

    errors: dict[str, Fraction]
    reasons: dict[str, str]
    bands: tuple[Band, ...]
    dominants: dict[str, Dominant | None]


Certify = Callable[[Controller, tuple[Fraction, ...], tuple[tuple[int, int], ...]], CallBounds]
"""From the errors of a controller's inputs and the raws between which each lies."""


@dataclass(frozen=True)
class SystemNumbers:
    """Errors of the outputs in their units, why, and the decisions on computed values."""

    errors: dict[str, Fraction]
    reasons: dict[str, str]
    bands: tuple[Band, ...]
    dominants: dict[str, Dominant]


@dataclass
class Lowering:
    """The state of one system's lowering. ``element`` holds what is known of the current element, inside a loop
    only."""

    system: System
    functions: dict[str, Function]
    certify: Certify
    division_by: Division
    scope: Scope = field(default_factory=Scope)
    body: list[Stmt] = field(default_factory=list)
    status: list[StatusBit] = field(default_factory=list)
    nested: list[tuple[str, str]] = field(default_factory=list)
    bands: list[Band] = field(default_factory=list)
    reasons: dict[str, str] = field(default_factory=dict)
    dominants: dict[str, Dominant] = field(default_factory=dict)
    owed: dict[str, Dominant] = field(default_factory=dict)
    """What bounds owe most to: those of calls by cause, those of outputs by name."""
    known: dict[tuple[str, str], Scaled] = field(default_factory=dict)
    element: dict[tuple[str, str], Scaled] | None = None
    folded: dict[int, Scaled] = field(default_factory=dict)
    bare: dict[tuple[str, str], tuple[Local, Fraction]] = field(default_factory=dict)
    acting: dict[str, Local] = field(default_factory=dict)
    loops: list[ForEach] = field(default_factory=list)
    element_calls: set[str] = field(default_factory=set)
    intervals: Intervals = field(init=False)

    def __post_init__(self) -> None:
        self.intervals = Intervals.of_system(self.system)
        for s in self.system.statements:
            if isinstance(s, ForEach):
                self.element_calls |= {b.id for b in s.body if isinstance(b, Call)}

    @property
    def arithmetic(self) -> Arithmetic:
        return Arithmetic(self.scope, self.body)

    # --- inputs and statements ------------------------------------------------------------------

    def run(self) -> tuple[Function, SystemNumbers]:
        ports: list[Port | ListPort] = []
        for item in self.system.inputs:
            if isinstance(item, ListInput):
                fields = tuple(port_of(f) for f in item.fields)
                ports.append(ListPort(item.name, item.capacity, fields))
                self.bit(f"OVERRUN_{item.name.upper()}", f"more than {item.capacity} {item.name}: the rest was ignored")
                for f in item.fields:
                    self.may_saturate(f, f"SATURATED_{item.name.upper()}_{f.name.upper()}", f"{item.name}: {f.name}")
            else:
                ports.append(port_of(item))
                self.input(item)
        for position, statement in enumerate(self.system.statements):
            match statement:
                case Let(name, value):
                    self.body.append(Comment(f"{name}"))
                    self.known["let", name] = self.value(value, name)
                case Call():
                    self.call(statement)
                case ForEach():
                    for fold in folds(statement):
                        self.value(fold, fold.kind)
                    self.loops.append(statement)
                    self.pass_over(statement.list, self.waiting(statement.list, position + 1), True)
                case _:
                    assert_never(statement)
        errors: dict[str, Fraction] = {}
        outputs = [self.output(o, errors) for o in self.system.outputs]
        function = Function(
            self.system.name,
            "system",
            tuple(ports),
            tuple(outputs),
            (),
            tuple(self.nested),
            tuple(self.status),
            (),
            (),
            tuple(self.body),
        )
        return function, SystemNumbers(errors, self.reasons, tuple(self.bands), self.owed)

    def bit(self, name: str, meaning: str) -> str:
        if all(b.name != name for b in self.status):
            self.status.append(StatusBit(name, meaning))
        return name

    def may_saturate(self, variable: Variable, bit: str, what: str) -> None:
        low, high = build.LIMITS[variable.raw.ctype]
        if low < variable.raw.lo or high > variable.raw.hi:
            self.bit(bit, f"{what} was outside its range and was saturated")

    def input(self, variable: Variable) -> None:
        bit = f"SATURATED_{variable.name.upper()}"
        self.may_saturate(variable, bit, variable.name)
        low, high = build.LIMITS[variable.raw.ctype]
        given = ReadPort(variable.name, variable.raw.ctype, low, high)
        steps, raw, told = saturated(variable, given, variable.name, bit, self.scope)
        self.body += steps + told
        self.known["input", variable.name] = read(variable, raw)

    def waiting(self, list_: str, position: int) -> list[m.Fold]:
        """Folds of later statements and outputs over this list that need nothing later than what is known now."""
        later: list[object] = [*self.system.statements[position:], *self.system.outputs]
        return [f for root in later for f in folds(root) if f.list == list_ and self.ready(f)]

    def ready(self, fold: m.Fold) -> bool:
        inner = [f for part in (fold.body, fold.test, fold.otherwise) for f in folds(part)]
        own = {
            ("let", b.name) for loop in self.loops if loop.list == fold.list for b in loop.body if isinstance(b, Let)
        }
        own |= {
            ("call", b.id) for loop in self.loops if loop.list == fold.list for b in loop.body if isinstance(b, Call)
        }
        return (
            needs(fold, self.element_calls) <= set(self.known)
            and needs_of_element(fold, self.element_calls) <= own
            and all(id(f) in self.folded for f in inner)
        )

    def pass_over(self, list_: str, wanted: list[m.Fold], bodies: bool) -> None:
        """One loop over the caller's records: every field read once, the element's lets and calls, then the folds.

        ``bodies``: whether the lets and calls of the ``for each`` met so far are needed.
        """
        port = next(i for i in self.system.inputs if isinstance(i, ListInput) and i.name == list_)
        outer, self.body = self.body, []
        self.element = {}
        counter = Local(self.scope.name("n"), "uint8", 0, port.capacity - 1)
        for f in port.fields:
            low, high = build.LIMITS[f.raw.ctype]
            given = ReadField(list_, f.name, f.raw.ctype, low, high)
            bit = f"SATURATED_{list_.upper()}_{f.name.upper()}"
            steps, raw, told = saturated(f, given, f.name, bit, self.scope)
            self.body += steps + told
            self.element["field", f.name] = read(f, raw)
        for loop in self.loops:
            if loop.list != list_ or not bodies:
                continue
            for statement in loop.body:
                if isinstance(statement, Let):
                    self.body.append(Comment(f"{statement.name} of this element"))
                    self.element["let", statement.name] = self.value(statement.value, statement.name)
                else:
                    self.call(statement)
        before: list[Stmt] = []
        after: list[tuple[m.Fold, folding.Folded]] = []
        for fold in wanted:
            if id(fold) not in self.folded and all(fold is not f for f, _ in after):
                self.body.append(Comment(f"{fold.kind} over {list_}"))
                after.append((fold, folding.fold(self, fold, port.capacity, before)))
        inside, self.body = self.body, outer
        self.element = None
        self.body += [Comment(f"one pass over {list_}"), *before, Each(list_, counter, tuple(inside))]
        for fold, folded in after:
            self.folded[id(fold)] = folded.finish()

    # --- expressions ----------------------------------------------------------------------------

    def value(self, expr: m.Expr, name: str) -> Scaled:
        """Lower an expression; ``name`` is what its locals are called after."""
        a = self.arithmetic
        match expr:
            case m.Const(value):
                return constant(value)
            case m.ReadInput(key):
                return self.known["input", key]
            case m.ReadField(_, key):
                return self.of_element("field", key)
            case m.ReadLet(key, list_):
                return self.known["let", key] if list_ is None else self.of_element("let", key)
            case m.CallOutput(call, output):
                key = f"{call}.{output}"
                return self.of_element("call", key) if call in self.element_calls else self.known["call", key]
            case m.Add(left, right):
                return a.plus(self.value(left, name), self.value(right, name), name)
            case m.Sub(left, right):
                return a.plus(self.value(left, name), a.negated(self.value(right, name)), name)
            case m.Mul(left, right):
                return a.times(self.value(left, name), self.value(right, name), name)
            case m.Neg(operand):
                return a.negated(self.value(operand, name))
            case m.Div():
                return self.division(expr, name)
            case m.Least(operands):
                return a.smallest([self.value(o, name) for o in operands], name)
            case m.Greatest(operands):
                return a.largest([self.value(o, name) for o in operands], name)
            case m.Clamp(operand, lo, hi):
                inner = a.largest([self.value(operand, name), constant(lo)], name)
                return a.smallest([inner, constant(hi)], name)
            case m.Abs(operand):
                return a.absolute(self.value(operand, name), name)
            case m.If(test, then, other):
                decided = self.test(test, name)
                same = a.common([self.value(then, name), self.value(other, name)], name)
                chosen = build.select(decided, same[0].expr, same[1].expr)
                return Scaled(
                    a.bind(chosen, name), same[0].step, same[0].offset, max(s.error for s in same), cause_of(*same)
                )
            case m.Fold():
                if id(expr) not in self.folded:
                    for nested in (f for part in (expr.body, expr.test, expr.otherwise) for f in folds(part)):
                        self.value(nested, name)
                    self.pass_over(expr.list, [expr], bool(needs_of_element(expr, self.element_calls)))
                return self.folded[id(expr)]
            case _:
                assert_never(expr)

    def of_element(self, kind: str, key: str) -> Scaled:
        assert self.element is not None, "an element's value outside its loop"
        return self.element[kind, key]

    def division(self, expr: m.Div, name: str) -> Scaled:
        a = self.arithmetic
        x, y = self.value(expr.left, name), self.value(expr.right, name)
        if y.expr.lo == y.expr.hi and not y.error and y.lo != 0:
            exact = a.by_constant(x, 1 / y.lo)
            if expr.into is None:
                return exact
            return a.smallest([a.largest([exact, constant(expr.into[0])], name), constant(expr.into[1])], name)
        # Without a place it is its own interval that it stays in: that of the exact operands, not of the computed ones.
        into = self.intervals.of(expr) if expr.into is None else expr.into
        quotient = divide(a, x, y, into, self.division_by, name)
        if expr.otherwise is None:
            return quotient
        test, band = zero_over_zero(a, x, y, f"{name}_zero")
        self.body.append(Record(expr.key, test))
        if band:
            self.bands.append(Band(expr.key, f"0/0 in {name}", band))
        return settle(a, test, quotient, self.value(expr.otherwise, name), name)

    def test(self, test: m.Test, name: str) -> Test:
        match test:
            case m.Compare(op, left, right, key):
                a, b = self.value(left, name), self.value(right, name)
                decided, band = decide(self.arithmetic, op, a, b, name)
                self.body.append(Record(key, decided))
                if band:
                    self.bands.append(Band(key, f"comparison in {name}", band))
                return decided
            case m.Both(operands):
                return AllOf(tuple(self.test(t, name) for t in operands))
            case m.Either(operands):
                return AnyOf(tuple(self.test(t, name) for t in operands))
            case m.Neither(operand):
                return NotTest(self.test(operand, name))
            case _:
                assert_never(test)

    # --- calls and outputs ----------------------------------------------------------------------

    def call(self, call: Call) -> None:
        controller = call.controller
        self.body.append(Comment(f"{call.id}: {controller.name}"))
        arguments: list[Expr] = []
        errors: list[Fraction] = []
        carried: list[tuple[Fraction, str]] = []
        for item, argument in zip(controller.inputs, call.arguments, strict=True):
            name = f"{call.id}_{item.name}"
            placed = place(self.arithmetic, self.value(argument, name), item.variable, name)
            arguments.append(self.arithmetic.bind(placed.raw, f"{name}_raw"))
            errors.append(placed.error)
            carried.append((placed.error / (item.variable.hi - item.variable.lo), item.name))
        bounds = self.certify(controller, tuple(errors), tuple((a.lo, a.hi) for a in arguments))
        share, worst = max(carried)
        worst_input = f"; its input {worst} is off by up to {float(100 * share):.3g} %" if share else ""
        callee = self.functions[controller.name]
        results: list[tuple[str, Local]] = []
        for output in controller.outputs:
            raw = output.variable.raw
            local = Local(self.scope.name(f"{call.id}_{output.name}"), raw.ctype, raw.lo, raw.hi)
            results.append((output.name, local))
            cause = f"{call.id}.{output.name}: {bounds.reasons[output.name]}{worst_input}"
            value = read(output.variable, local, bounds.errors[output.name], cause)
            dominant = bounds.dominants[output.name]
            if dominant is not None:
                self.dominants[cause] = replace(dominant, kernel=f"{call.id}: {dominant.kernel}")
            if self.element is not None:
                self.element["call", f"{call.id}.{output.name}"] = value
            else:
                self.known["call", f"{call.id}.{output.name}"] = value
                self.bare[call.id, output.name] = (local, bounds.errors[output.name])
        if controller.behaviors:
            port = next(p for p in callee.outputs if p.name == "acting")
            acting = Local(self.scope.name(f"{call.id}_acting"), "uint8", port.lo, port.hi)
            results.append(("acting", acting))
            self.acting[call.id] = acting
        held: list[tuple[str, str]] = []
        for bit in callee.status:
            if bit.name.startswith("HELD_"):
                taken = any(b.name == bit.name for b in self.status)
                mine = f"HELD_{call.id.upper()}_{bit.name[5:]}" if taken else bit.name
                held.append((bit.name, self.bit(mine, f"{call.id}: {bit.meaning}")))
        if controller.holds:
            self.nested.append((call.id, controller.name))
        self.known["call", call.id] = constant(Fraction(0))
        state = call.id if controller.holds else None
        self.body.append(CallFunction(call.id, controller.name, tuple(arguments), tuple(results), state, tuple(held)))
        self.bands += [Band(f"{call.id}.{b.key}", b.what, b.width) for b in bounds.bands]

    def output(self, output: SystemOutput | ActingOutput, errors: dict[str, Fraction]) -> Port:
        if isinstance(output, ActingOutput):
            local = self.acting[output.call]
            self.body.append(SetOutput(output.name, local))
            return Port(output.name, "uint8", local.lo, local.hi, None)
        variable = output.variable
        if output.bare is not None:
            raw, error = self.bare[output.bare]
            cause = self.known["call", ".".join(output.bare)].cause
            self.reasons[output.name] = cause
            if cause in self.dominants:
                self.owed[output.name] = self.dominants[cause]
            self.body.append(SetOutput(output.name, raw))
            errors[output.name] = error
            return port_of(variable)
        self.body.append(Comment(f"output {output.name}"))
        value = self.value(output.value, output.name)
        placed = place(self.arithmetic, value, variable, output.name)
        if output.saturates and placed.outside:
            bit = self.bit(f"SATURATED_{output.name.upper()}", f"{output.name} was saturated to its range")
            self.body.append(Branch(AnyOf(tuple(placed.outside)), (SetStatus(bit),)))
        self.body.append(SetOutput(output.name, placed.raw))
        errors[output.name] = placed.error
        self.reasons[output.name] = placed.cause or "rounding"
        self.owed[output.name] = self.owes(output, placed.error, value)
        return port_of(variable)

    def owes(self, output: SystemOutput, error: Fraction, value: Scaled) -> Dominant:
        """What an output's bound owes most to: the call or the quotient that its value's error is from, or rounding."""
        carried = value.error / abs(output.variable.unit.scale)
        share = min(100, round(100 * carried / (error or 1)))
        if 2 * share < 100:
            return Dominant("anywhere", f"rounding of {output.name} to its raw", 100 - share)
        known = self.dominants.get(value.cause)
        if known is not None:
            return replace(known, percent=known.percent * share // 100)
        return Dominant("anywhere", value.cause or f"rounding on the way to {output.name}", share)


def lower_system(
    system: System, functions: dict[str, Function], certify: Certify, division: Division = "loop"
) -> tuple[Function, SystemNumbers]:
    """Raises RangeError where the arithmetic does not go into 32 bits."""
    return Lowering(system, functions, certify, division).run()
