"""Counting what the comparisons show of one function, batch by batch."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from fuzzyspec.exact import Exact, dequantise
from fuzzyspec.fixed.run import Run
from fuzzyspec.verify.cases import Batch
from fuzzyspec.verify.example import example_at, single
from fuzzyspec.verify.report import DecisionFound, FunctionFound, OutputFound
from fuzzyspec.verify.runner import Bools
from fuzzyspec.verify.subject import Subject


@dataclass
class _Output:
    mismatches: int = 0
    largest: float = -1.0
    worst: Batch | None = None


@dataclass
class _Decision:
    taken: int = 0
    disagreed: int = 0
    largest: float = 0.0


@dataclass
class Tally:
    """Mutable while a verification runs; ``found`` is what it comes to."""

    subject: Subject
    cases: int = 0
    compared: int = 0
    """Cases whose error against the exact meaning was measured."""
    sanitized: int = 0
    mismatches: int = 0
    status: int = 0
    state: int = 0
    kinds: Counter[str] = field(default_factory=Counter)
    outputs: dict[str, _Output] = field(default_factory=dict)
    decisions: dict[str, _Decision] = field(default_factory=dict)

    def add_c(self, batch: Batch, masks: dict[str, Bools], differs: Bools) -> None:
        """Count a batch that went through C and model."""
        self.cases += batch.n
        self.kinds[batch.kind] += batch.n
        self.mismatches += int(differs.sum())
        self.status += int(masks["status"].sum())
        states = [m for k, m in masks.items() if k.startswith("state.")]
        self.state += int(np.logical_or.reduce(states).sum()) if states else 0
        for port in self.subject.function.outputs:
            self.outputs.setdefault(port.name, _Output()).mismatches += int(masks[f"output.{port.name}"].sum())

    def add_bulk(self, cases: int) -> None:
        """Count cases of which only the hashes were compared."""
        self.cases += cases
        self.kinds["bulk"] += cases

    def add_swept(
        self,
        cases: int,
        compared: int,
        largest: Mapping[str, tuple[float, Batch]],
        decisions: Mapping[str, tuple[int, int, float]],
    ) -> None:
        """Count what a sweep found no fault with: its largest errors, its decisions (``swept.Swept``)."""
        self.cases += cases
        self.compared += compared
        self.kinds["every input"] += cases
        for name, (error, worst) in largest.items():
            tally = self.outputs.setdefault(name, _Output())
            if error > tally.largest:
                tally.largest, tally.worst = error, worst
        for key, (taken, disagreed, apart) in decisions.items():
            decision = self.decisions.setdefault(key, _Decision())
            decision.taken += taken
            decision.disagreed += disagreed
            decision.largest = max(decision.largest, apart)

    def add_exact(self, batch: Batch, run: Run, exact: Exact) -> tuple[Bools, Bools]:
        """Count a batch against the exact meaning; lanes that seem beyond their bounds, and beyond their bands."""
        self.compared += batch.n
        beyond_bound = np.zeros(batch.n, dtype=np.bool_)
        for name, errors in errors_of(self.subject, run, exact).items():
            tally = self.outputs.setdefault(name, _Output())
            at = int(errors.argmax()) if batch.n else 0
            if batch.n and errors[at] > tally.largest:
                tally.largest, tally.worst = float(errors[at]), single(batch, at)
            bound = self.subject.bound(name)
            if bound is not None:
                beyond_bound |= errors > float(bound)
        beyond_band = np.zeros(batch.n, dtype=np.bool_)
        for key, (otherwise, margins, taken) in disagreements(run, exact).items():
            decision = self.decisions.setdefault(key, _Decision())
            decision.taken += int(taken.sum())
            decision.disagreed += int(otherwise.sum())
            if otherwise.any():
                decision.largest = max(decision.largest, float(margins[otherwise].max()))
            over = otherwise & (margins > float(self.band(key) or 0))
            beyond_band |= over if over.ndim == 1 else over.any(axis=1)
        return beyond_bound, beyond_band

    def band(self, key: str) -> Fraction | None:
        """What the certificate allows a decision to be off; None where it promises that both meanings agree."""
        return next((b.width for b in self.subject.certificate.bands if b.key == key), None)

    def found(self) -> FunctionFound:
        """The counts as data."""
        function = self.subject.function
        what = {b.key: b.what for b in self.subject.certificate.bands}
        decisions = tuple(
            DecisionFound(key, what.get(key, ""), d.taken, d.disagreed, d.largest, self.band(key))
            for key, d in self.decisions.items()
        )
        return FunctionFound(
            function.name,
            function.kind,
            self.cases,
            dict(self.kinds),
            self.sanitized,
            self.mismatches,
            self.status,
            self.state,
            tuple(self._output(p.name) for p in function.outputs),
            decisions,
        )

    def _output(self, name: str) -> OutputFound:
        tally = self.outputs.get(name, _Output())
        variable = next(p.variable for p in self.subject.function.outputs if p.name == name)
        if variable is None:
            return OutputFound(name, "", self.cases, tally.mismatches, None, None, None, None, None)
        certified = self.subject.certificate.output(name)
        measured = tally.worst is not None
        return OutputFound(
            name,
            variable.unit.symbol,
            self.cases,
            tally.mismatches,
            tally.largest if measured else None,
            100.0 * tally.largest / float(variable.hi - variable.lo) if measured else None,
            certified.error,
            certified.percent_of_range,
            example_at(self.subject, tally.worst, 0) if tally.worst is not None else None,
            certified.dominant,
        )


def errors_of(subject: Subject, run: Run, exact: Exact) -> dict[str, npt.NDArray[np.float64]]:
    """``|fixed - exact|`` of every output that has a unit, (N,) each."""
    return {name: np.abs(error) for name, error in signed_errors(subject, run, exact).items()}


def signed_errors(subject: Subject, run: Run, exact: Exact) -> dict[str, npt.NDArray[np.float64]]:
    """``fixed - exact`` of every output that has a unit, (N,) each."""
    return {
        port.name: dequantise(port.variable, run.outputs[port.name]) - exact.outputs[port.name]
        for port in subject.function.outputs
        if port.variable is not None
    }


def disagreements(run: Run, exact: Exact) -> dict[str, tuple[Bools, npt.NDArray[np.float64], Bools]]:
    """By decision: where the exact meaning would decide otherwise, the margins, and where it was taken at all."""
    found = {}
    for key, mine in run.decisions.items():
        if key not in exact.decisions:
            raise KeyError(f"the exact meaning knows no decision `{key}`")
        theirs, margins = exact.decisions[key], exact.margins[key]
        if mine.ndim == 2 and theirs.shape[1] != mine.shape[1]:
            width = min(mine.shape[1], theirs.shape[1])
            mine, theirs, margins = mine[:, :width], theirs[:, :width], margins[:, :width]
        # -1 in the model: not taken; an infinite margin: the exact meaning did not ask.
        taken = (mine >= 0) & np.isfinite(margins)
        found[key] = (taken & (mine != theirs), margins, taken)
    return found
