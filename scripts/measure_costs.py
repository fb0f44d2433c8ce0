"""Measure the training set of the cost model (``scripts/fit_costs.py`` does it first).

Writes ``benchmarks/measured_costs.json``: per program what the emulator counted, per target and option. A program whose
C and compiler are those of the file is not measured again, so a second run takes what has changed. Needs the compilers
of all targets, unicorn and simavr.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from typing import Any

from fuzzyspec.cost import TARGETS, Conditions, find_compiler, measure
from scripts.cost_training import ROOT, Item

PATH = ROOT / "benchmarks" / "measured_costs.json"
INPUTS = 100
"""The first cases of the stream, per program, target and option."""
FIGURES = (
    "instructions_mean", "instructions_max", "cycles_mean", "cycles_max", "flash", "flash_own", "ram", "stack",
)  # fmt: skip
"""What a row of the file holds, in this order."""


def targets_of(item: Item) -> tuple[str, ...]:
    """A Cortex-M7 has the M4's instructions, so W1 to W3s are enough to see how near they are."""
    if item.widths == "narrow":
        return ("avr",)
    narrow = ("cortex-m0plus", "cortex-m4", "rv32imc")
    return (*narrow, "cortex-m7") if item.every and item.spec.startswith("w") else narrow


def measured(item: Item) -> dict[str, Any]:
    """The record of one program. Raises where its C does not compute what its program does."""
    compilers = tuple(find_compiler(TARGETS[name], "gcc") for name in targets_of(item))
    found = measure(
        item.program, lambda _t, _o: item.files, Conditions(compilers, inputs=INPUTS, only=(item.function,))
    )
    if found.mismatches:
        raise SystemExit(f"{item.name}, {item.strategy}: {found.mismatches[0]}")
    rows = {f"{r.target} {r.option}": [getattr(r, f) for f in FIGURES] for r in found.records}
    return {**head(item), "rows": rows}


def head(item: Item) -> dict[str, Any]:
    """What tells one record from another."""
    return {
        "spec": item.spec,
        "function": item.function,
        "strategy": item.choices,
        "widths": item.widths,
        "every": item.every,
        "code": item.digest,
    }


def compilers() -> dict[str, str]:
    """The compilers by target."""
    return {name: find_compiler(target, "gcc").description for name, target in TARGETS.items()}


def records(wanted: list[Item], known: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """The records of the items in order, those known from before and those measured now."""
    old = {json.dumps({k: v for k, v in r.items() if k != "rows"}): r for r in known.get("records", ())}
    if known.get("compilers") != compilers() or known.get("inputs") != INPUTS:
        old = {}
    missing = [i for i in wanted if json.dumps(head(i)) not in old]
    print(f"{len(wanted)} programs, {len(missing)} to measure", file=sys.stderr)
    with ProcessPoolExecutor(int(os.environ.get("JOBS", "2")), initializer=os.nice, initargs=(10,)) as pool:
        for done, record in enumerate(pool.map(measured, missing, chunksize=4), 1):
            old[json.dumps({k: v for k, v in record.items() if k != "rows"})] = record
            if done % 20 == 0:
                print(f"{done} of {len(missing)}", file=sys.stderr)
    for item in wanted:
        yield old[json.dumps(head(item))]


def as_text(found: list[dict[str, Any]]) -> str:
    """JSON with a line a record, so that a change is seen."""
    lead = {"inputs": INPUTS, "figures": list(FIGURES), "compilers": compilers()}
    lines = ",\n".join(json.dumps(r) for r in found)
    return json.dumps(lead, indent=1)[:-2] + f',\n "records": [\n{lines}\n]}}\n'


def measure_all(wanted: list[Item]) -> dict[str, Any]:
    """Bring the file up to date; what is in it."""
    known = json.loads(PATH.read_text()) if PATH.exists() else {}
    PATH.write_text(as_text(list(records(wanted, known))), newline="\n")
    found: dict[str, Any] = json.loads(PATH.read_text())
    return found
