"""Many random specs through everything, as many at a time as there are processors:

    python -m tests.random_specs.campaign --specs 1000 --seed 0

A spec at which something does not hold is made small and left under ``tests/regressions/``, where it stays a test.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from tests.random_specs.generator import spec
from tests.random_specs.shrinking import smallest
from tests.random_specs.trial import FULL, Failed, trial

KEPT = Path(__file__).resolve().parents[1] / "regressions"


@dataclass(frozen=True)
class Outcome:
    """What came of a seed: ``why`` is empty where everything held; ``text`` is then the smallest that fails alike."""

    seed: int
    tried: bool
    why: str = ""
    text: str = ""


def outcome(seed: int) -> Outcome:
    """A seed's spec through everything."""
    text = spec(seed)
    try:
        return Outcome(seed, trial(text, seed, FULL))
    except Failed as failed:
        stage = failed.stage
        return Outcome(seed, True, str(failed), smallest(text, lambda t: fails_alike(t, seed, stage)))


def fails_alike(text: str, seed: int, stage: str) -> bool:
    """Whether a text fails at the same stage."""
    try:
        trial(text, seed, FULL)
    except Failed as failed:
        return failed.stage == stage
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
    parser.add_argument("--seed", type=int, default=0, help="of the first; each takes the next (default: 0)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="at a time (default: one a processor)")
    chosen = parser.parse_args()
    begin, refused, failed = time.monotonic(), 0, 0
    seeds = range(chosen.seed, chosen.seed + chosen.specs)
    with multiprocessing.Pool(chosen.jobs, maxtasksperchild=20) as pool:
        for done, found in enumerate(pool.imap_unordered(outcome, seeds), 1):
            refused += not found.tried
            if found.why:
                failed += 1
                print(f"seed {found.seed} FAILED: {found.why}\nmade small: {kept(found)}", flush=True)
            if done % 20 == 0 or done == len(seeds):
                print(f"{done} of {len(seeds)} specs, {refused} refused, {failed} failed", flush=True)
    print(f"seeds {seeds.start} to {seeds.stop - 1}: {time.monotonic() - begin:.0f} s")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
