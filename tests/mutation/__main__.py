"""``make mutants``: the score of verify over all mutants of the generated C (SAMPLE: so many of each file).

Examples, workloads and random specs; for speed on a Cortex-M0+, for size, and for AVR.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from fuzzyspec.lower import Options
from tests.mutation.c_score import Score, score
from tests.random_specs.generator import spec

ROOT = Path(__file__).parents[2]
CHOICES = (
    Options(optimize="speed", target="cortex-m0plus"),
    Options(optimize="size", target="cortex-m0plus"),
    Options(target="avr"),
)
SPECS = (
    "examples/tipper",
    "examples/temperature",
    "examples/nav",
    "benchmarks/w1",
    "benchmarks/w2",
    "benchmarks/w3",
    "benchmarks/w3s",
)
SEEDS = (3, 5, 8)


def subjects() -> Iterator[tuple[str, str]]:
    """Names, and paths or texts."""
    yield from ((name, str(ROOT / f"{name}.fz")) for name in SPECS)
    yield from ((f"random spec {seed}", spec(seed)) for seed in SEEDS)


def main() -> int:
    """Print a line for each file, what is left, and the score of all."""
    parser = argparse.ArgumentParser(prog="make mutants", description=__doc__)
    parser.add_argument("--sample", type=int, default=0, help="mutants of each file; 0: all")
    parser.add_argument("--seed", type=int, default=7, help="of the sample")
    parser.add_argument("--only", default="", help="subjects whose name holds this")
    given = parser.parse_args()
    total = Score()
    for name, text in subjects():
        for options in CHOICES if given.only in name else ():
            found = score(text, options, given.sample or None, given.seed)
            print(f"{name}, {options.optimize}, {options.target}: {found}", *found.left, sep="\n  ", flush=True)
            total += found
    print(f"all: {total}")
    return 0 if total.percent >= 99.0 else 1


if __name__ == "__main__":
    raise SystemExit(main())
