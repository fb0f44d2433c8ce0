"""Which inputs are tried: random ones, and those aimed at every place where the meaning changes.

Everything follows from the seed. The order is: small aimed sets first (they find most faults), sweeps of a whole
input next, random cases last.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from fuzzyspec.fixed.program import ListPort
from fuzzyspec.verify.draw import Draw, c_limits
from fuzzyspec.verify.edges import edges
from fuzzyspec.verify.points import Raws
from fuzzyspec.verify.subject import Subject

DEFAULT_CASES = 200_000
"""Random cases of each function unless told otherwise; the aimed sets grow with it up to their own size."""

EVERY_CELL = 20_000
"""Cells of a rule table that are each started at least, by the peaks of their terms."""
BATCH = 1 << 15
ELEMENTS = 1 << 17
"""Lanes, and records, that one batch holds at most."""
STEPS = 8
"""Length of a trace, where a function remembers."""


@dataclass(frozen=True, slots=True)
class Batch:
    """Cases of one kind. With ``follow`` each lane starts from the state that the batch before it left there."""

    kind: str
    inputs: dict[str, Raws]
    state: dict[str, Raws]
    follow: bool = False

    @property
    def n(self) -> int:
        return len(next(iter(self.inputs.values()))) if self.inputs else 0


def batches(subject: Subject, seed: int, cases: int = DEFAULT_CASES) -> Iterator[Batch]:
    """Every batch for one function. ``cases`` is the number of random ones."""
    draw = Draw(subject, seed)
    if exhaustible(subject, cases):
        for kind, inputs in _everything(draw):
            yield from _cut(draw, kind, inputs)
        return
    for kind, inputs in _sets(draw, cases):
        yield from _cut(draw, kind, inputs)
    for inputs, state in edges(draw, max(cases // 16, 1)):
        yield Batch("edges", inputs, state)
    if subject.state:
        yield from _traces(draw, cases)


def exhaustible(subject: Subject, cases: int) -> bool:
    """Whether every input there is can be tried: no lists, no state, and few enough raws."""
    return not subject.lists and not subject.state and math.prod(_spans(subject)) <= 4 * cases


def _spans(subject: Subject) -> list[int]:
    """How many raws each signal's C type has."""
    return [high - low + 1 for low, high in (c_limits(p) for p in subject.ports.values())]


def bulk(subject: Subject, cases: int = DEFAULT_CASES) -> int:
    """How many cases C is compared with C over, where that is all that is asked: none where everything was tried."""
    return 0 if exhaustible(subject, cases) else 50 * cases


def planned(subject: Subject, cases: int = DEFAULT_CASES, *, with_bulk: bool = False) -> int:
    """About how many cases ``batches`` will give (and ``bulk`` besides): for a progress bar."""
    if exhaustible(subject, cases):
        return math.prod(_spans(subject))
    lists = 200 * (max((p.capacity for p in subject.lists), default=-4) + 4)
    traces = cases // 4 if subject.state else 0
    return (
        cases // 2
        + cases // 8
        + sum(_spans(subject)) * _anchors(subject, cases) // _stride(subject, cases)
        + lists
        + traces
        + cases * (51 if with_bulk else 1)
    )


