"""One function on the bench: batches go through C, the integer program and the exact meaning; failures are shrunk."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from fuzzyspec.fixed.run import Run
from fuzzyspec.model.variable import Variable
from fuzzyspec.native import Death, NativeModule, NativeProcess, Result
from fuzzyspec.verify.cases import Batch
from fuzzyspec.verify.confirm import beyond_band, beyond_bound
from fuzzyspec.verify.example import example_at, single, spoken
from fuzzyspec.verify.report import Difference, Failure, FailureKind
from fuzzyspec.verify.runner import Runner, any_of, differing
from fuzzyspec.verify.shrink import shrink
from fuzzyspec.verify.subject import Subject
from fuzzyspec.verify.tally import Tally, signed_errors

BLOCK = 1 << 14
"""Cases that are hashed together."""
SANITIZED = 1 << 10
"""Cases of each batch that also go through the sanitizers."""


@dataclass
class Bench:
    """Mutable while a verification runs. Of each kind of failure the first is kept, made small."""

    subject: Subject
    c: Runner | None
    sanitized: Runner | None
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
        self._through_c(batch, run)
        self._through_sanitizers(batch)
        return self._through_exact(batch, run)

    # --- C --------------------------------------------------------------------------------------

    def _through_c(self, batch: Batch, run: Run) -> None:
        if self.c is None:
            return
        got = self.c.run(self.subject.name, batch.inputs, batch.state)
        if isinstance(got, Death):
            self._died(batch, got, self.c, "")
            self.c = None
            return
        masks = differing(got, run)
        differs = any_of(masks, batch.n)
        self.tally.add_c(batch, masks, differs)
        if differs.any() and not self._has("c"):
            self._differs(batch, int(differs.argmax()), self.c, "")

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
            self._died(batch, Death(case, got.what, got.output), theirs, "")
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
            self._died(part, got, self.sanitized, " under the sanitizers")
            self.sanitized = None
            return
        self.tally.sanitized += part.n
        differs = any_of(differing(got, self.subject.fixed(part.inputs, part.state)), part.n)
        if differs.any() and not self._has("c"):
            self._differs(part, int(differs.argmax()), self.sanitized, " under the sanitizers")

    def _differs(self, batch: Batch, at: int, runner: Runner, where: str) -> None:
        """Shrink a case at which C and model differ, and keep the failure."""

        def fails(candidates: Batch) -> int | None:
            got = runner.run(self.subject.name, candidates.inputs, candidates.state)
            if isinstance(got, Death):
                return None
            run = self.subject.fixed(candidates.inputs, candidates.state)
            differs = any_of(differing(got, run), candidates.n)
            return int(differs.argmax()) if differs.any() else None

        small = shrink(self.subject, single(batch, at), fails)
        got = runner.run(self.subject.name, small.inputs, small.state)
        assert isinstance(got, Result)
        run = self.subject.fixed(small.inputs, small.state)
        differences = _differences(self.subject, got, run)
        self._keep("c", f"the C differs from the integer program{where}", small, differences)

    def _died(self, batch: Batch, death: Death, runner: Runner, where: str) -> None:
        """Shrink a case at which C dies. A hang is shown as found: each try would cost its time limit."""
        case = single(batch, death.case)

        def fails(candidates: Batch) -> int | None:
            got = runner.run(self.subject.name, candidates.inputs, candidates.state)
            return got.case if isinstance(got, Death) else None

        small = case if death.what.startswith("no end") or fails(case) is None else shrink(self.subject, case, fails)
        self._keep("death", f"the C did not return{where}: {death.what}", small, (), death.output)

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
        self._keep(kind, message, small, (seen[-1],))

    # --- failures -------------------------------------------------------------------------------

    def _has(self, kind: FailureKind) -> bool:
        return any(f.kind == kind for f in self.failures)

    def _keep(
        self, kind: FailureKind, message: str, case: Batch, differences: tuple[Difference, ...], output: str = ""
    ) -> None:
        example = example_at(self.subject, case, 0)
        self.failures.append(Failure(kind, self.subject.name, message, example, differences, output))


def _differences(subject: Subject, got: Result, run: Run) -> tuple[Difference, ...]:
    """What differs at the first case, with values where there are some."""
    found: list[Difference] = []
    variables = {p.name: p.variable for p in subject.function.outputs}
    for name, wanted in run.outputs.items():
        if got.outputs[name][0] != wanted[0]:
            variable = variables[name]
            found.append(Difference(name, *(_told(variable, int(r)) for r in (wanted[0], got.outputs[name][0]))))
    if got.status[0] != run.status[0]:
        bits = [b.name for b in subject.function.status]
        found.append(Difference("status", *(_bits(bits, int(s)) for s in (run.status[0], got.status[0]))))
    for key in got.state:
        if got.state[key][0] != run.state[key][0]:
            variable = subject.state[key].variable
            both = (run.state[key][0], got.state[key][0])
            found.append(Difference(f"state {key}", *(_told(variable, int(r)) for r in both)))
    return tuple(found)


def _told(variable: Variable | None, raw: int) -> str:
    return f"{raw}" if variable is None else f"{raw} ({spoken(variable, raw)})"


def _bits(names: list[str], status: int) -> str:
    """A status word by the names of its bits."""
    known = [name for i, name in enumerate(names) if status >> i & 1]
    return " | ".join(known or ["OK"]) if status >> len(names) == 0 else f"{status:#x}"
