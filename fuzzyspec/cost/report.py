"""Measured costs as text and as JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import groupby
from typing import Any

from fuzzyspec.cost.budgets import Verdict, as_data, as_lines
from fuzzyspec.cost.measure import Conditions, Measured, Mismatch, Record
from fuzzyspec.estimate.inputs import SEED

_HEADS = (
    *("target", "option", "limit", "instructions", "largest", "derived", "limit", "cycles", "largest", "derived"),
    *("flash", "library", "RAM", "stack"),
)
BUG = "this is a defect of fuzzyc, please report it"
_LEFT = 2
"""Columns of words, which are set flush left."""


def as_json(
    module: str,
    conditions: Conditions,
    measured: Measured,
    missing: Mapping[str, str],
    verdicts: Sequence[Verdict] = (),
) -> dict[str, Any]:
    """One record per target, option and function; ``missing`` gives the way out by target that could not be built."""
    return {
        "ok": measured.ok and all(v.met is not False for v in verdicts),
        "module": module,
        "inputs": conditions.inputs,
        "seed": SEED,
        "records": [asdict(r) for r in measured.records],
        "budgets": [as_data(v) for v in verdicts],
        "mismatches": [asdict(m) for m in measured.mismatches],
        "missing": dict(missing),
    }


def as_text(
    module: str,
    conditions: Conditions,
    measured: Measured,
    missing: Mapping[str, str],
    verdicts: Sequence[Verdict] = (),
) -> str:
    """A table a function, what comes of the budgets, and what the figures mean."""
    n = conditions.inputs
    lines = [
        f"{module}: mean and largest over {n} inputs that were tried, which is no worst case;",
        "limit: the operations that such a controller needs, counted;",
        "derived: the longest path through the built code, which no call exceeds",
        "",
    ]
    by_function = sorted(measured.records, key=lambda r: _order(measured.records).index(r.function))
    for name, group in groupby(by_function, key=lambda r: r.function):
        lines += [name, *_table(list(group)), ""]
    lines += as_lines(verdicts)
    lines += _notes(measured.records)
    lines += [f"not measured: {target} ({why})" for target, why in missing.items()]
    lines += [line for mismatch in measured.mismatches for line in describe(mismatch)]
    lines += [f"EXCEEDED: {_of(r)} took more than the worst case derived: {BUG}" for r in measured.records if r.exceeds]
    return "\n".join(lines)


def describe(mismatch: Mismatch) -> list[str]:
    """A mismatch, so that it can be tried again."""
    m = mismatch
    given = " ".join(f"{k}={v}" for k, v in m.inputs.items())
    return [
        f"NOT EQUAL: {m.function} on {m.target} -{m.option}, input {m.case}: "
        f"{m.what} is {m.got}, the integer program says {m.wanted}",
        f"    at raws {given}",
    ]


def _order(records: Sequence[Record]) -> list[str]:
    return list(dict.fromkeys(r.function for r in records))


def _table(records: Sequence[Record]) -> list[str]:
    rows = [_HEADS, *(_row(r) for r in records)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(_HEADS))]
    return [
        "  "
        + "  ".join(
            cell.ljust(width) if i < _LEFT else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def _row(r: Record) -> tuple[str, ...]:
    return (
        r.target,
        f"-{r.option}",
        _whole(r.instructions_limit),
        _mean(r.instructions_mean),
        _whole(r.instructions_max),
        _whole(r.instructions_worst),
        _whole(r.cycles_limit),
        _mean(r.cycles_mean),
        _whole(r.cycles_max),
        _whole(r.cycles_worst),
        str(r.flash),
        str(r.flash - r.flash_own),
        str(r.ram),
        _whole(r.stack),
    )


def _mean(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"


def _whole(value: int | None) -> str:
    return "-" if value is None else str(value)


def _notes(records: Sequence[Record]) -> list[str]:
    compilers = dict.fromkeys((r.target, r.compiler) for r in records)
    by_compiler: dict[str, list[str]] = {}
    for target, compiler in compilers:
        by_compiler.setdefault(compiler, []).append(target)
    lines = [f"{compiler}: {', '.join(targets)}" for compiler, targets in by_compiler.items()]
    seen = {r.target for r in records if r.cycles_mean is not None}
    if "cortex-m0plus" in seen:
        lines.append("cycles of cortex-m0plus: by the core manual's table, no wait states, multiplier of one cycle")
    if "avr" in seen:
        lines.append("cycles of avr: ATmega328P, counted by simavr")
    lines.append(
        "bytes: flash of the function with all it calls, of which library (the compiler's own); stack: deepest"
    )
    compared = [r for r in records if r.matches is not None]
    if compared and all(r.matches for r in compared):
        lines.append("every output, status and state was the integer program's, bit for bit")
    lines += [f"nothing derived for {_of(r)}: {r.worst_reason}" for r in records if r.worst_reason is not None]
    untimed = [r for r in records if r.matches is None]
    if untimed:
        lines.append("not run (simavr was not found, or the inputs do not fit the device): " + _names(untimed))
    return lines


def _of(record: Record) -> str:
    return f"{record.function} on {record.target} -{record.option}"


def _names(records: Sequence[Record]) -> str:
    return ", ".join(dict.fromkeys(f"{r.function} on {r.target}" for r in records))
