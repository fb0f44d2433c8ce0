"""A checked controller becomes one integer function."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    Assign,
    Branch,
    Comment,
    Const,
    Define,
    Expr,
    Function,
    Local,
    Port,
    ReadPort,
    ReadState,
    Record,
    SetOutput,
    SetState,
    SetStatus,
    StatePort,
    StatusBit,
    Stmt,
)
from fuzzyspec.lower.average import AverageNumbers, average
from fuzzyspec.lower.cells import fire_cells
from fuzzyspec.lower.centroid import CentroidNumbers, centroid
from fuzzyspec.lower.fire import DEGREE_BITS, Firing, fire, reaches_half, used_terms
from fuzzyspec.lower.fuzzify import Degrees, Reading, fuzzify, in_array
from fuzzyspec.lower.kinds import fire_kinds, named_terms
from fuzzyspec.lower.levels import Means, fire_levels
from fuzzyspec.lower.levels import applies as levels_apply
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.minors import fire_minors
from fuzzyspec.lower.multilinear import MultilinearNumbers, interpolate
from fuzzyspec.lower.multilinear import applies as multilinear_applies
from fuzzyspec.lower.saturation import saturated
from fuzzyspec.lower.scope import Scope
from fuzzyspec.lower.slide import slide, slides
from fuzzyspec.lower.strategy import Precision, Rules, Strategy
from fuzzyspec.lower.zones import zoned
from fuzzyspec.model.controller import Controller, Input, Output
from fuzzyspec.model.variable import Variable


@dataclass(frozen=True)
class ControllerNumbers:
    """What the certificate needs to know of the integers chosen.

    ``degree_errors`` by input and term and ``cell_error``/``sentence_errors`` are in degrees; ``fires_at`` by output is
    the threshold that the program compares with.
    """

    controller: Controller
    degree_errors: tuple[tuple[Fraction, ...], ...]
    cell_error: Fraction
    sentence_errors: tuple[Fraction, ...]
    outputs: tuple[CentroidNumbers | AverageNumbers | MultilinearNumbers, ...]
    fires_at: Fraction
    level_step: Fraction


def port_of(variable: Variable) -> Port:
    """The port that carries a variable."""
    raw = variable.raw
    return Port(variable.name, raw.ctype, raw.lo, raw.hi, variable)


def lower_controller(
    controller: Controller, strategy: Strategy, precision: Precision = "full"
) -> tuple[Function, ControllerNumbers]:
    """Lower by a strategy that applies (``lower.choice``). Raises RangeError and TooManySets where the integers do not
    go into 32 bits."""
    scope = Scope()
    body: list[Stmt] = []
    status: list[StatusBit] = []
    degrees = []
    saturations: list[Stmt] = []
    evens = levels_apply(controller, precision) if strategy.rules == "levels" else None
    linear = None
    if multilinear_applies(controller) and controller.cells is not None:
        linear = interpolate(controller, controller.cells, strategy.interpolation, scope)
    bare = strategy.rules != "loops"
    for i, item in enumerate(controller.inputs if linear is None else ()):
        variable = item.variable
        low, high = build.LIMITS[variable.raw.ctype]
        bit = f"SATURATED_{variable.name.upper()}"
        if low < variable.raw.lo or high > variable.raw.hi:
            status.append(StatusBit(bit, f"{variable.name} was outside its range and was saturated"))
        body.append(Comment(f"{item.name}: degrees of {', '.join(t.name for t in item.terms)}"))
        steps, found, told = _degrees(item, named_terms(controller, i), strategy.rules, bit, scope)
        body += steps
        saturations += told
        degrees.append(found)
    means: Means | list[tuple[list[Stmt], Expr, MultilinearNumbers]] | None = None
    if strategy.rules == "cells" and controller.cells is not None:
        firing = Firing([], DEGREE_BITS, DEGREE_ONE)
        means = fire_cells(controller, controller.cells, degrees, firing, strategy.division, precision, scope)
    elif strategy.rules == "kinds":
        firing = Firing([], DEGREE_BITS, DEGREE_ONE)
        means = fire_kinds(controller, degrees, firing, strategy.division, precision, scope)
    elif evens is not None and controller.cells is not None:
        firing = Firing([], DEGREE_BITS, DEGREE_ONE)
        means = fire_levels(controller, controller.cells, evens, degrees, firing, strategy.division, scope)
    elif linear is not None:
        firing = Firing([], DEGREE_BITS, DEGREE_ONE, body=linear.body, tables=linear.tables)
        means, status = linear.outputs, linear.status
    else:
        firing = fire(controller, degrees, scope, fire_minors if bare else None)
    body += firing.body
    # Not where the inputs are read: what depends on a saturated raw is not to be compiled twice.
    body += saturations
    threshold = max(1, math.floor(controller.fires_at * firing.one + Fraction(1, 2)))
    body += _acting(controller, firing, threshold)
    tables = list(firing.tables)
    numbers: list[CentroidNumbers | AverageNumbers | MultilinearNumbers] = []
    state: list[StatePort] = []
    for o, output in enumerate(controller.outputs):
        if means is not None:
            steps, raw, mean_numbers = means[o]
            numbers.append(mean_numbers)
        elif controller.infer.defuzzify == "centroid":
            fires, used = reaches_half(controller, o), used_terms(controller, o)
            steps, raw, more, found_numbers = centroid(
                output, firing.levels[o], strategy.division, scope, fires, precision, used
            )
            tables += more
            numbers.append(found_numbers)
        else:
            steps, raw, average_numbers = average(output, o, firing, strategy.division, scope)
            numbers.append(average_numbers)
        body += _settle(output, o, steps, raw, firing, threshold, status, state)
    outputs = [port_of(o.variable) for o in controller.outputs]
    if controller.behaviors:
        outputs.append(Port("acting", "uint8", 0, len(controller.behaviors), None))
    function = Function(
        controller.name,
        "controller",
        tuple(port_of(i.variable) for i in controller.inputs),
        tuple(outputs),
        tuple(state),
        (),
        tuple(status),
        tuple(tables),
        controller.behaviors,
        tuple(body),
    )
    return function, ControllerNumbers(
        controller,
        tuple(d.errors for d in degrees) if linear is None else linear.degree_errors,
        firing.cell_error,
        tuple(firing.sentence_errors.get(i, Fraction(0)) for i in range(len(controller.sentences))),
        tuple(numbers),
        Fraction(threshold, firing.one),
        Fraction(1, firing.one),
    )


def _degrees(
    item: Input, named: frozenset[int] | None, rules: Rules, bit: str, scope: Scope
) -> tuple[list[Stmt], Degrees, list[Stmt]]:
    """An input's degrees, and statements that later tell of its saturation; sentences name these of its terms."""
    dense = named is not None
    bare = rules != "loops"
    if not dense and slides(item):
        upper = Local(scope.name(f"{item.name}_term"), "uint8", 0, len(item.terms) - 2)
        slid = slide(item, DEGREE_ONE, lambda k: [Assign(upper, Const(k))], bit, scope)
        two = len(item.terms) == 2
        body: list[Stmt] = slid.steps if two else [Define(upper, Const(0), False), *slid.steps]
        found = Degrees("", 2, Const(0) if two else upper, (slid.error,) * len(item.terms), slid.degree)
        return (body, found, []) if bare else (*in_array(item, body, found, scope), [])
    variable = item.variable
    given = ReadPort(variable.name, variable.raw.ctype, *build.LIMITS[variable.raw.ctype])
    strong = item.peaks is not None and len(item.peaks) > 1
    if rules != "levels" and (strong or rules == "kinds"):
        # Where a raw has led to the terms at an end of the range it may be outside: nowhere else is that asked.
        legal = variable.raw.lo <= given.lo and given.hi <= variable.raw.hi
        value = build.local(scope.name(variable.name), given)
        if strong:
            more, found = fuzzify(item, value, scope, dense, bare, bit=bit)
        else:
            more, found = zoned(item, Reading(variable, value, bit), scope, named)
        return [Define(value, given, legal), *more], found, []
    steps, raw, told = saturated(variable, given, variable.name, bit, scope, rules == "levels")
    more, found = fuzzify(item, raw, scope, dense, bare)
    return steps + more, found, told


