"""The score of ``fuzzyc verify`` over mutants of generated C: killed of all that are not shown to do the same."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

from fuzzyspec import api
from fuzzyspec.emit.names import name_module
from fuzzyspec.lower import Options
from fuzzyspec.native.workspace import PRODUCT
from tests.mutation.c_mutants import Mutant
from tests.mutation.c_proof import Unit, shown_equal, unit
from tests.mutation.c_sweep import swept_equal
from tests.mutation.c_trial import FOUND, Trial


@dataclass
class Score:
    """How the mutants of some files ended. ``left``: neither killed nor shown equal, with the file they are of."""

    ends: Counter[str] = field(default_factory=Counter)
    left: list[str] = field(default_factory=list)

    @property
    def killed(self) -> int:
        """By whichever of verify's means."""
        return sum(self.ends[v] for v in FOUND)

    @property
    def percent(self) -> float:
        """Killed, of all that are not shown to do the same."""
        return 100.0 * self.killed / max(self.killed + len(self.left), 1)

    def __str__(self) -> str:
        means = ", ".join(f"{self.ends[v]} {v}" for v in FOUND if self.ends[v])
        equal = sum(self.ends[v] for v in ("same object", "shown equal", "every input"))
        return (
            f"{sum(self.ends.values())} mutants, {self.ends['no C']} no C; {self.killed} killed ({means}); "
            f"{equal} shown equal ({self.ends['same object']} the same object, {self.ends['shown equal']} by proof, "
            f"{self.ends['every input']} by every input); "
            f"{len(self.left)} left: {self.percent:.2f} %"
        )

    def __add__(self, other: Score) -> Score:
        return Score(self.ends + other.ends, self.left + other.left)


def score(text: str, options: Options, most: int | None, seed: int = 7) -> Score:
    """Of one spec's C: of all its mutants, or of ``most`` of them."""
    found = Score()
    with Trial(api.load(text), options) as trial:
        judge = Equal(trial)
        for mutant in sampled(trial.mutants, most, seed):
            end: str = trial.verdict(mutant)
            if end == "survived" and judge.equal(mutant):
                end = "shown equal"
            elif end == "survived" and swept_equal(trial, mutant):
                end = "every input"
            found.ends[end] += 1
            if end == "survived":
                found.left.append(f"{trial.name} ({options.optimize}, {options.target}) {mutant}")
    return found


def sampled(all_of: list[Mutant], most: int | None, seed: int) -> list[Mutant]:
    """All, or some; in the order of the text."""
    if most is None or most >= len(all_of):
        return all_of
    return sorted(random.Random(seed).sample(all_of, most), key=lambda m: m.start)


class Equal:
    """Shows mutants of one trial equal."""

    def __init__(self, trial: Trial) -> None:
        self.trial = trial
        self.folder = trial.folder / PRODUCT
        self.one = unit(self.folder, trial.source)
        self.ranges = dict(self._ranges())

    def equal(self, mutant: Mutant) -> bool:
        """Whether it is shown."""
        return shown_equal(self.one, self._unit(mutant), self.ranges)

    def _unit(self, mutant: Mutant) -> Unit:
        return unit(self.folder, mutant.of(self.trial.source))

    def _ranges(self) -> Iterator[tuple[str, dict[str, tuple[int, int]]]]:
        program = self.trial.spec.lowered.program
        names = name_module(program)
        for function in program.functions:
            c = names.functions[function.name]
            yield c.function, {c.outputs[o.name]: (o.lo, o.hi) for o in function.outputs}
