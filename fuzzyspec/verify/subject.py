"""What is verified: one function, with its model, its program and its certificate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from fuzzyspec.exact import Exact, dequantise, evaluate_controller, evaluate_system
from fuzzyspec.fixed.certificate import Certificate
from fuzzyspec.fixed.program import Function, ListPort, Port, Program, StatePort
from fuzzyspec.fixed.run import Run, initial_state, run
from fuzzyspec.model.controller import Controller
from fuzzyspec.model.system import Module, System
from fuzzyspec.native.layout import ports_of, states_of

Ints = npt.NDArray[np.integer[Any]]
Floats = npt.NDArray[np.float64]
Arrays = Mapping[str, npt.NDArray[Any]]


@dataclass(frozen=True, slots=True)
class Subject:
    """One controller or system and everything that is known of it.

    Signals are named as everywhere: ``x`` of shape (N,), ``list.field`` of shape (N, M), ``list.count`` of shape (N,).
    """

    program: Program
    function: Function
    model: Controller | System
    certificate: Certificate

    @property
    def name(self) -> str:
        return self.function.name

    @property
    def scalars(self) -> tuple[Port, ...]:
        return tuple(p for p in self.function.inputs if isinstance(p, Port))

    @property
    def lists(self) -> tuple[ListPort, ...]:
        return tuple(p for p in self.function.inputs if isinstance(p, ListPort))

    @property
    def ports(self) -> dict[str, Port]:
        """Every input raw by signal name, without the counts."""
        return ports_of(self.function)

    @property
    def state(self) -> dict[str, StatePort]:
        """What survives a call, by state key."""
        return states_of(self.program, self.function)

    @property
    def initial(self) -> dict[str, int]:
        """The first state."""
        return initial_state(self.program, self.function)

    def fixed(self, inputs: Arrays, state: Arrays | None, *, record: bool = False) -> Run:
        """The integer program's outcome."""
        return run(self.program, self.name, inputs, state or None, record=record)

    def exact(self, inputs: Arrays, state: Arrays | None, decisions: Arrays | None = None) -> Exact:
        """The exact meaning at the dequantised inputs and state, along ``decisions`` if given."""
        values = self.values(inputs)
        held = {k: dequantise(self.state[k].variable, v) for k, v in (state or {}).items()} or None
        if isinstance(self.model, Controller):
            return evaluate_controller(self.model, values, decisions, held)
        return evaluate_system(self.model, values, decisions, held)

    def values(self, inputs: Arrays) -> dict[str, npt.NDArray[Any]]:
        """Raws to values in declared units; counts stay what they are."""
        ports = self.ports
        found: dict[str, npt.NDArray[Any]] = {}
        for key, raws in inputs.items():
            port = ports.get(key)
            if port is None:
                found[key] = np.asarray(raws)
            else:
                assert port.variable is not None
                found[key] = dequantise(port.variable, raws)
        return found

    def bound(self, output: str) -> Fraction | None:
        """The certified error of an output in its unit, None where there is none."""
        return self.certificate.output(output).error


def subjects(module: Module, program: Program, certificates: Mapping[str, Certificate]) -> tuple[Subject, ...]:
    """Every controller and system of a module, callees first."""
    models: dict[str, Controller | System] = {c.name: c for c in module.controllers}
    models.update({s.name: s for s in module.systems})
    return tuple(Subject(program, f, models[f.name], certificates[f.name]) for f in program.functions)
