"""Many random specs through everything, and many damaged ones, as many at a time as there are processors:

    python -m tests.random_specs.campaign --specs 1000 --mutants 20000 --seed 0

A damaged one that the checker accepts has to compile, run and keep its bounds. A spec at which something does not hold
is made small and left under ``tests/regressions/``, where it stays a test.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from fuzzyspec.diagnostics.diagnostic import Source
from tests.breaking.mutants import mutant
from tests.breaking.oracle import checked
from tests.random_specs.generator import spec
from tests.random_specs.shrinking import smallest
from tests.random_specs.trial import FULL, LIGHT, Failed, stage, trial

Kind = Literal["spec", "mutant"]
KEPT = Path(__file__).resolve().parents[1] / "regressions"


@dataclass(frozen=True)
class Outcome:
    """What came of a seed: ``why`` is empty where everything held; ``text`` is then the smallest that fails alike."""

    kind: Kind
    seed: int
    tried: bool
    why: str = ""
    text: str = ""


def outcome(task: tuple[Kind, int]) -> Outcome:
    """A seed's spec, sound or damaged, through everything."""
    kind, seed = task
    text = spec(seed) if kind == "spec" else mutant(seed, numbers=0.9 if seed % 2 else 0.3) + "\n"
    try:
        return Outcome(kind, seed, examined(kind, text, seed))
    except Failed as failed:
        where = failed.stage
        return Outcome(kind, seed, True, str(failed), smallest(text, lambda t: fails_alike(kind, t, seed, where)))


def examined(kind: Kind, text: str, seed: int) -> bool:
    """Whether the text is a spec whose numbers go into 32 bits. Raises Failed."""
    if kind == "spec":
        return trial(text, seed, FULL)
    with stage("checker"):
        model, _ = checked(Source("mutant.fz", text))
    return model is not None and trial(text, seed, LIGHT)


def fails_alike(kind: Kind, text: str, seed: int, where: str) -> bool:
    """Whether a text fails at the same stage."""
    try:
        examined(kind, text, seed)
    except Failed as failed:
        return failed.stage == where
    return False


def kept(found: Outcome) -> Path:
    """The file of a failure."""
    stage, _, why = found.why.partition(": ")
    path = KEPT / f"random_{found.seed}.fz"
    path.write_text(
        f"# Of random spec {found.seed}, which failed at: {stage}\n# {why.splitlines()[0][:200]}\n{found.text}"
    )
    return path


def main() -> int:
    """Read the command line; 1 where a spec failed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--specs", type=int, default=1000, help="how many (default: %(default)s)")
    parser.add_argument("--mutants", type=int, default=0, help="how many damaged ones (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of the first; each takes the next (default: 0)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="at a time (default: one a processor)")
    chosen = parser.parse_args()
    begin, refused, failed = time.monotonic(), 0, 0
    tasks: list[tuple[Kind, int]] = [("spec", seed) for seed in range(chosen.seed, chosen.seed + chosen.specs)]
    tasks += [("mutant", seed) for seed in range(chosen.seed, chosen.seed + chosen.mutants)]
    with multiprocessing.Pool(chosen.jobs, maxtasksperchild=20) as pool:
        for done, found in enumerate(pool.imap_unordered(outcome, tasks), 1):
            refused += not found.tried
            if found.why:
                failed += 1
                print(f"{found.kind} {found.seed} FAILED: {found.why}\nmade small: {kept(found)}", flush=True)
            if done % 20 == 0 or done == len(tasks):
                print(f"{done} of {len(tasks)}, {refused} refused, {failed} failed", flush=True)
    print(
        f"{chosen.specs} specs and {chosen.mutants} mutants from seed {chosen.seed}: {time.monotonic() - begin:.0f} s"
    )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
