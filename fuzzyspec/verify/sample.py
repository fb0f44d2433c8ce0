"""A share of the cases that went through a verification, with what the integer program made of them.

It is drawn as the cases come by: every kind of case has its share, and the same seed draws the same ones.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from fuzzyspec.fixed.run import Run
from fuzzyspec.native import Result
from fuzzyspec.native.layout import appended
from fuzzyspec.verify.cases import Batch
from fuzzyspec.verify.example import joined
from fuzzyspec.verify.points import Raws
from fuzzyspec.verify.subject import Subject

PART = 1 << 14
"""Cases that a machine is given at once."""


@dataclass
class Sample:
    """``most`` of about ``total`` cases, or all there are. Mutable while the verification runs."""

    subject: Subject
    seed: int
    total: int
    most: int
    _held: int = 0
    _seen: int = 0
    _random: np.random.Generator = field(init=False)
    _kept: list[tuple[Batch, Result]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._random = np.random.default_rng([self.seed, zlib.crc32(self.subject.name.encode()), 1])

    def add(self, batch: Batch, run: Run) -> None:
        """Keep a share of a batch. ``batch.state`` must hold the states that it started from."""
        self._seen += batch.n
        # Twice as many as are wanted: the total may turn out to be less than was planned.
        share = min(batch.n, 2 * self.most * self._seen // max(self.total, 1) + 1 - self._held)
        if share <= 0:
            return
        self._held += share
        lanes = np.sort(self._random.choice(batch.n, share, replace=False))
        inputs, state = _taken(batch.inputs, lanes), _taken(batch.state, lanes)
        wanted = Result(_taken(run.outputs, lanes), run.status[lanes], _taken(run.state, lanes))
        self._kept.append((Batch("sample", inputs, state), wanted))

    @property
    def size(self) -> int:
        """How many cases ``parts`` gives at most."""
        return min(self._held, self.most)

    def parts(self, every: int = 1) -> Iterator[tuple[Batch, Result]]:
        """The cases (one in ``every``), in batches of at most ``PART`` that hold lists of one width."""
        if not self._kept:
            return
        if len(self._kept) > 1:
            self._kept = [(joined([b for b, _ in self._kept]), appended([w for _, w in self._kept]))]
        ((batch, wanted),) = self._kept
        chosen = np.random.default_rng(self.seed).choice(self._held, self.size, replace=False)[::every]
        for start in range(0, len(chosen), PART):
            lanes = chosen[start : start + PART]
            part = Batch(batch.kind, _taken(batch.inputs, lanes), _taken(batch.state, lanes))
            yield part, Result(_taken(wanted.outputs, lanes), wanted.status[lanes], _taken(wanted.state, lanes))


def _taken(arrays: Mapping[str, Raws], lanes: Raws) -> dict[str, Raws]:
    return {k: v[lanes] for k, v in arrays.items()}
