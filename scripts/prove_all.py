"""``make prove``: the C of the examples, all benchmarks and ten random specs is proved, as compiled by default.

``make prove-choices``: every C that goals and targets choose for them. ``SPECS="nav w3"`` takes some of the specs.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import get_args

from fuzzyspec import api
from fuzzyspec.lower import Options
from fuzzyspec.lower.strategy import Goal, Target
from fuzzyspec.prove import WIDTHS, Proof, prove
from fuzzyspec.prove.eva import AnalyserFailed
from tests.random_specs.generator import spec

SEEDS = range(10)
CHOICES = "--choices"
DIGEST = re.compile(rb"_SPEC_DIGEST != \w+")


def main(words: list[str]) -> int:
    """A line for each C and width of int; 1 where an alarm is left. ``words``: ``--choices``, and specs by name."""
    failed, names = 0, [w for w in words if w != CHOICES]
    targets, goals = (
        (get_args(Target), get_args(Goal)) if CHOICES in words else ((Options().target,), (Options().optimize,))
    )
    with tempfile.TemporaryDirectory() as folder, ProcessPoolExecutor(os.cpu_count()) as workers:
        paths = [*sorted(Path("examples").glob("*.fz")), *sorted(Path("benchmarks").glob("**/*.fz"))]
        for seed in SEEDS:
            paths.append(Path(folder) / f"random{seed}.fz")
            paths[-1].write_text(spec(seed), encoding="utf-8")
        builds = [workers.submit(builds_of, path, targets, goals) for path in paths if path.stem in names or not names]
        proofs = [
            workers.submit(proof_of, *of, bits) for b in as_completed(builds) for of in b.result() for bits in WIDTHS
        ]
        for done in as_completed(proofs):
            line, ok = done.result()
            failed += not ok
            print(line, flush=True)
    print(f"{failed} of {len(proofs)} not proved" if failed or not proofs else f"all {len(proofs)} proved")
    return 1 if failed or not proofs else 0


def builds_of(path: Path, targets: Sequence[Target], goals: Sequence[Goal]) -> list[tuple[Path, Options]]:
    """Each C of one spec, once where goals and targets share it."""
    loaded, found = api.load(path), dict[str, Options]()
    for target in targets:
        for goal in goals:
            options = Options(optimize=goal, target=target)
            source = loaded.compile(options).files[f"{loaded.name}.c"]
            # The options are told in the first comment, and enter into the digest that header and source share.
            code = DIGEST.sub(b"", source.partition(b"*/")[2])
            found.setdefault(hashlib.sha256(code).hexdigest(), options)
    return [(path, options) for options in found.values()]


def proof_of(path: Path, options: Options, bits: int) -> tuple[str, bool]:
    """What was found of one C, and whether nothing is left."""
    loaded, started = api.load(path), time.monotonic()
    name = f"{path.stem} {options.target} {options.optimize} int{bits}"
    try:
        proof = prove(loaded.lower(options).program, loaded.compile(options).files, bits)
    except AnalyserFailed as error:
        return f"{name}: {error}", False
    return told(name, proof, time.monotonic() - started), proof.ok


def told(name: str, proof: Proof, seconds: float) -> str:
    """One line, and one for each alarm."""
    lemmas = sum(proof.proved.values())
    head = f"{name}: {len(proof.alarms)} alarms, {proof.seen} claims seen, {lemmas} lemmas, {seconds:.0f} s"
    return "\n".join([head, *(f"  {a.function}: {a.kind}: {a.text}" for a in proof.alarms)])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
