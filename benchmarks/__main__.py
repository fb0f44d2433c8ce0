"""``python -m benchmarks``: measure everything, write docs/benchmarks.md and its plot (``make bench``)."""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

from benchmarks.own import WrongResult
from benchmarks.page import PLOT, page
from benchmarks.plot import drawn
from benchmarks.results import Results, as_json, from_json
from benchmarks.run import Plan, run
from benchmarks.workloads import ROOT, WORKLOADS
from fuzzyspec.cost import EmulationError
from fuzzyspec.diagnostics.refusal import Refusal

TARGETS = ("cortex-m0plus", "cortex-m4", "rv32imc", "avr")


def main(words: list[str] | None = None) -> int:
    """0 measured, 1 something computed the wrong thing, 2 a tool is missing."""
    arguments = _parser().parse_args(words)
    names = arguments.workload or [w.name for w in WORKLOADS]
    plan = Plan(
        workloads=tuple(w for w in WORKLOADS if w.name in names),
        targets=tuple(dict.fromkeys(arguments.target or TARGETS)),
        compiler=arguments.compiler,
        jobs=arguments.jobs,
        peers=not arguments.no_peers,
        short=arguments.short,
    )
    start = time.monotonic()

    def told(what: str) -> None:
        print(f"{time.monotonic() - start:6.1f} s  {what}", flush=True)

    try:
        results = _read(arguments.again) if arguments.again else run(plan, told)
    except Refusal as error:
        print(f"benchmarks: {error}", file=sys.stderr)
        return 2
    except (WrongResult, EmulationError) as error:
        print(f"benchmarks: not what it should be: {error}", file=sys.stderr)
        return 1
    _write(results, Path(arguments.docs), arguments.json)
    told(f"wrote {arguments.docs}/benchmarks.md")
    return 0


def _read(figures: str) -> Results:
    return from_json(json.loads(Path(figures).read_text(encoding="utf-8")))


def _write(results: Results, docs: Path, figures: str | None) -> None:
    docs.mkdir(parents=True, exist_ok=True)
    (docs / "benchmarks.md").write_text(page(results), encoding="utf-8", newline="\n")
    (docs / PLOT).write_bytes(drawn(results))
    if figures is not None:
        Path(figures).parent.mkdir(parents=True, exist_ok=True)
        Path(figures).write_text(json.dumps(as_json(results), indent=2) + "\n", encoding="utf-8")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--docs", default=str(ROOT / "docs"), help="write the page and the plot here (default: docs)")
    parser.add_argument("--json", metavar="FILE", help="write all figures here too")
    parser.add_argument("--again", metavar="FILE", help="measure nothing: write what --json wrote once more")
    parser.add_argument(
        "--workload", action="append", choices=[w.name for w in WORKLOADS], help="only this; may be repeated"
    )
    parser.add_argument("--target", action="append", choices=TARGETS, help="only this; may be repeated")
    parser.add_argument("--compiler", choices=("gcc", "zig"), help="default: gcc where it is found")
    parser.add_argument(
        "--jobs", type=int, default=0, help="processes (default: as many as there are cores, 4 at most)"
    )
    parser.add_argument("--no-peers", action="store_true", help="leave other people's libraries out")
    parser.add_argument(
        "--short", action="store_true", help="few inputs: shows that everything runs, not what it costs"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
