"""Cases at the edges of the results: neighbouring raws between which an output, the status or the state changes.

What is rounded on the way to an output shows where the output steps, so that is where a constant that is off by one
shows first, and most of all where an output has few raws.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fuzzyspec.fixed.run import Run
from fuzzyspec.verify.draw import Draw
from fuzzyspec.verify.points import Raws
from fuzzyspec.verify.runner import Bools


def edges(draw: Draw, n: int) -> Iterator[tuple[dict[str, Raws], dict[str, Raws]]]:
    """Inputs and states on both sides of up to ``n`` edges. Lists hold one element.

    Between two legal cases that differ in one signal and in what comes of it, the distance is halved until they touch.
    """
    subject = draw.subject
    inputs, state = draw.case_of(n, 1, "legal"), draw.states(n)
    inputs |= {f"{p.name}.count": np.ones(n, dtype=np.int64) for p in subject.lists}
    moved = draw.random.integers(0, max(len(subject.ports), 1), n)
    for at, key in enumerate(subject.ports):
        lanes = moved == at
        here = {k: v[lanes] for k, v in inputs.items()}
        held = {k: v[lanes] for k, v in state.items()}
        low, high = here[key], draw.legal(key, here[key].shape)
        start = subject.fixed(here, held)
        differs = _differs(start, subject.fixed({**here, key: high}, held))
        while (np.abs(high - low) > 1).any():
            middle = (low + high) // 2
            beyond = _differs(start, subject.fixed({**here, key: middle}, held)).reshape(-1, *[1] * (low.ndim - 1))
            low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
        for side in (low, high):
            chosen = {k: v[differs] for k, v in {**here, key: side}.items()}
            yield chosen, {k: v[differs] for k, v in held.items()}


def _differs(one: Run, other: Run) -> Bools:
    """Where two runs end otherwise. ``one`` is kept at the lower side, from which an edge is looked for."""
    pairs: list[tuple[Raws, Raws]] = [(one.status, other.status)]
    pairs += [(v, other.outputs[k]) for k, v in one.outputs.items()]
    pairs += [(v, other.state[k]) for k, v in one.state.items()]
    return np.asarray(np.logical_or.reduce([a != b for a, b in pairs]), dtype=np.bool_)
