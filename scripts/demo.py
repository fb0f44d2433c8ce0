"""The way from a spec to driving robots: compile, verify, run, and the result in five lines.

Usage: demo.py DIR. Everything is written below DIR; what each command found lies there as JSON too.
"""

from __future__ import annotations

import json
import subprocess
import sys
from decimal import ROUND_CEILING, Decimal
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
SPEC = "examples/nav.fz"


def fuzzyc(*words: str, into: Path | None = None) -> None:
    """Show a command and run it; its JSON goes ``into`` a file. A failure ends the demo with the command's status."""
    print(f"$ fuzzyc {' '.join(words)}", flush=True)
    as_json = ("--format", "json") if into is not None else ()
    stdout = subprocess.PIPE if into is not None else None
    done = subprocess.run([sys.executable, "-m", "fuzzyspec", *words, *as_json], cwd=ROOT, stdout=stdout, check=False)
    if into is not None:
        into.parent.mkdir(parents=True, exist_ok=True)
        into.write_bytes(done.stdout)
    if done.returncode != 0:
        sys.stderr.write("" if into is None else into.read_text(encoding="utf-8"))
        sys.exit(done.returncode)
    if into is None:
        print(flush=True)


def up(percent: float) -> str:
    """A bound with two digits, never rounded down."""
    value = Decimal(percent)
    return f"{value.quantize(Decimal((0, (1,), value.adjusted() - 1)), ROUND_CEILING)} %"


def summary(verified: dict[str, Any], driven: dict[str, Any]) -> list[str]:
    """Four of the five lines, from what ``verify`` and ``sim`` found."""
    system = next(f for f in verified["functions"] if f["kind"] == "system")
    bounds = [
        f"{o['output']} {'none' if o['bound_percent'] is None else up(o['bound_percent'])}"
        for o in system["outputs"]
        if o["largest_error"] is not None  # a behavior's code has no error
    ]
    mismatches = sum(f[f"{what}mismatches"] for f in verified["functions"] for what in ("", "status_", "state_"))
    by_c = next(run for run in driven["runs"] if run["controller"] == "c")
    arrivals = [f"{robot['name']} after {robot['arrived']:.1f} s" for robot in by_c["robots"]]
    gap = by_c["clearance"]
    return [
        f"certified errors  {', '.join(bounds)} (of range)",
        f"cases compared    {verified['cases']:,}: C and integer model bit for bit, {mismatches} mismatches",
        f"arrivals          {', '.join(arrivals)}",
        f"clearance         {gap['distance']:.2f} m at {gap['time']:.1f} s",
    ]


def story(driven: dict[str, Any]) -> list[str]:
    """Which behavior drove each robot, and when."""
    by_c = next(run for run in driven["runs"] if run["controller"] == "c")
    return [
        f"{robot['name']}: "
        + ", ".join(f"{e['behavior']} {e['start']:.0f} to {e['end']:.0f} s" for e in robot["episodes"])
        for robot in by_c["robots"]
    ]


def main() -> None:
    """Run the demo."""
    out = Path(sys.argv[1])
    nav, robots = out / "nav", out / "two_robots"
    found, drove = ROOT / nav / "verify.json", ROOT / robots / "run.json"
    fuzzyc("check", SPEC)
    fuzzyc("compile", SPEC, "-o", str(nav))
    fuzzyc("verify", SPEC, into=found)
    verified = json.loads(found.read_bytes())
    print(*(f"{f['kind']} {f['function']}: {f['cases']:,} cases" for f in verified["functions"]), "", sep="\n")
    fuzzyc("sim", "two_robots", "--spec", SPEC, "-o", str(robots), into=drove)
    driven = json.loads(drove.read_bytes())
    print(*story(driven), "", sep="\n")
    print(
        *summary(verified, driven),
        f"files             {nav}: the C and verify.json; {robots}: pictures, CSV and run.json",
        sep="\n",
    )


if __name__ == "__main__":
    main()
