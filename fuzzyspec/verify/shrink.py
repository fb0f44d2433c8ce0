"""From an input that fails to a smallest one that still does."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from fuzzyspec.verify.cases import Batch
from fuzzyspec.verify.example import joined
from fuzzyspec.verify.points import Raws, special_raws
from fuzzyspec.verify.subject import Subject

Fails = Callable[[Batch], int | None]
"""The first case of a batch that fails, or None."""

MOST_ROUNDS = 200


def shrink(subject: Subject, case: Batch, fails: Fails) -> Batch:
    """Greedy: fewer list elements first, then values at 0 or a peak, then values nearer to one.

    ``case`` is a batch of one that fails, and so is what comes back. Every step taken makes the case strictly
    smaller in the order of ``_size``, so it ends.
    """
    homes = {k: s.main for k, s in special_raws(subject).items()}
    case = _trimmed(subject, case)
    for _ in range(MOST_ROUNDS):
        for candidates in (_with_fewer(subject, case), _with_simpler(subject, case, homes)):
            size = _size(subject, case, homes)
            sized = [(s, c) for c in candidates if (s := _size(subject, c, homes)) < size]
            smaller = [c for _, c in sorted(sized, key=lambda pair: pair[0])]
            failing = fails(joined(smaller)) if smaller else None
            if failing is not None:
                case = _trimmed(subject, smaller[failing])
                break
        else:
            return case
    return case


def _trimmed(subject: Subject, case: Batch) -> Batch:
    """Records that are never read are dropped."""
    inputs = dict(case.inputs)
    for listed in subject.lists:
        used = min(int(inputs[f"{listed.name}.count"][0]), listed.capacity)
        for field in listed.fields:
            key = f"{listed.name}.{field.name}"
            inputs[key] = inputs[key][:, :used]
    return Batch(case.kind, inputs, case.state)


def _size(subject: Subject, case: Batch, homes: Mapping[str, Raws]) -> tuple[int, int, int, int]:
    """Elements; values that are neither 0 nor a peak; values that are not 0; distance from the nearest such place."""
    elements = sum(int(case.inputs[f"{p.name}.count"][0]) for p in subject.lists)
    odd = off = far = 0
    for key, home in homes.items():
        zero = _zero(subject, key)
        for value in case.inputs[key].ravel():
            distance = int(np.abs(home - value).min(initial=abs(int(value) - zero)))
            odd += distance != 0
            off += int(value != zero)
            far += distance
    for key, port in subject.state.items():
        distance = abs(int(case.state[key][0]) - port.initial)
        odd += distance != 0
        far += distance
    return elements, odd, off, far


def _with_fewer(subject: Subject, case: Batch) -> Iterator[Batch]:
    for listed in subject.lists:
        yield from _fewer(case, listed.name, tuple(f.name for f in listed.fields))


def _with_simpler(subject: Subject, case: Batch, homes: Mapping[str, Raws]) -> Iterator[Batch]:
    for key, home in homes.items():
        values = case.inputs[key]
        for index in np.ndindex(values.shape):
            for value in _nearer(int(values[index]), home, _zero(subject, key)):
                changed = values.copy()
                changed[index] = value
                yield Batch(case.kind, {**case.inputs, key: changed}, case.state)
    for key, port in subject.state.items():
        now = int(case.state[key][0])
        for value in {port.initial, (now + port.initial) // 2, now - (now > port.initial) + (now < port.initial)}:
            yield Batch(case.kind, case.inputs, {**case.state, key: np.array([value], dtype=np.int64)})


def _fewer(case: Batch, name: str, fields: tuple[str, ...]) -> Iterator[Batch]:
    """The case with fewer elements: half of them, or one left out."""
    count = int(case.inputs[f"{name}.count"][0])
    held = case.inputs[f"{name}.{fields[0]}"].shape[1]
    kept: list[list[int]] = [[], list(range(held // 2)), list(range(held // 2, held))]
    kept += [[j for j in range(held) if j != out] for out in range(held)]
    for keep in kept:
        if len(keep) < count:
            inputs = dict(case.inputs)
            inputs[f"{name}.count"] = np.array([len(keep)], dtype=np.int64)
            for field in fields:
                inputs[f"{name}.{field}"] = case.inputs[f"{name}.{field}"][:, keep]
            yield Batch(case.kind, inputs, case.state)
    # Past the capacity a smaller count may overrun as well.
    for smaller in range(held, min(count, held + 2)):
        yield Batch(case.kind, {**case.inputs, f"{name}.count": np.array([smaller], dtype=np.int64)}, case.state)


def _zero(subject: Subject, key: str) -> int:
    """The legal raw nearest to 0."""
    port = subject.ports[key]
    return max(port.lo, min(port.hi, 0))


def _nearer(value: int, home: Raws, zero: int) -> set[int]:
    """0, every peak, and steps towards the nearest of them."""
    nearest = int(home[np.abs(home - value).argmin()]) if len(home) else 0
    towards = (value > nearest) - (value < nearest)
    steps = {value - towards * (abs(value - nearest) >> shift) for shift in range(1, 17)}
    return ({zero, *(int(h) for h in home)} | steps | {value - towards}) - {value}
