"""The whole file: controllers first, then the systems that call them, each with its certificate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal, get_args

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Span
from fuzzyspec.diagnostics.numerals import exact, upper
from fuzzyspec.estimate.profile import Profile, profile
from fuzzyspec.fixed.build import RangeError
from fuzzyspec.fixed.certificate import Band, Certificate, Dominant, OutputBound
from fuzzyspec.fixed.program import Division, Function, Program, Quotient
from fuzzyspec.fixed.prune import expressions, nodes
from fuzzyspec.lower.bounds import ControllerBounds, Effort, bound_controller, means
from fuzzyspec.lower.bounds.outputs import AverageBound, CentroidBound
from fuzzyspec.lower.choice import WIDTHS, Candidate, candidate, choose, fastest_of, weigh
from fuzzyspec.lower.clipped import MAX_SETS, TooManySets
from fuzzyspec.lower.controller import ControllerNumbers
from fuzzyspec.lower.strategy import Goal, Precision, Strategy, Target
from fuzzyspec.lower.system import CallBounds, Certify, SystemNumbers, lower_system
from fuzzyspec.lower.widths import fit_widths
from fuzzyspec.model.controller import Controller
from fuzzyspec.model.system import Module, System
from fuzzyspec.model.variable import Variable

Means = tuple[CentroidBound | AverageBound, ...]


@dataclass(frozen=True)
class Options:
    """``bounds``: ``quick`` derives in well under a second, ``thorough`` looks at fifty times as many boxes.

    ``optimize``: what the strategies are chosen for, ``target``: the machine. Every choice computes the same
    integers, and its C runs bit-exact on every machine. ``explicit``: strategies by name of a controller or a system
    (which only divides), instead of those that would be chosen. ``tolerance``: the certified error of every output, in
    percent of its range, that lets controllers be of few bits.
    """

    bounds: Literal["quick", "thorough"] = "quick"
    optimize: Goal = "balanced"
    target: Target = "generic"
    explicit: tuple[tuple[str, Strategy], ...] = ()
    tolerance: Fraction | None = None

    def strategy_of(self, name: str) -> Strategy | None:
        """The strategy that was asked for, if any."""
        return next((strategy for function, strategy in self.explicit if function == name), None)

    @property
    def built_with(self) -> Literal["O2", "Os"]:
        """The compiler's option that the C is meant for: what costs are estimated and budgets are judged under."""
        return "Os" if self.optimize == "size" else "O2"


EFFORTS: Mapping[str, tuple[Effort, Effort]] = {
    "quick": (Effort(60_000), Effort(16_000)),
    "thorough": (Effort(3_000_000, cells=65536), Effort(1_000_000, cells=65536)),
}
"""For a controller alone, and for each call of one in a system."""


@dataclass(frozen=True)
class Lowered:
    """``certificates`` by function name."""

    program: Program
    certificates: Mapping[str, Certificate]


class LoweringError(Exception):
    """The spec is sound, but its numbers do not go into 32-bit integers; ``diagnostics`` say where."""

    def __init__(self, diagnostics: tuple[Diagnostic, ...]) -> None:
        self.diagnostics = diagnostics
        super().__init__("; ".join(d.message for d in diagnostics))


def lower(module: Module, options: Options | None = None) -> Lowered:
    """Lower a checked module. Raises LoweringError with every function that does not fit, or whose certified errors
    are beyond the tolerance."""
    chosen = Options() if options is None else options
    if chosen.tolerance is None:
        return _lowered(module, chosen, frozenset(c.name for c in module.controllers))
    calls = {s.name: frozenset(c.controller.name for c in s.calls) for s in module.systems}
    full: frozenset[str] = frozenset()
    while True:
        lowered = _lowered(module, chosen, full)
        beyond = outside(lowered, chosen.tolerance)
        more = frozenset(n for function in beyond for n in calls.get(function, {function})) - full
        if not beyond:
            return lowered
        if not more:
            named: dict[str, Controller | System] = {c.name: c for c in module.controllers}
            named |= {s.name: s for s in module.systems}
            raise LoweringError(
                tuple(_intolerable(named[f], o, chosen.tolerance) for f, found in beyond.items() for o in found)
            )
        full |= more


def outside(lowered: Lowered, tolerance: Fraction) -> dict[str, list[OutputBound]]:
    """By function, the outputs whose certified error is beyond a tolerance in percent of the range, or unknown."""
    found = {
        name: [o for o in c.outputs if o.percent_of_range is None or o.percent_of_range > tolerance]
        for name, c in lowered.certificates.items()
    }
    return {name: outputs for name, outputs in found.items() if outputs}


