"""The compiler as a library.

    import fuzzyspec

    spec = fuzzyspec.load("nav.fz")                         # SpecError carries every diagnostic
    spec.exact("danger", {"eta_t": [1.5], "eta_d": [0.5]})  # in real numbers
    spec.native("danger", {"eta_t": [1.5], "eta_d": [0.5]}) # the generated C
    spec.compile().files["nav.c"]
    spec.verify().ok

Functions are named as in the spec: its controllers and its systems. So are signals: ``front`` is an array (N,), or
a number for all cases; ``obstacles.distance`` has the shape (N, M), N cases of up to M elements, and
``obstacles.count`` (N,) says how many of these count (all M where it is left out).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from pathlib import Path, PurePath
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source, SpecError
from fuzzyspec.diagnostics.refusal import Refusal

if TYPE_CHECKING:
    from fuzzyspec.emit import Plan
    from fuzzyspec.estimate.budgets import Forecast
    from fuzzyspec.exact import Exact
    from fuzzyspec.fixed.certificate import Certificate
    from fuzzyspec.fixed.program import Program
    from fuzzyspec.fixed.run import Run
    from fuzzyspec.lower import Lowered
    from fuzzyspec.lower import Options as LowerOptions
    from fuzzyspec.model.controller import Controller
    from fuzzyspec.model.system import Module, System
    from fuzzyspec.model.variable import Variable
    from fuzzyspec.native import NativeModule, Result
    from fuzzyspec.verify import Machines, Report, Subject, Sweep

__all__ = ["Diagnostic", "Evaluation", "Source", "Spec", "SpecError", "diagnose", "load", "read"]

Signals = Mapping[str, npt.ArrayLike]
"""Signal name to numbers."""


@dataclass(frozen=True, slots=True)
class Evaluation:
    """N calls of the integer program or of the C.

    ``outputs``: values in declared units, (N,) float64 each (``acting``: the behaviors' codes). ``raws``: the same as
    the raws that the C returns. ``status``: (N,) words; ``flag`` reads a bit by name. ``state``: raws to hand to the
    next step. ``decisions``: what was decided, by key (empty for the C, which does not tell).
    """

    outputs: Mapping[str, npt.NDArray[Any]]
    raws: Mapping[str, npt.NDArray[np.int64]]
    status: npt.NDArray[np.int64]
    state: Mapping[str, npt.NDArray[np.int64]]
    bits: tuple[str, ...]
    decisions: Mapping[str, npt.NDArray[np.int64]]

    def flag(self, bit: str) -> npt.NDArray[np.bool_]:
        """Where a status bit (``SATURATED_TARGET_BEARING``) is set. ValueError where there is no such bit."""
        flagged: npt.NDArray[np.bool_] = (self.status >> self.bits.index(bit)) & 1 != 0
        return flagged


class Spec:
    """A spec that was found good, and everything that can be made of it. Made by ``load``."""

    def __init__(
        self, source: Source, module: Module, warnings: tuple[Diagnostic, ...], tolerance: Fraction | None = None
    ) -> None:
        self.source = source
        self.module = module
        self.warnings = warnings
        self.tolerance = tolerance
        self._lowered: dict[LowerOptions, Lowered] = {}

    def within(self, percent: Fraction | str | int | None) -> Spec:
        """The same spec, with outputs that may be off by so much of their range, in percent, as far as it is certified.

        What is made of it then computes with fewer bits where that keeps to it; None asks for full precision. Raises
        ValueError where ``percent`` is no number; what lowers the spec, SpecError where no program keeps to it.
        """
        return Spec(self.source, self.module, self.warnings, None if percent is None else Fraction(percent))

    @property
    def name(self) -> str:
        """The module's name, which is the prefix of every C symbol."""
        return self.module.name

    @property
    def controllers(self) -> Mapping[str, Controller]:
        """The controllers by name."""
        return MappingProxyType({c.name: c for c in self.module.controllers})

    @property
    def systems(self) -> Mapping[str, System]:
        """The systems by name."""
        return MappingProxyType({s.name: s for s in self.module.systems})

    @property
    def functions(self) -> Mapping[str, Controller | System]:
        """Controllers and systems by name: what can be evaluated, compiled to a C function, and verified."""
        found: dict[str, Controller | System] = {**self.controllers, **self.systems}
        return MappingProxyType(found)

    # --- evaluation -----------------------------------------------------------------------------

    def exact(
        self, function: str, inputs: Signals, state: Signals | None = None, decisions: Signals | None = None
    ) -> Exact:
        """The exact meaning, in real numbers; ``inputs`` and ``state`` in declared units, outputs likewise.

        With ``decisions`` (as in its result) the outcomes given are taken. Raises KeyError for an unknown function,
        ValueError for signals that do not fit.
        """
        from fuzzyspec.exact import evaluate_controller, evaluate_system
        from fuzzyspec.model.controller import Controller
        from fuzzyspec.verify.signals import arranged, signals_of

        model = self._model(function)
        values, _ = arranged(signals_of(model), inputs)
        if isinstance(model, Controller):
            return evaluate_controller(model, values, decisions, state)
        return evaluate_system(model, values, decisions, state)

    def fixed(self, function: str, inputs: Signals, state: Signals | None = None, *, raw: bool = False) -> Evaluation:
        """The integer program: what the C computes, by numpy.

        ``inputs`` in declared units, rounded to the nearest raw, or raws with ``raw``. ``state``: raws as an Evaluation
        returns them; None is the first state. Raises as ``exact``.
        """
        subject = self._subject(function)
        arrays, n = self._raws(subject, inputs, raw)
        run = subject.fixed(arrays, _state(subject, state, n), record=True)
        return _evaluation(subject, run, run.decisions)

    def native(self, function: str, inputs: Signals, state: Signals | None = None, *, raw: bool = False) -> Evaluation:
        """The generated C, built for this machine at the first call. As ``fixed``; MissingTool where no compiler is."""
        subject = self._subject(function)
        arrays, n = self._raws(subject, inputs, raw)
        return _evaluation(subject, self._native.run(function, arrays, _state(subject, state, n)), {})

    def quantise(self, function: str, inputs: Signals) -> dict[str, npt.NDArray[Any]]:
        """The raws that stand for inputs in declared units: nearest, ties up, held within the C types."""
        return self._raws(self._subject(function), inputs, raw=False)[0]

    def dequantise(self, function: str, raws: Signals) -> dict[str, npt.NDArray[Any]]:
        """The values, in declared units, that raws of inputs or of a state stand for; counts stay as they are."""
        from fuzzyspec.exact import dequantise

        subject = self._subject(function)
        variables: dict[str, Variable | None] = {k: p.variable for k, p in subject.ports.items()}
        variables.update({k: p.variable for k, p in subject.state.items()})
        return {
            k: np.asarray(v) if (variable := variables.get(k)) is None else dequantise(variable, v)
            for k, v in raws.items()
        }

    # --- compilation ----------------------------------------------------------------------------

    def compile(self, options: LowerOptions | None = None) -> Plan:
        """The C as a plan of files: ``plan.files`` maps names to bytes; ``fuzzyspec.emit.write`` puts them on disk.

        Raises SpecError where the spec's numbers do not fit.
        """
        from fuzzyspec.emit import emit
        from fuzzyspec.lower import Options

        chosen = self._tolerant(Options() if options is None else options)
        return emit(self.module, self.lower(chosen), self.source, chosen)

    def certificate(self, function: str) -> Certificate:
        """What is promised about |C - exact| of a controller or system. KeyError where there is none of that name."""
        return self.lowered.certificates[function]

    @cached_property
    def lowered(self) -> Lowered:
        """The integer program and its certificates, with the options' defaults."""
        from fuzzyspec.lower import Options

        return self.lower(Options())

    def lower(self, options: LowerOptions) -> Lowered:
        """The integer program and its certificates. Raises SpecError where the spec's numbers do not fit."""
        from fuzzyspec.lower import LoweringError, lower

        chosen = self._tolerant(options)
        if chosen not in self._lowered:
            try:
                self._lowered[chosen] = lower(self.module, chosen)
            except LoweringError as error:
                raise SpecError(self.source, error.diagnostics) from error
        return self._lowered[chosen]

    def forecasts(self, options: LowerOptions, lowered: Lowered | None = None) -> tuple[Forecast, ...]:
        """What the cost model says to the spec's budgets, limit by limit; empty where there are none.

        ``lowered``: what ``lower`` gave for these options, where it is at hand. Raises as ``lower``.
        """
        from fuzzyspec.estimate.budgets import forecasts

        budgets = {name: f.budgets for name, f in self.functions.items() if f.budgets}
        if not budgets:
            return ()
        program = (self.lower(options) if lowered is None else lowered).program
        return forecasts(budgets, program, options.target, options.built_with)

    # --- verification ---------------------------------------------------------------------------

    def verify(
        self,
        *,
        seed: int | None = None,
        cases: int | None = None,
        only: tuple[str, ...] = (),
        c: str | os.PathLike[str] | None = None,
        scenario: str | os.PathLike[str] | None = None,
        raw: bool = False,
        sanitize: bool = True,
        worst: bool = False,
        options: LowerOptions | None = None,
        machines: Machines | None = None,
        sweep: Sweep | None = None,
        progress: Callable[[int, int, str], None] | None = None,
    ) -> Report:
        """Show that the C does what the spec says, or that it does not.

        ``cases``: random cases a function, besides the aimed ones. ``only``: the functions to look at. ``c``: a C file
        to verify instead of the generated one (its header is taken from beside it, else the generated one).
        ``scenario``: a CSV of recorded inputs to replay instead of generated cases, in declared units or, with
        ``raw``, raws. ``options``: what the C was compiled with. ``machines``: where else the same C is to run
        (``verify.find_machines``). ``sweep``: try every input there is (``verify.Sweep``). ``worst``: also search for
        each output's largest error, uphill from the worst of the other cases. ``progress`` is called with cases done,
        cases planned and the name of the function, or the machine. Raises MissingTool where there is no C compiler,
        Refusal where there are too many inputs to sweep, ScenarioError for a bad recording, OSError for a file that
        cannot be read.
        """
        from fuzzyspec.verify import Options, TheirC, read_scenario, verify

        for name in only:
            self._subject(name)
        asked = Options(only=only, sanitize=sanitize, directed=worst, machines=machines, sweep=sweep)
        asked = asked if seed is None else replace(asked, seed=seed)
        asked = asked if cases is None else replace(asked, cases=cases)
        if scenario is not None:
            subject = self._subject(only[0] if only else self.default_function)
            text = _decoded(Path(scenario))
            rows = read_scenario(subject, text, os.fspath(scenario), raw=raw)
            asked = replace(asked, only=(subject.name,), replayed={subject.name: rows})
        program, subjects, files = self._compiled(options)
        theirs = None if c is None else TheirC(beside(Path(c), tuple(files), self.name))
        return verify(program, subjects, files, asked, theirs, progress)

    @property
    def default_function(self) -> str:
        """The only system, else the only controller. Refusal where that does not name one."""
        for group in (self.module.systems, self.module.controllers):
            if len(group) == 1:
                return group[0].name
            if group:
                names = ", ".join(g.name for g in group)
                raise Refusal(f"{self.name} has more than one to choose from: {names}", "name one")
        raise Refusal(f"{self.name} holds neither a system nor a controller")

    # --- inside ---------------------------------------------------------------------------------

    def _tolerant(self, options: LowerOptions) -> LowerOptions:
        return options if options.tolerance is not None else replace(options, tolerance=self.tolerance)

    def _compiled(self, options: LowerOptions | None) -> tuple[Program, tuple[Subject, ...], Mapping[str, bytes]]:
        """What these options make of the spec: the program, its functions, the C."""
        from fuzzyspec.emit import emit
        from fuzzyspec.lower import Options
        from fuzzyspec.verify import subjects

        if options is None or options == Options():
            return self.lowered.program, self._subjects, self.compile().files
        chosen = self._tolerant(options)
        lowered = self.lower(chosen)
        plan = emit(self.module, lowered, self.source, chosen)
        return lowered.program, subjects(self.module, lowered.program, lowered.certificates), plan.files

    @cached_property
    def _subjects(self) -> tuple[Subject, ...]:
        from fuzzyspec.verify import subjects

        return subjects(self.module, self.lowered.program, self.lowered.certificates)

    def _model(self, name: str) -> Controller | System:
        if name not in self.functions:
            raise KeyError(f"{self.name} has no controller or system `{name}`")
        return self.functions[name]

    def _subject(self, name: str) -> Subject:
        model = self._model(name)
        return next(s for s in self._subjects if s.model is model)

    @cached_property
    def _native(self) -> NativeModule:
        from fuzzyspec.lower import Options
        from fuzzyspec.native import NativeModule

        # Of the targets it is a Cortex-M7 that is most like a host: every choice computes the same, this one fastest.
        files = self.compile(Options(optimize="speed", target="cortex-m7")).files
        return NativeModule(self.lowered.program, files)

    def _raws(self, subject: Subject, inputs: Signals, raw: bool) -> tuple[dict[str, npt.NDArray[Any]], int]:
        from fuzzyspec.fixed.quantise import quantise
        from fuzzyspec.verify.signals import arranged, signals_of

        signals = signals_of(subject.model)
        arrays, n = arranged(signals, inputs)
        if not raw:
            arrays |= {k: quantise(v, arrays[k]) for k, v in signals.variables.items()}
        return arrays, n


def load(spec: str | os.PathLike[str]) -> Spec:
    """Load a spec from a path, or from its own text (a string of more than one line).

    Raises SpecError, whose ``diagnostics`` are everything that was found, and OSError where the file cannot be read.
    """
    return accept(*read(spec))


def accept(source: Source, problems: tuple[Diagnostic, ...] = ()) -> Spec:
    """The spec of a text; ``problems`` are those of its encoding. Raises SpecError as ``load``."""
    module, diagnostics = _checked(source, problems)
    if module is None:
        raise SpecError(source, diagnostics)
    return Spec(source, module, diagnostics)


def diagnose(spec: str | os.PathLike[str]) -> tuple[Diagnostic, ...]:
    """Everything that is to be said about a spec, errors and warnings, in one run. Raises OSError as ``load``."""
    return _checked(*read(spec))[1]


def read(spec: str | os.PathLike[str]) -> tuple[Source, tuple[Diagnostic, ...]]:
    """A spec's text, and what is wrong with its encoding.

    The source goes by the path as given, by the bare name of an absolute one. Raises OSError as ``load``.
    """
    from fuzzyspec.syntax.source import source_from_bytes

    if isinstance(spec, str) and "\n" in spec:
        return Source("<text>", spec), ()
    path = PurePath(spec)
    return source_from_bytes(path.name if path.is_absolute() else path.as_posix(), Path(spec).read_bytes())


def _checked(source: Source, problems: tuple[Diagnostic, ...]) -> tuple[Module | None, tuple[Diagnostic, ...]]:
    from fuzzyspec.check import check
    from fuzzyspec.diagnostics.render import in_order
    from fuzzyspec.syntax import parse

    tree, found = parse(source)
    known = (*problems, *found)
    module, findings = check(tree, source, known)
    return module, tuple(in_order((*known, *findings)))


def _decoded(path: Path) -> str:
    """A text file; Refusal where it is no UTF-8."""
    data = path.read_bytes()
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise Refusal(f"{path}: line {line} is not UTF-8", "save the file as UTF-8") from error


def beside(path: Path, generated: tuple[str, ...], module: str) -> dict[str, bytes]:
    """A user's C under the name that the build knows, with what of the other files lies beside it."""
    found = {f"{module}.c": path.read_bytes()}
    for name in generated:
        if name != f"{module}.c" and (path.parent / name).is_file():
            found[name] = (path.parent / name).read_bytes()
    return found


def _state(subject: Subject, state: Signals | None, n: int) -> dict[str, npt.NDArray[Any]] | None:
    if not subject.state:
        return None
    start: Signals = subject.initial if state is None else state
    for key in subject.state:
        if key not in start:
            raise ValueError(f"`{subject.name}` wants a state `{key}`")
    return {k: np.broadcast_to(np.asarray(start[k]), (n,)) for k in subject.state}


def _evaluation(subject: Subject, found: Run | Result, decisions: Mapping[str, npt.NDArray[np.int64]]) -> Evaluation:
    from fuzzyspec.exact import dequantise

    outputs: dict[str, npt.NDArray[Any]] = {}
    for port in subject.function.outputs:
        raws = found.outputs[port.name]
        outputs[port.name] = raws if port.variable is None else dequantise(port.variable, raws)
    bits = tuple(b.name for b in subject.function.status)
    return Evaluation(outputs, found.outputs, found.status, found.state, bits, decisions)
