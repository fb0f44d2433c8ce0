"""``make prove``: every C that may be chosen for the examples, all benchmarks and ten random specs is proved."""

from __future__ import annotations

import hashlib
import os
import re
import sys
import tempfile
import time
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
DIGEST = re.compile(rb"_SPEC_DIGEST != \w+")


def main() -> int:
    """A line for each C and width of int; 1 where an alarm is left."""
    failed = 0
    with tempfile.TemporaryDirectory() as folder, ProcessPoolExecutor(os.cpu_count()) as workers:
        paths = [*sorted(Path("examples").glob("*.fz")), *sorted(Path("benchmarks").glob("**/*.fz"))]
        for seed in SEEDS:
            paths.append(Path(folder) / f"random{seed}.fz")
            paths[-1].write_text(spec(seed), encoding="utf-8")
        tasks = [workers.submit(proofs_of, path) for path in paths]
        for done in as_completed(tasks):
            for line, ok in done.result():
                failed += not ok
                print(line, flush=True)
    print(f"{failed} not proved" if failed else "all proved")
    return 1 if failed else 0


def proofs_of(path: Path) -> list[tuple[str, bool]]:
    """What was found of each C of one spec, once where goals and targets share it."""
    loaded, seen, found = api.load(path), set[str](), list[tuple[str, bool]]()
    for target in get_args(Target):
        for goal in get_args(Goal):
            options = Options(optimize=goal, target=target)
            files = loaded.compile(options).files
            # The options are told in the first comment, and enter into the digest that header and source share.
            code = DIGEST.sub(b"", files[f"{loaded.name}.c"].partition(b"*/")[2])
            digest = hashlib.sha256(code).hexdigest()
            if digest in seen:
                continue
            seen.add(digest)
            for bits in WIDTHS:
                name, started = f"{path.stem} {target} {goal} int{bits}", time.monotonic()
                try:
                    proof = prove(loaded.lower(options).program, files, bits)
                except AnalyserFailed as error:
                    found.append((f"{name}: {error}", False))
                    continue
                found.append((told(name, proof, time.monotonic() - started), proof.ok))
    return found


def told(name: str, proof: Proof, seconds: float) -> str:
    """One line, and one for each alarm."""
    lemmas = sum(proof.proved.values())
    head = f"{name}: {len(proof.alarms)} alarms, {proof.seen} claims seen, {lemmas} lemmas, {seconds:.0f} s"
    return "\n".join([head, *(f"  {a.function}: {a.kind}: {a.text}" for a in proof.alarms)])


if __name__ == "__main__":
    sys.exit(main())