def _acting(controller: Controller, firing: Firing, threshold: int) -> list[Stmt]:
    if not controller.behaviors:
        return []
    acting, best = firing.acting, firing.acting_strength
    assert acting is not None and best is not None
    body: list[Stmt] = []
    if not any(controller.always_fires):
        body.append(Branch(build.compare("<", best, Const(threshold)), (Assign(acting, Const(0)),)))
    return [*body, Record("acting", acting), SetOutput("acting", acting)]


def _settle(
    output: Output,
    index: int,
    steps: list[Stmt],
    raw: Expr,
    firing: Firing,
    threshold: int,
    status: list[StatusBit],
    state: list[StatePort],
) -> list[Stmt]:
    """Set an output: the mean where it fires, else what its ``otherwise`` says."""
    name, variable = output.name, output.variable
    hold = output.fallback is not None and output.fallback.hold
    fired: list[Stmt] = [*steps, SetOutput(name, raw)]
    if hold:
        assert output.fallback is not None
        initial = variable.raw.nearest(output.fallback.value)
        state.append(StatePort(name, variable.raw.ctype, initial, variable.raw.lo, variable.raw.hi, variable))
        fired.append(SetState(name, raw))
    best = firing.strongest.get(index)
    if best is None:
        return fired
    assert output.fallback is not None
    test = build.compare(">=", best, Const(threshold))
    if hold:
        bit = f"HELD_{name.upper()}"
        status.append(StatusBit(bit, f"nothing fired for {name}; its last value is held"))
        kept = ReadState(name, variable.raw.ctype, variable.raw.lo, variable.raw.hi)
        other: tuple[Stmt, ...] = (SetOutput(name, kept), SetStatus(bit))
    else:
        other = (SetOutput(name, Const(variable.raw.nearest(output.fallback.value))),)
    comment = Comment(f"{name} fires where its strongest rule reaches {threshold}/{firing.one}")
    return [Record(f"fires.{name}", test), comment, Branch(test, tuple(fired), other)]
