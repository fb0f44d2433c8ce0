"""Every input that there is: C against the integer program, on all processors, to be interrupted and gone on with.

The exact meaning takes longer: it is held to at every input where these are few, else at a share of each block.
"""

from __future__ import annotations

import contextlib
import os
import queue
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from fuzzyspec.diagnostics.refusal import Refusal
from fuzzyspec.native import Death
from fuzzyspec.verify.bench import Bench
from fuzzyspec.verify.example import single
from fuzzyspec.verify.points import Raws
from fuzzyspec.verify.runner import Runner, any_of, differing
from fuzzyspec.verify.space import Space, space_of, spoken_count
from fuzzyspec.verify.steps import Steps
from fuzzyspec.verify.subject import Subject
from fuzzyspec.verify.swept import BlockFound, Swept
from fuzzyspec.verify.tally import Tally, errors_of

LIMIT = 1 << 32
"""The most inputs that are swept."""
BLOCK = 1 << 20
"""Inputs that are kept account of together."""
SLICE = 1 << 16
"""Inputs that go through C and integer program at once."""
EXACT = 1 << 24
"""Inputs of a function that also go through the exact meaning, about; all of them where there are no more."""


_SUSPECTS = 256
"""Inputs of a slice that are looked at again, in rationals, where float64 puts them beyond a bound."""


class Keeper(Protocol):
    """Keeps what was swept, by function."""

    def load(self, key: Mapping[str, str]) -> Mapping[str, Swept]:
        """What was kept under this key, nothing if there is nothing. Refusal where it was kept under another."""
        ...

    def save(self, swept: Mapping[str, Swept], *, last: bool) -> None: ...


@dataclass(frozen=True, slots=True)
class Sweep:
    """``keeper``: where to go on from, and to keep how far it came. ``begin`` is told how many inputs are left and the
    seconds that these will take, about, on how many processors."""

    keeper: Keeper | None = None
    begin: Callable[[int, float, int], None] | None = None
    processors: int = field(default_factory=lambda: os.cpu_count() or 1)


def spaces(subjects: Sequence[Subject]) -> tuple[Space, ...]:
    """All inputs of each function. Refusal where one has more than can be swept, saying how many."""
    found = tuple(space_of(s) for s in subjects)
    beyond = [s for s in found if s.inputs > LIMIT]
    if beyond:
        told = ", ".join(f"{s.subject.name} has {spoken_count(s.inputs)} inputs" for s in beyond)
        rest = [f"--only {s.subject.name}" for s in found if s.inputs <= LIMIT]
        way_out = f"sweep what has fewer: {' '.join(rest)}" if rest else "verify without --exhaustive"
        raise Refusal(f"at most {LIMIT:,} inputs can be swept, but {told}", way_out)
    return found


def exhaust(
    benches: Sequence[Bench],
    runners: Callable[[], contextlib.AbstractContextManager[Runner]],
    sweep: Sweep,
    steps: Steps,
    key: Mapping[str, str],
) -> tuple[str, ...]:
    """Sweep the functions on the benches; notes on what was held to the exact meaning. A failure ends the sweep.

    ``runners`` makes a runner of the C for one processor; ``key`` tells what is swept from what once was.
    """
    kept = sweep.keeper.load({**key, "block": str(BLOCK)}) if sweep.keeper is not None else {}
    swept = {b.subject.name: Swept() for b in benches} | dict(kept)
    before = {name: s.blocks for name, s in swept.items()}
    with contextlib.ExitStack() as stack:
        free: queue.SimpleQueue[Runner] = queue.SimpleQueue()
        for _ in range(sweep.processors):
            free.put(stack.enter_context(runners()))
        pool = stack.enter_context(_pool(sweep.processors))
        try:
            _begin(benches, swept, sweep, free)
            for bench in benches:
                space, done = space_of(bench.subject), swept[bench.subject.name]
                steps.add(min(done.blocks * BLOCK, space.inputs), bench.subject.name)
                for found in _blocks(space, done, free, pool, sweep.processors):
                    if found.failed:
                        closer = Bench(bench.subject, bench.c, None)
                        closer.put(space.batch(np.array(found.failed, dtype=np.int64)))
                        bench.failures += closer.failures
                    if bench.failures:
                        break
                    done.add(found)
                    steps.add(min(BLOCK, space.inputs - found.block * BLOCK), bench.subject.name)
                    if sweep.keeper is not None:
                        sweep.keeper.save(swept, last=False)
                _tell(bench.tally, space, done)
                if bench.failures:
                    break
        finally:
            if sweep.keeper is not None:
                sweep.keeper.save(swept, last=True)
    return tuple(_note(space_of(b.subject), swept[b.subject.name], before[b.subject.name]) for b in benches)


