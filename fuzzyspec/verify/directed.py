"""A directed search for each output's largest error: from the worst cases seen so far, uphill over their raws.

For every output and either sign of its error the worst cases are kept, no more than a few from between the same
breakpoints, so that many hills are climbed at once. Children are made of them: a few raws moved, by steps of every
size, or set to something special, or taken from another of the worst. A case that no step betters stays; nothing is
random but by the seed.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from fuzzyspec.verify.bench import Bench
from fuzzyspec.verify.cases import Batch, batches
from fuzzyspec.verify.draw import LONGEST_COUNT, Draw, c_limits
from fuzzyspec.verify.points import Raws
from fuzzyspec.verify.report import FunctionFound
from fuzzyspec.verify.runner import Bools
from fuzzyspec.verify.subject import Subject

Floats = npt.NDArray[np.float64]

WIDEST = 16
"""Elements of a list that are moved; what lies behind them is left out."""
A_PLACE = 4
"""Cases that are kept from between the same breakpoints."""


@dataclass(frozen=True, slots=True)
class Effort:
    """``rounds`` of ``children`` cases each; ``kept``: the worst cases that are bred from, by output and sign."""

    rounds: int = 60
    children: int = 1 << 13
    kept: int = 128

    @property
    def cases(self) -> int:
        return self.rounds * self.children

    @classmethod
    def beside(cls, cases: int) -> Effort:
        """A search of about as much as ``cases`` random cases and the aimed ones take."""
        return cls(children=max(1 << 8, min(cases // 24, 1 << 13)))


@dataclass
class _Herd:
    """The worst cases of one output and sign, worst first: rows of raws, their errors (negative ones turned)."""

    rows: Raws
    errors: Floats


@dataclass
class Directed:
    """Asks for batches, and learns from what their errors are. The same seed and answers give the same batches."""

    subject: Subject
    seed: int
    effort: Effort = Effort()
    columns: _Columns = field(init=False)
    _random: np.random.Generator = field(init=False)
    _draw: Draw = field(init=False)
    _herds: dict[tuple[str, int], _Herd] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._random = np.random.default_rng(
            [self.seed, zlib.crc32(b"directed"), zlib.crc32(self.subject.name.encode())]
        )
        self._draw = Draw(self.subject, self.seed)
        self.columns = _Columns(self.subject, self._draw)

    @property
    def anything(self) -> bool:
        """Whether there is something to search for, and where."""
        return bool(self._herds) and bool(self.columns.names)

    def tell(self, batch: Batch, errors: Mapping[str, Floats]) -> None:
        """What the signed errors of a batch's cases are, by output."""
        rows = self.columns.rows(batch)
        if not batch.n or rows is None:
            return
        for name, signed in errors.items():
            for sign in (1, -1):
                self._keep((name, sign), rows, sign * signed)

    def _keep(self, aim: tuple[str, int], rows: Raws, errors: Floats) -> None:
        most = min(self.effort.kept * A_PLACE, len(errors))
        chosen = np.sort(np.argpartition(-errors, most - 1)[:most])
        rows, errors = rows[chosen], errors[chosen]
        if aim in self._herds:
            old = self._herds[aim]
            rows, errors = np.concatenate([old.rows, rows]), np.concatenate([old.errors, errors])
        # Equal cases lie side by side once sorted, and so do those from one place, worst first.
        order = np.lexsort((*rows.T, -errors))
        rows, errors = rows[order], errors[order]
        fresh = np.ones(len(rows), dtype=np.bool_)
        fresh[1:] = (rows[1:] != rows[:-1]).any(axis=1)
        rows, errors = rows[fresh], errors[fresh]
        places = self.columns.places(rows)
        by_place = np.argsort(places, kind="stable")
        starts = np.flatnonzero(np.diff(places[by_place], prepend=places[by_place][0] - 1))
        sizes = np.diff(np.append(starts, len(rows)))
        rank = np.empty(len(rows), dtype=np.int64)
        rank[by_place] = np.arange(len(rows)) - np.repeat(starts, sizes)
        # Every place keeps its few worst, the very worst place as many as are bred from.
        stays = np.flatnonzero((rank < A_PLACE) | (np.arange(len(rows)) < self.effort.kept // 8))[: self.effort.kept]
        self._herds[aim] = _Herd(rows[stays], errors[stays])

    def ask(self) -> Batch:
        """The next cases to try: of every output and sign a share, and a few that come from nowhere."""
        share = max(1, self.effort.children // (len(self._herds) + 1))
        bred = [self._children(herd, share) for herd in self._herds.values()]
        return self.columns.batch(np.concatenate([*bred, self.columns.fresh(share // 4 + 1, self._random)]))

    def _children(self, herd: _Herd, n: int) -> Raws:
        dice = self._random
        # Half of them from the very worst few, the others from anywhere.
        few = np.where(dice.random(n) < 0.5, min(8, len(herd.rows)), len(herd.rows))
        rows = herd.rows[(dice.random(n) * few).astype(np.int64)]
        mixed = (dice.random(n) < 0.25)[:, None] & (dice.random(rows.shape) < 0.3)
        other = herd.rows[dice.integers(0, len(herd.rows), n)]
        rows = np.where(mixed, other, rows)
        return self.columns.moved(rows, dice)


class _Columns:
    """Cases as rows: a column for every raw of an input, a list's element or a state, and for every list's count."""

    def __init__(self, subject: Subject, draw: Draw) -> None:
        self.subject = subject
        self.draw = draw
        self.width = min(max((p.capacity for p in subject.lists), default=0), WIDEST)
        self.names: list[tuple[str, int]] = []
        low: list[int] = []
        high: list[int] = []
        for key, port in subject.ports.items():
            for j in range(self.width if "." in key else 1):
                self.names.append((key, j))
                low.append(c_limits(port)[0])
                high.append(c_limits(port)[1])
        for listed in subject.lists:
            self.names.append((f"{listed.name}.count", 0))
            low.append(0)
            high.append(min(self.width, LONGEST_COUNT))
        for key, state in subject.state.items():
            self.names.append((f"state {key}", 0))
            low.append(state.lo)
            high.append(state.hi)
        self.low, self.high = np.array(low, dtype=np.int64), np.array(high, dtype=np.int64)
        self.special = [
            draw.specials[k].all if k in draw.specials else np.array([a, b]) for (k, _), a, b in self._ends()
        ]
        self.main = [draw.specials[k].main if k in draw.specials else np.array([a, b]) for (k, _), a, b in self._ends()]

    def _ends(self) -> list[tuple[tuple[str, int], int, int]]:
        return [(n, int(a), int(b)) for n, a, b in zip(self.names, self.low, self.high, strict=True)]

    def rows(self, batch: Batch) -> Raws | None:
        """(N, columns); None for lists that are longer than what is moved, or where a state is missing."""
        found: list[Raws] = []
        for name, j in self.names:
            state = name.removeprefix("state ")
            values = batch.state.get(state) if state != name else batch.inputs[name]
            if values is None:
                return None
            if values.ndim == 1:
                found.append(values)
            else:
                found.append(values[:, j] if j < values.shape[1] else np.zeros(batch.n, dtype=np.int64))
        rows = np.stack(found, axis=1).astype(np.int64)
        for listed in self.subject.lists:
            at = self.names.index((f"{listed.name}.count", 0))
            rows[:, at] = np.minimum(rows[:, at], self.width)
        return rows

    def batch(self, rows: Raws) -> Batch:
        """The cases of rows."""
        inputs: dict[str, Raws] = {}
        state: dict[str, Raws] = {}
        for key in dict.fromkeys(n for n, _ in self.names):
            mine = [c for c, (n, _) in enumerate(self.names) if n == key]
            if key.startswith("state "):
                state[key.removeprefix("state ")] = rows[:, mine[0]]
            else:
                inputs[key] = rows[:, mine] if "." in key and not key.endswith(".count") else rows[:, mine[0]]
        return Batch("directed", inputs, state)

    def live(self, rows: Raws) -> Bools:
        """Which columns of a case matter at all: elements up to the count."""
        live = np.ones(rows.shape, dtype=np.bool_)
        for listed in self.subject.lists:
            count = rows[:, self.names.index((f"{listed.name}.count", 0))]
            for c, (name, j) in enumerate(self.names):
                if name.startswith(f"{listed.name}.") and not name.endswith(".count"):
                    live[:, c] = j < count
        return live

    def places(self, rows: Raws) -> Raws:
        """A number for the breakpoints that a case lies between."""
        total = np.zeros(len(rows), dtype=np.int64)
        live = self.live(rows)
        for c, main in enumerate(self.main):
            between = np.searchsorted(main, rows[:, c], side="right")
            total = (total * 1_000_003 + np.where(live[:, c], between + 1, 0)) & (2**40 - 1)
        return total

    def fresh(self, n: int, dice: np.random.Generator) -> Raws:
        """Cases from nowhere."""
        found = self.draw.case_of(n, self.width, "mixed")
        for listed in self.subject.lists:
            found[f"{listed.name}.count"] = dice.integers(0, self.width + 1, n)
        rows = self.rows(Batch("directed", found, self.draw.states(n)))
        assert rows is not None
        return rows

    def moved(self, rows: Raws, dice: np.random.Generator) -> Raws:
        """Each case with one raw changed or a few: by a step of any size, often a small one, or to a special raw."""
        n, width = rows.shape
        live = self.live(rows)
        chance = np.minimum(1.0, dice.choice([1.0, 1.0, 2.0, 4.0], n) / live.sum(axis=1))
        which = (dice.random((n, width)) < chance[:, None]) & live
        # At least one raw moves.
        sure = np.where(live, dice.random((n, width)), -1.0).argmax(axis=1)
        which[np.arange(n), sure] = True
        spans = (self.high - self.low).astype(np.float64)
        near = dice.integers(1, 9, (n, width))
        far = np.exp(dice.random((n, width)) * np.log(np.maximum(spans, 2.0))).astype(np.int64) + 1
        step = np.where(dice.random((n, width)) < 0.5, near, far) * dice.choice([-1, 1], (n, width))
        changed = np.clip(rows + step, self.low, self.high)
        jumps = dice.random((n, width)) < 0.1
        for c, special in enumerate(self.special):
            changed[:, c] = np.where(jumps[:, c], dice.choice(special, n), changed[:, c])
        return np.where(which, changed, rows)


def search(bench: Bench, directed: Directed) -> Iterator[Batch]:
    """Let a directed search run over a bench, whose tally and failures then know what it found; every batch of it."""
    # A function without inputs has nothing to search; one that only decides, nothing to search for.
    for _ in range(directed.effort.rounds if directed.anything else 0):
        batch = directed.ask()
        directed.tell(batch, bench.put(batch))
        yield batch


def largest_errors(subject: Subject, seed: int, cases: int, effort: Effort = Effort()) -> FunctionFound:
    """What is found without C: by the aimed and ``cases`` random cases of ``verify``, and a directed search."""
    bench, directed = Bench(subject, None, None), Directed(subject, seed, effort)
    for batch in batches(subject, seed, cases):
        directed.tell(batch, bench.put(batch))
    for _ in search(bench, directed):
        pass
    return bench.tally.found()
