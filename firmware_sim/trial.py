"""One scenario under the generated C, under the exact meaning, or under each in turn."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any, Literal

from firmware_sim.controllers import Brain, Meaning, danger
from firmware_sim.parameters import Parameters, table
from firmware_sim.report import Deviation, describe, deviation, episodes
from firmware_sim.run import Run, simulate
from firmware_sim.scenario import Scenario
from fuzzyspec.api import Spec

LABELS: dict[Meaning, str] = {"c": "generated C", "exact": "exact meaning"}


@dataclass(frozen=True, slots=True)
class Outcome:
    """A run under one meaning, with the danger (DDC, the largest in sight) of each track's samples."""

    meaning: Meaning
    run: Run
    ddc: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, slots=True)
class Trial:
    """``beside`` is a second run of the same scenario; ``apart`` is how far the two deviate."""

    spec: str
    main: Outcome
    beside: Outcome | None
    apart: Deviation | None

    @property
    def succeeded(self) -> bool:
        """Everybody arrived and nobody touched, in every run."""
        return self.main.run.succeeded and (self.beside is None or self.beside.run.succeeded)

    @property
    def outcomes(self) -> tuple[Outcome, ...]:
        return (self.main,) if self.beside is None else (self.main, self.beside)


def carry_out(
    scenario: Scenario, spec: Spec, controller: Literal["c", "exact", "both"], parameters: Parameters | None = None
) -> Trial:
    """Run the scenario. Raises Unfit where no robot can run the spec, MissingTool where there is no C compiler."""
    world = Parameters() if parameters is None else parameters
    main = _outcome(scenario, spec, "exact" if controller == "exact" else "c", world)
    if controller != "both":
        return Trial(spec.source.name, main, None, None)
    beside = _outcome(scenario, spec, "exact", world)
    return Trial(spec.source.name, main, beside, deviation(main.run, beside.run))


def _outcome(scenario: Scenario, spec: Spec, meaning: Meaning, parameters: Parameters) -> Outcome:
    run = simulate(scenario, [Brain(spec, meaning) for _ in scenario.errands], parameters)
    ddc = tuple(
        tuple(max(danger(spec, meaning, s.readings.obstacles, parameters), default=0.0) for s in track.samples)
        for track in run.tracks
    )
    return Outcome(meaning, run, ddc)


def as_text(trial: Trial) -> Iterator[str]:
    """What happened, for people."""
    yield f"{trial.main.run.scenario.title}: {trial.spec}, {LABELS[trial.main.meaning]} in the loop"
    yield from (f"  {line}" for line in describe(trial.main.run))
    if trial.beside is not None and trial.apart is not None:
        yield f"Beside it, {LABELS[trial.beside.meaning]} in the loop"
        yield from (f"  {line}" for line in describe(trial.beside.run))
        yield (
            f"  apart at most: positions {1000 * trial.apart.position:.3f} mm, "
            f"v {trial.apart.v:.6f} m/s, w {trial.apart.w:.6f} rad/s as commanded"
        )


def as_data(trial: Trial) -> dict[str, Any]:
    """What happened, for programs: plain dicts, lists and numbers."""
    return {
        "scenario": trial.main.run.scenario.name,
        "spec": trial.spec,
        "succeeded": trial.succeeded,
        "parameters": {row.name: row.value for row in table(trial.main.run.parameters)},
        "runs": [_run_data(outcome) for outcome in trial.outcomes],
        "apart": None if trial.apart is None else asdict(trial.apart),
    }


def _run_data(outcome: Outcome) -> dict[str, Any]:
    run = outcome.run
    return {
        "controller": outcome.meaning,
        "robots": [
            {"name": t.errand.robot, "arrived": t.arrived, "episodes": [asdict(e) for e in episodes(t)]}
            for t in run.tracks
        ],
        "clearance": None if run.clearance is None else asdict(run.clearance),
    }
