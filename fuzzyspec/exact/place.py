"""Where in a system an expression is evaluated: the lists that it is inside of, and which cases are asked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from fuzzyspec.exact.result import Bools, Floats

Array = TypeVar("Array", Floats, Bools)


@dataclass(frozen=True, slots=True)
class Place:
    """Values here have an axis for the cases and one for each of ``lists``, outermost first.

    ``active`` says which of them are asked for: elements within the count, in branches that are taken. What stands
    elsewhere is arbitrary but finite, and never looked at.
    """

    lists: tuple[str, ...]
    active: Bools

    @property
    def shape(self) -> tuple[int, ...]:
        return self.active.shape

    def where(self, test: Bools) -> Place:
        """The part of it where a test holds."""
        return Place(self.lists, self.active & test)

    def inside(self, over: str, elements: Bools) -> Place:
        """Within a pass over a list; ``elements`` is (N, capacity)."""
        inner = Place((*self.lists, over), np.ones((*self.shape, elements.shape[1]), dtype=np.bool_))
        return Place(inner.lists, self.active[..., None] & inner.align(elements, over))

    def align(self, values: Array, over: str | None) -> Array:
        """Bring (N,) values, or a list's (N, capacity) ones, to the axes here."""
        if over is None:
            return values.reshape(values.shape[0], *(1,) * len(self.lists))
        # a fold over the list of the loop that it stands in speaks of its own element
        axis = max(i for i, name in enumerate(self.lists) if name == over)
        shape = [values.shape[0], *(1,) * len(self.lists)]
        shape[1 + axis] = values.shape[1]
        return values.reshape(shape)