def _lowered(module: Module, chosen: Options, full: frozenset[str]) -> Lowered:
    """The module with the controllers of ``full`` at full precision, the others at the short one."""
    alone, called = EFFORTS[chosen.bounds]
    functions: dict[str, Function] = {}
    numbers: dict[str, ControllerNumbers] = {}
    divisions: dict[str, Division] = {}
    prepared: dict[str, Means] = {}
    bounds: dict[str, ControllerBounds] = {}
    certificates: dict[str, Certificate] = {}
    problems: list[Diagnostic] = []
    for controller in module.controllers:
        try:
            taken = _controller(controller, chosen, "full" if controller.name in full else "short")
        except (RangeError, TooManySets) as error:
            problems.append(_diagnostic(controller, error))
            continue
        found = taken.numbers
        functions[controller.name] = taken.function
        divisions[controller.name] = taken.strategy.division
        numbers[controller.name] = found
        prepared[controller.name] = means(found)
        exact = (Fraction(0),) * len(controller.inputs)
        bounds[controller.name] = bound_controller(found, exact, alone, prepared[controller.name])
        certificates[controller.name] = _of_controller(controller, bounds[controller.name], chosen)
    cache: dict[tuple[object, ...], CallBounds] = {}

    def certify(controller: Controller, errors: tuple[Fraction, ...], raws: tuple[tuple[int, int], ...]) -> CallBounds:
        name = controller.name
        key = (name, errors, raws)
        if key not in cache:
            found = bound_controller(numbers[name], errors, called, prepared[name], bounds[name], raws)
            cache[key] = CallBounds(found.errors, found.reasons, found.bands, found.dominants)
        return cache[key]

    for system in module.systems:
        if any(c.controller.name not in functions for c in system.calls):
            continue
        try:
            function, system_numbers = _system(system, functions, certify, divisions, chosen)
        except RangeError as error:
            problems.append(_diagnostic(system, error))
            continue
        functions[system.name] = function
        certificates[system.name] = _of_system(system, function, system_numbers, chosen)
    if problems:
        raise LoweringError(tuple(problems))
    widths = WIDTHS[chosen.target]
    fitted = tuple(fit_widths(f, widths) for f in functions.values())
    return Lowered(Program(module.name, fitted, narrow=widths == "narrow"), certificates)


def _controller(controller: Controller, options: Options, precision: Precision) -> Candidate:
    strategy = options.strategy_of(controller.name)
    if strategy is not None:
        return candidate(controller, strategy, options.target, precision)
    return choose(controller, options.optimize, options.target, precision)


def _system(
    system: System,
    functions: dict[str, Function],
    certify: Certify,
    divisions: dict[str, Division],
    options: Options,
) -> tuple[Function, SystemNumbers]:
    """The system with the quotients of its controllers, which the C then holds once; without any, those that cost
    least."""
    strategy = options.strategy_of(system.name)
    if strategy is None and system.calls:
        return lower_system(system, functions, certify, divisions[system.calls[-1].controller.name])
    best = lower_system(system, functions, certify, Strategy().division if strategy is None else strategy.division)
    divides = any(isinstance(n, Quotient) for e in expressions(best[0].body) for n in nodes(e))
    if strategy is not None or not divides:
        return best

    def profiled(function: Function) -> Profile:
        program = Program("choice", (fit_widths(function, WIDTHS[options.target]),))
        return profile(program, function.name)

    others = [lower_system(system, functions, certify, by) for by in get_args(Division) if by != Strategy().division]
    tried = [(one, profiled(one[0])) for one in (best, *others)]
    fastest = fastest_of((p for _, p in tried), options.optimize, options.target)
    return min(tried, key=lambda t: weigh(t[1], options.optimize, options.target, fastest))[0]


def _of_controller(controller: Controller, bounds: ControllerBounds, options: Options) -> Certificate:
    outputs = tuple(
        _output(o.name, o.variable, bounds.errors[o.name], bounds.reasons[o.name], bounds.dominants[o.name])
        for o in controller.outputs
    )
    return Certificate(controller.name, options.bounds, outputs, bounds.bands)


def _of_system(system: System, function: Function, numbers: SystemNumbers, options: Options) -> Certificate:
    outputs = tuple(
        _output(p.name, p.variable, numbers.errors[p.name], numbers.reasons[p.name], numbers.dominants.get(p.name))
        for p in function.outputs
        if p.variable is not None
    )
    bands = {b.key: b for b in numbers.bands}
    for b in numbers.bands:
        bands[b.key] = max(bands[b.key], b, key=_width)
    return Certificate(system.name, options.bounds, outputs, tuple(bands.values()))


def _width(band: Band) -> Fraction:
    return band.width


def _output(
    name: str, variable: Variable, error: Fraction, reason: str, dominant: Dominant | None = None
) -> OutputBound:
    """A bound as wide as the range says nothing, so then there is none, and the reason stands."""
    span = variable.hi - variable.lo
    if error >= span:
        return OutputBound(name, None, None, reason, dominant)
    rounded = _upwards(error, span)
    return OutputBound(name, rounded, rounded / span * 100, reason, dominant)


def _upwards(error: Fraction, span: Fraction) -> Fraction:
    """The error rounded up to a decimal with three digits of the range's percentage that matter."""
    unit = span / 10**9
    return -(-error // unit) * unit


def _intolerable(item: Controller | System, output: OutputBound, tolerance: Fraction) -> Diagnostic:
    asked = exact(tolerance)
    found = "no error can be certified"
    if output.percent_of_range is not None:
        found = f"the certified error is {upper(output.percent_of_range)} % of its range"
    return Diagnostic(
        "FZ452",
        f"`{item.name}.{output.output}` is asked to stay within {asked} %, but {found}",
        item.span,
        help="give a larger `--tolerance`, finer raws, or `--bounds thorough`, which may certify less",
    )


def _diagnostic(item: Controller | System, error: Exception) -> Diagnostic:
    span: Span = item.span
    if isinstance(error, TooManySets):
        return Diagnostic(
            "FZ451",
            f"more than {MAX_SETS} sets of terms overlap in an output of `{item.name}`",
            span,
            help="let fewer terms of one output overlap at one place; a partition has two",
        )
    return Diagnostic(
        "FZ450",
        f"the arithmetic of `{item.name}` does not fit 32-bit integers: {error}",
        span,
        help="narrow the ranges, or take coarser raws with `step`",
    )
