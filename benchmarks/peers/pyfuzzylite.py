"""pyfuzzylite: fuzzylite's port to Python."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from benchmarks.peers.fll import fll
from benchmarks.peers.task import PeerEntry, Task, averages, evaluated, imported, installed


def measure(task: Task) -> PeerEntry:
    """The error over arrays of all inputs, the time over calls one by one."""
    fl = imported("fuzzylite")
    engine = fl.FllImporter().from_string(fll(task.controller))
    names = [o.name for o in task.controller.outputs]

    def evaluate(row: tuple[float, ...]) -> Mapping[str, float]:
        for variable, value in zip(engine.input_variables, row, strict=True):
            variable.value = value
        engine.process()
        return {name: np.asarray(engine.output_variable(name).value).item() for name in names}

    timed = task.first(300 if averages(task.controller) or len(names) == 1 else 100)
    _, took = evaluated(timed, evaluate)
    for variable, values in zip(engine.input_variables, task.values.values(), strict=True):
        variable.value = values
    engine.process()
    error = task.error({name: np.asarray(engine.output_variable(name).value) for name in names})
    return PeerEntry(task.workload, "pyfuzzylite", installed("pyfuzzylite"), error, len(timed.rows), took)