def _sets(draw: Draw, cases: int) -> Iterator[tuple[str, dict[str, Raws]]]:
    subject = draw.subject
    share = max(cases // 8, 1)
    if subject.lists:
        yield from _lists(draw, share)
    else:
        yield "peaks", _product(draw, {k: draw.specials[k].peaks for k in subject.ports}, max(share, EVERY_CELL))
        yield "corners", _product(draw, {k: draw.specials[k].main for k in subject.ports}, share)
        yield from _pairs(draw, share)
        yield "ties", draw.tied(share, 0)
    yield from _sweeps(draw, _anchors(subject, cases), _stride(subject, cases))
    yield from _random(draw, cases)


# --- without lists ---------------------------------------------------------------------------


def _everything(draw: Draw) -> Iterator[tuple[str, dict[str, Raws]]]:
    """Every input of a function, in pieces."""
    limits = {k: c_limits(p) for k, p in draw.subject.ports.items()}
    total = math.prod(_spans(draw.subject))
    for start in range(0, total, BATCH):
        flat = np.arange(start, min(start + BATCH, total))
        found: dict[str, Raws] = {}
        for key, (low, high) in limits.items():
            found[key] = low + flat % (high - low + 1)
            flat = flat // (high - low + 1)
        yield "every input", found


def _product(draw: Draw, choices: Mapping[str, Raws], most: int) -> dict[str, Raws]:
    """The cross product, or ``most`` random members where it is larger."""
    total = math.prod(len(c) for c in choices.values())
    flat = np.arange(total) if total <= most else draw.random.integers(0, total, most)
    found: dict[str, Raws] = {}
    for key, values in choices.items():
        found[key] = values[flat % len(values)]
        flat = flat // len(values)
    return found


def _pairs(draw: Draw, most: int) -> Iterator[tuple[str, dict[str, Raws]]]:
    """Everything special of two inputs against each other, the rest at peaks."""
    keys = list(draw.subject.ports)
    pairs = list(itertools.combinations(keys, 2)) or [(keys[0], keys[0])] if keys else []
    for pair in pairs:
        crossed = _product(draw, {k: draw.specials[k].all for k in pair}, max(most // len(pairs), 1))
        n = len(crossed[pair[0]])
        yield "breakpoints", {k: crossed[k] if k in crossed else draw.main(k, (n,)) for k in keys}


# --- sweeps ------------------------------------------------------------------------------------


def _anchors(subject: Subject, cases: int) -> int:
    """Sweeps of each signal, so that all of them together come to about twice the random cases; at least two."""
    return max(2, min(64, 2 * cases // max(sum(_spans(subject)), 1)))


def _stride(subject: Subject, cases: int) -> int:
    """1 for whole sweeps, more where so few cases are asked for that two of them would be over four times as many."""
    return max(1, 2 * sum(_spans(subject)) // max(4 * cases, 1))


def _sweeps(draw: Draw, anchors: int, stride: int) -> Iterator[tuple[str, dict[str, Raws]]]:
    """Every raw of one signal, the others fixed at an anchor; lists hold one element."""
    subject = draw.subject
    for key, port in subject.ports.items():
        low, high = c_limits(port)
        raws = np.arange(low, high + 1, stride, dtype=np.int64)
        span = len(raws)
        for anchor in range(anchors):
            how = "main" if anchor % 2 == 0 else "legal"
            fixed = draw.case_of(1, 1, how)
            found = {k: np.repeat(v, span, axis=0) for k, v in fixed.items()}
            found[key] = raws if found[key].ndim == 1 else raws[:, None]
            for listed in subject.lists:
                alone = not key.startswith(f"{listed.name}.") and anchor % 4 == 3
                found[f"{listed.name}.count"] = np.full(span, 0 if alone else 1, dtype=np.int64)
            yield f"sweep of {key}", found


# --- with lists ----------------------------------------------------------------------------------


def _lists(draw: Draw, share: int) -> Iterator[tuple[str, dict[str, Raws]]]:
    subject = draw.subject
    most = max(p.capacity for p in subject.lists)
    for length in (*range(most + 3), 255):
        found = draw.case_of(200, most, "mixed")
        yield f"lists of {length}", _counted(draw, found, functools.partial(_always, length))
    for how in ("main", "special"):
        yield "breakpoints", _counted(draw, draw.case_of(share, 1, how), functools.partial(_always, 1))
    yield "ties", _counted(draw, draw.tied(share, 2), lambda p, n: draw.counts(n, p, 2))
    twins = draw.case_of(share, 1, "mixed")
    doubled = {k: v if v.ndim == 1 else np.repeat(v, 3, axis=1) for k, v in twins.items()}
    for key, values in doubled.items():
        if values.ndim == 2:
            low, high = c_limits(subject.ports[key])
            values[:, 1] = np.clip(values[:, 1] + draw.random.integers(-1, 2, share), low, high)
    yield "twins", _counted(draw, doubled, lambda p, n: draw.counts(n, p, 3))


def _always(length: int, listed: ListPort, n: int) -> Raws:
    return np.full(n, length, dtype=np.int64)


def _counted(draw: Draw, found: dict[str, Raws], count: Callable[[ListPort, int], Raws]) -> dict[str, Raws]:
    n = len(next(iter(found.values())))
    for listed in draw.subject.lists:
        width = found[f"{listed.name}.{listed.fields[0].name}"].shape[1]
        wanted = np.asarray(count(listed, n), dtype=np.int64)
        # A count beyond the width is fine only where the capacity is what stops the reading.
        found[f"{listed.name}.count"] = wanted if width >= listed.capacity else np.minimum(wanted, width)
    return found


# --- random --------------------------------------------------------------------------------------


def _random(draw: Draw, cases: int) -> Iterator[tuple[str, dict[str, Raws]]]:
    subject = draw.subject
    if not subject.lists:
        for how, part in (("legal", 5), ("anything", 1), ("mixed", 2)):
            yield "random", draw.case_of(max(cases * part // 8, 1), 0, how)
        return
    most = max(p.capacity for p in subject.lists)
    # Few elements most of the time: among many, one element's fault hides behind another's value.
    for how, width, part in (
        ("legal", 2, 6),
        ("mixed", 3, 6),
        ("anything", 2, 1),
        ("legal", most, 1),
        ("mixed", most, 1),
    ):
        left = max(cases * part // 15, 1)
        while left > 0:
            n = min(left, max(ELEMENTS // max(width, 1), 1))
            left -= n
            found = draw.case_of(n, min(width, most), how)
            yield "random", _counted(draw, found, lambda p, n: draw.counts(n, p, p.capacity + 2))


def _traces(draw: Draw, cases: int) -> Iterator[Batch]:
    """Steps that follow each other, every lane its own run."""
    n = max(cases // 4 // STEPS, 1)
    width = max((p.capacity for p in draw.subject.lists), default=0)
    for step in range(STEPS):
        found = draw.case_of(n, min(width, 4), "mixed" if step % 2 else "anything")
        inputs = _counted(draw, found, lambda p, n: draw.counts(n, p, p.capacity + 2))
        start = {k: np.full(n, v, dtype=np.int64) for k, v in draw.subject.initial.items()} if step == 0 else {}
        yield Batch("traces", inputs, start, follow=step > 0)


def _cut(draw: Draw, kind: str, inputs: dict[str, Raws]) -> Iterator[Batch]:
    """Batches of bearable size, each with states of its own."""
    n = len(next(iter(inputs.values())))
    for start in range(0, n, BATCH):
        part = {k: v[start : start + BATCH] for k, v in inputs.items()}
        yield Batch(kind, part, draw.states(len(next(iter(part.values())))))