@contextlib.contextmanager
def _pool(processors: int) -> Iterator[ThreadPoolExecutor]:
    """A pool that drops what has not begun when it is left."""
    pool = ThreadPoolExecutor(processors)
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def _begin(benches: Sequence[Bench], swept: Mapping[str, Swept], sweep: Sweep, free: queue.SimpleQueue[Runner]) -> None:
    """Time a slice of every function that is not done, and say what is left."""
    if sweep.begin is None:
        return
    left, seconds = 0, 0.0
    for bench in benches:
        space = space_of(bench.subject)
        rest = max(0, space.inputs - swept[bench.subject.name].blocks * BLOCK)
        if rest:
            n = min(SLICE, space.inputs)
            runner = free.get()
            start = time.perf_counter()
            _inspect(space, runner, 0, np.arange(n), _share(space, n))
            seconds += (time.perf_counter() - start) * rest / n
            free.put(runner)
            left += rest
    if left:
        sweep.begin(left, seconds / sweep.processors, sweep.processors)


def _blocks(
    space: Space, done: Swept, free: queue.SimpleQueue[Runner], pool: ThreadPoolExecutor, processors: int
) -> Iterator[BlockFound]:
    """The blocks that are missing, as they come to their ends; never many more begun than there are processors."""
    missing = done.missing(-(-space.inputs // BLOCK))
    running: set[Future[BlockFound]] = set()

    def work(block: int) -> BlockFound:
        runner = free.get()
        try:
            first = block * BLOCK
            numbers = np.arange(first, min(first + BLOCK, space.inputs))
            return _inspect(space, runner, block, numbers, _share(space, len(numbers)))
        finally:
            free.put(runner)

    while True:
        for block in missing:
            running.add(pool.submit(work, block))
            if len(running) >= 2 * processors:
                break
        if not running:
            return
        ended, running = wait(running, return_when=FIRST_COMPLETED)
        yield from (future.result() for future in ended)


def _share(space: Space, n: int) -> int:
    """How many of n inputs go through the exact meaning."""
    return n if space.inputs <= EXACT else max(1, n * EXACT // space.inputs)


def _inspect(space: Space, runner: Runner, block: int, numbers: Raws, share: int) -> BlockFound:
    """One block through C and integer program, and ``share`` of it through the exact meaning."""
    subject = space.subject
    for at in range(0, len(numbers), SLICE):
        part = numbers[at : at + SLICE]
        batch = space.batch(part)
        got = runner.run(subject.name, batch.inputs, batch.state)
        if isinstance(got, Death):
            return BlockFound(block, 0, {}, {}, (int(part[got.case]),))
        differs = any_of(differing(got, subject.fixed(batch.inputs, batch.state)), batch.n)
        if differs.any():
            return BlockFound(block, 0, {}, {}, (int(part[differs.argmax()]),))
    # Of every block other inputs, but the same whenever and wherever it is swept.
    chosen = numbers if share >= len(numbers) else np.sort(np.random.default_rng(block).choice(numbers, share, False))
    tally = Tally(subject)
    largest: dict[str, tuple[float, int]] = {}
    failed: list[int] = []
    for at in range(0, len(chosen), SLICE):
        part = chosen[at : at + SLICE]
        batch = space.batch(part)
        run = subject.fixed(batch.inputs, batch.state, record=True)
        exact = subject.exact(batch.inputs, batch.state, run.decisions)
        for beyond in tally.add_exact(batch, run, exact):
            failed += [int(part[lane]) for lane in np.flatnonzero(beyond)[:_SUSPECTS]]
        for name, errors in errors_of(subject, run, exact).items():
            worst = int(errors.argmax())
            if errors[worst] > largest.get(name, (-1.0, 0))[0]:
                largest[name] = (float(errors[worst]), int(part[worst]))
    decisions = {k: (d.taken, d.disagreed, d.largest) for k, d in tally.decisions.items()}
    return BlockFound(block, len(chosen), largest, decisions, tuple(failed))


def _tell(tally: Tally, space: Space, done: Swept) -> None:
    """Add what was swept to a function's account."""
    inputs = min(done.blocks * BLOCK, space.inputs)
    tally.add_swept(
        inputs,
        done.compared,
        {k: (e, single(space.batch(np.array([n], dtype=np.int64)), 0)) for k, (e, n) in done.largest.items()},
        done.decisions,
    )


def _note(space: Space, done: Swept, before: int) -> str:
    """How much of a function was swept, and how much of that held to the exact meaning."""
    inputs = min(done.blocks * BLOCK, space.inputs)
    every = "every input" if inputs == space.inputs else f"{inputs:,} of {space.inputs:,} inputs"
    exact = "the exact meaning too" if done.compared == inputs else f"the exact meaning at {done.compared:,} of them"
    earlier = f"; {min(before * BLOCK, inputs):,} of them in an earlier run" if before else ""
    return f"{space.subject.name}: {every} went through C and integer program, {exact}{earlier}"
