"""How far a sweep over all inputs has come, and what it found: what is kept while it is interrupted."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True, slots=True)
class BlockFound:
    """One block. ``failed``: numbers of inputs at which something seems wrong, the first of each kind.

    ``largest``: by output the largest error and the input's number; ``decisions``: by key how often it was taken, how
    often the exact meaning would take another, and how far apart the operands were then at most.
    """

    block: int
    compared: int
    largest: Mapping[str, tuple[float, int]]
    decisions: Mapping[str, tuple[int, int, float]]
    failed: tuple[int, ...]


@dataclass
class Swept:
    """The blocks of one function that are done, and what they come to. Mutable while the sweep runs."""

    done: list[tuple[int, int]] = field(default_factory=list)
    """Ranges, first and last + 1, in order and apart."""
    compared: int = 0
    largest: dict[str, tuple[float, int]] = field(default_factory=dict)
    decisions: dict[str, tuple[int, int, float]] = field(default_factory=dict)

    def add(self, found: BlockFound) -> None:
        """One more block."""
        ranges = sorted([*self.done, (found.block, found.block + 1)])
        self.done = [ranges[0]]
        for first, last in ranges[1:]:
            if first == self.done[-1][1]:
                self.done[-1] = (self.done[-1][0], last)
            else:
                self.done.append((first, last))
        self.compared += found.compared
        for name, one in found.largest.items():
            # Of equal errors the one at the lower number, in whatever order the blocks come.
            self.largest[name] = min(self.largest.get(name, one), one, key=lambda pair: (-pair[0], pair[1]))
        for key, (taken, disagreed, apart) in found.decisions.items():
            before = self.decisions.get(key, (0, 0, 0.0))
            self.decisions[key] = (before[0] + taken, before[1] + disagreed, max(before[2], apart))

    @property
    def blocks(self) -> int:
        """How many are done."""
        return sum(last - first for first, last in self.done)

    def missing(self, blocks: int) -> Iterator[int]:
        """Those of the first ``blocks`` that are not."""
        at = 0
        for first, last in [*self.done, (blocks, blocks)]:
            yield from range(at, first)
            at = last

    def as_data(self) -> dict[str, Any]:
        """For a file."""
        return {
            "done": [list(r) for r in self.done],
            "compared": self.compared,
            "largest": {k: list(v) for k, v in self.largest.items()},
            "decisions": {k: list(v) for k, v in self.decisions.items()},
        }

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Swept:
        """From a file. KeyError, TypeError or ValueError where it is not what ``as_data`` gave."""
        return cls(
            sorted((int(first), int(last)) for first, last in data["done"]),
            int(data["compared"]),
            {str(k): (float(e), int(n)) for k, (e, n) in data["largest"].items()},
            {str(k): (int(t), int(d), float(m)) for k, (t, d, m) in data["decisions"].items()},
        )
