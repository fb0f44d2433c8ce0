"""One spec through everything: C against integer program against exact meaning, over random and aimed inputs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fuzzyspec.api import Spec
from fuzzyspec.emit import emit
from fuzzyspec.exact import Point
from fuzzyspec.fixed.run import Run, run
from fuzzyspec.lower import Options
from fuzzyspec.native import NativeModule
from fuzzyspec.verify.cases import Batch
from fuzzyspec.verify.confirm import _point as evaluated_exactly
from fuzzyspec.verify.confirm import beyond_band, beyond_bound
from fuzzyspec.verify.draw import Draw
from fuzzyspec.verify.runner import differing
from fuzzyspec.verify.subject import Subject, subjects
from fuzzyspec.verify.tally import disagreements, errors_of

MOST = 32
"""Cases of a batch that are looked at again in rationals."""

WIDEST = 5
"""Records in a list, at most, unless it is the full one's turn."""


@dataclass(frozen=True)
class Measured:
    """Largest error that was seen of an output, as a part of its certified bound; None where there is no bound."""

    function: str
    output: str
    share: float | None


def cases(subject: Subject, seed: int, n: int) -> Iterator[Batch]:
    """About ``n`` cases: legal raws, ends and peaks, what surrounds breakpoints and thresholds, ties, anything."""
    draw = Draw(subject, seed)
    for how, part in (("legal", 5), ("mixed", 4), ("main", 3), ("special", 3), ("anything", 1), ("tied", 2)):
        lanes = max(n * part // 18, 8)
        capacity = max((p.capacity for p in subject.lists), default=0)
        width = min(capacity, WIDEST)
        found = draw.tied(lanes, width) if how == "tied" else draw.case_of(lanes, width, how)
        yield Batch(how, counted(draw, found, width), draw.states(lanes))
    for listed in subject.lists:
        # Full and overfull lists, a few of them.
        found = draw.case_of(12, max(p.capacity for p in subject.lists), "mixed")
        counts = np.minimum(listed.capacity + np.arange(12) % 3, 255)
        full = {f"{p.name}.count": np.minimum(counts, p.capacity) for p in subject.lists}
        yield Batch("full", found | full | {f"{listed.name}.count": counts}, draw.states(12))


def counted(draw: Draw, found: dict[str, np.ndarray], width: int) -> dict[str, np.ndarray]:
    """With counts that the width can serve; more than the capacity now and then where that stops the reading."""
    n = len(next(iter(found.values())))
    for listed in draw.subject.lists:
        counts = draw.counts(n, listed, width)
        over = draw.random.random(n) < 0.1
        found[f"{listed.name}.count"] = np.where(over & (listed.capacity <= width), listed.capacity + 1, counts)
    return found


def check_c(subject: Subject, native: NativeModule, batch: Batch) -> None:
    """C equals the integer program bit for bit; the integer program keeps its own intervals."""
    wanted = run(subject.program, subject.name, batch.inputs, batch.state or None, checked=True)
    got = native.run(subject.name, batch.inputs, batch.state or None)
    for what, mask in differing(got, wanted).items():
        assert not mask.any(), f"{subject.name}: C and program differ in {what} at {example(batch, int(mask.argmax()))}"


def check_exact(subject: Subject, batch: Batch) -> dict[str, float]:
    """The integer program is within its certificate; the largest error seen of each output."""
    found = run(subject.program, subject.name, batch.inputs, batch.state or None, record=True)
    exact = subject.exact(batch.inputs, batch.state or None, found.decisions)
    errors = errors_of(subject, found, exact)
    suspects = np.ones(batch.n, dtype=np.bool_)
    beyond = beyond_bound(subject, batch, found, exact, suspects) or beyond_band(subject, batch, found, exact, suspects)
    if beyond is not None:
        at, what = beyond
        raise AssertionError(
            f"{subject.name}: {what.what} should be {what.expected}, is {what.got} at {example(batch, at)}"
        )
    without = {k for k in found.decisions if k not in {b.key for b in subject.certificate.bands}}
    for key, (otherwise, _, _) in disagreements(found, exact).items():
        lanes = otherwise if otherwise.ndim == 1 else otherwise.any(axis=1)
        for at in np.flatnonzero(lanes)[:MOST] if key in without else ():
            assert decided_alike(subject, batch, found, int(at), key), (
                f"{subject.name}: {key} is decided otherwise without a band at {example(batch, int(at))}"
            )
    return {name: float(e.max(initial=0.0)) for name, e in errors.items()}


def decided_alike(subject: Subject, batch: Batch, found: Run, at: int, key: str) -> bool:
    """Whether the definitions, in rationals, decide as the program did: float64 may not know at a tie."""
    point = evaluated_exactly(subject, batch, found, at)
    mine = found.decisions[key][at]
    if isinstance(point, Point):
        return point.decisions[key] == mine
    theirs = {where: d for where, d in point.decisions.items() if where[0] == key}
    taken = {where: int(mine[where[1]] if where[1] else mine) for where in theirs}
    return all(taken[where] in (d, -1) for where, d in theirs.items())


def example(batch: Batch, at: int) -> str:
    """One case of a batch, to be read."""
    inputs = {k: v[at].tolist() for k, v in batch.inputs.items()}
    return f"{inputs} state { ({k: int(v[at]) for k, v in batch.state.items()}) } ({batch.kind})"


OPTIONS = [
    Options(optimize=g, target=t) for g in ("balanced", "speed", "size") for t in ("generic", "cortex-m4", "avr")
]
"""The strategies' choices: every seed takes one."""


def examine(spec: Spec, seed: int, n: int) -> list[Measured]:
    """All functions of a spec, ``n`` cases each. AssertionError where anything is not as promised."""
    options = OPTIONS[seed % len(OPTIONS)]
    lowered = spec.lower(options)
    chosen = subjects(spec.module, lowered.program, lowered.certificates)
    files = dict(emit(spec.module, lowered, spec.source, options).files)
    worst: dict[tuple[str, str], float] = {}
    with NativeModule(lowered.program, files) as native:
        assert native.selftest() == 0, "a golden vector differs"
        for subject in chosen:
            for batch in cases(subject, seed, n):
                check_c(subject, native, batch)
                for name, error in check_exact(subject, batch).items():
                    worst[subject.name, name] = max(worst.get((subject.name, name), 0.0), error)
    bounds = {(s.name, o.output): o.error for s in chosen for o in s.certificate.outputs}
    return [
        Measured(f, o, None if bounds[f, o] is None else error / float(bounds[f, o] or 1))
        for (f, o), error in worst.items()
    ]
