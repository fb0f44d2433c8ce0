"""``make prove``: every C that may be chosen for the examples, all benchmarks and ten random specs is proved.

``make prove SPECS="nav w3"`` takes some of them.
"""

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


def main(names: list[str]) -> int:
    """A line for each C and width of int; 1 where an alarm is left. ``names``: the specs by file name, all if none."""
    failed = 0
    with tempfile.TemporaryDirectory() as folder, ProcessPoolExecutor(os.cpu_count()) as workers:
        paths = [*sorted(Path("examples").glob("*.fz")), *sorted(Path("benchmarks").glob("**/*.fz"))]
        for seed in SEEDS:
            paths.append(Path(folder) / f"random{seed}.fz")
            paths[-1].write_text(spec(seed), encoding="utf-8")
        builds = [workers.submit(builds_of, path) for path in paths if path.stem in names or not names]
        proofs = [
            workers.submit(proof_of, *of, bits) for b in as_completed(builds) for of in b.result() for bits in WIDTHS
        ]
        for done in as_completed(proofs):
            line, ok = done.result()
            failed += not ok
            print(line, flush=True)
    print(f"{failed} of {len(proofs)} not proved" if failed or not proofs else f"all {len(proofs)} proved")
    return 1 if failed or not proofs else 0


def builds_of(path: Path) -> list[tuple[Path, Options]]:
    """Each C of one spec, once where goals and targets share it."""
    loaded, found = api.load(path), dict[str, Options]()
    for target in get_args(Target):
        for goal in get_args(Goal):
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
