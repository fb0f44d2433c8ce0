"""One function on the bench: batches go through C, the integer program and the exact meaning; failures are shrunk."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from fuzzyspec.fixed.run import Run
from fuzzyspec.native import Death, NativeModule, NativeProcess
from fuzzyspec.verify.cases import Batch
from fuzzyspec.verify.confirm import beyond_band, beyond_bound
from fuzzyspec.verify.example import example_at, single
from fuzzyspec.verify.report import Difference, Failure, FailureKind
from fuzzyspec.verify.runner import Runner, any_of, differing
from fuzzyspec.verify.sample import Sample
from fuzzyspec.verify.shrink import shrink
from fuzzyspec.verify.subject import Subject
from fuzzyspec.verify.tally import Tally, signed_errors
from fuzzyspec.verify.witness import death, difference

BLOCK = 1 << 14
"""Cases that are hashed together."""
SANITIZED = 1 << 10
"""Cases of each batch that also go through the sanitizers."""


@dataclass
class Bench:
    """Mutable while a verification runs. Of each kind of failure the first is kept, made small.

    ``sample`` keeps the cases that other machines are to run.
    """

    subject: Subject
    c: Runner | None
    sanitized: Runner | None
    sample: Sample | None = None
    tally: Tally = field(init=False)
    failures: list[Failure] = field(default_factory=list)
    _state: dict[str, npt.NDArray[np.int64]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.tally = Tally(self.subject)

    def put(self, batch: Batch) -> dict[str, npt.NDArray[np.float64]]:
        """Run one batch through everything; the errors that it had, with their signs, by output."""
        if batch.follow:
            batch = Batch(batch.kind, batch.inputs, dict(self._state))
        run = self.subject.fixed(batch.inputs, batch.state, record=True)
        self._state = run.state
        if self.sample is not None:
            self.sample.add(batch, run)
        self._through_c(batch, run)
        self._through_sanitizers(batch)
        return self._through_exact(batch, run)

    # --- C --------------------------------------------------------------------------------------

    def _through_c(self, batch: Batch, run: Run) -> None:
        if self.c is None:
            return
        got = self.c.run(self.subject.name, batch.inputs, batch.state)
        if isinstance(got, Death):
            self.failures.append(death(self.subject, batch, got, self.c))
            self.c = None
            return
        masks = differing(got, run)
        differs = any_of(masks, batch.n)
        self.tally.add_c(batch, masks, differs)
        if differs.any() and not self._has("c"):
            self.failures.append(difference(self.subject, single(batch, int(differs.argmax())), self.c))

    def in_bulk(self, theirs: NativeProcess, reference: NativeModule, seed: int, blocks: range) -> None:
        """Hold a C to the generated one by the hashes of many cases: the model would take too long for them."""
        if self.c is None or self._has("c"):
            return
        name = self.subject.name
        wanted = reference.hashes(name, seed, blocks, BLOCK)
        got = theirs.hashes(name, seed, blocks, BLOCK)
        if isinstance(got, Death):
            block, case = divmod(got.case, BLOCK)
            batch = Batch("bulk", *reference.block(name, seed, blocks[block], BLOCK))
            self.failures.append(death(self.subject, batch, Death(case, got.what, got.output), theirs))
            self.c = None
            return
        self.tally.add_bulk(len(blocks) * BLOCK)
        for block, one, other in zip(blocks, wanted, got, strict=True):
            if one != other:
                batch = Batch("bulk", *reference.block(name, seed, block, BLOCK))
                self._through_c(batch, self.subject.fixed(batch.inputs, batch.state))
                return

    def _through_sanitizers(self, batch: Batch) -> None:
        if self.sanitized is None:
            return
        step = max(1, batch.n // SANITIZED)
        part = Batch(
            batch.kind,
            {k: v[::step] for k, v in batch.inputs.items()},
            {k: v[::step] for k, v in batch.state.items()},
        )
        got = self.sanitized.run(self.subject.name, part.inputs, part.state)
        if isinstance(got, Death):
            self.failures.append(death(self.subject, part, got, self.sanitized, " under the sanitizers"))
            self.sanitized = None
            return
        self.tally.sanitized += part.n
        differs = any_of(differing(got, self.subject.fixed(part.inputs, part.state)), part.n)
        if differs.any() and not self._has("c"):
            case = single(part, int(differs.argmax()))
            self.failures.append(difference(self.subject, case, self.sanitized, " under the sanitizers"))

    # --- the exact meaning ----------------------------------------------------------------------

    def _through_exact(self, batch: Batch, run: Run) -> dict[str, npt.NDArray[np.float64]]:
        exact = self.subject.exact(batch.inputs, batch.state, run.decisions)
        bound, band = self.tally.add_exact(batch, run, exact)
        if bound.any() and not self._has("bound"):
            found = beyond_bound(self.subject, batch, run, exact, bound)
            if found is not None:
                at, difference = found
                self._beyond("bound", single(batch, at), difference, "an error is beyond its certified bound")
        if band.any() and not self._has("band"):
            found = beyond_band(self.subject, batch, run, exact, band)
            if found is not None:
                at, difference = found
                self._beyond("band", single(batch, at), difference, "a decision differs outside its certified band")
        return signed_errors(self.subject, run, exact)

    def _beyond(self, kind: FailureKind, case: Batch, difference: Difference, message: str) -> None:
        seen = [difference]

        def fails(candidates: Batch) -> int | None:
            run = self.subject.fixed(candidates.inputs, candidates.state, record=True)
            exact = self.subject.exact(candidates.inputs, candidates.state, run.decisions)
            everywhere = np.ones(candidates.n, dtype=np.bool_)
            look = beyond_bound if kind == "bound" else beyond_band
            found = look(self.subject, candidates, run, exact, everywhere)
            if found is None:
                return None
            seen.append(found[1])
            return found[0]

        small = shrink(self.subject, case, fails)
        example = example_at(self.subject, small, 0)
        self.failures.append(Failure(kind, self.subject.name, message, example, (seen[-1],)))

    # --- failures -------------------------------------------------------------------------------

    def _has(self, kind: FailureKind) -> bool:
        return any(f.kind == kind for f in self.failures)
