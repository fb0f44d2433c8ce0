"""Whether what was measured keeps to the budgets of a spec."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Literal, assert_never

from fuzzyspec.cost.measure import Record
from fuzzyspec.model.budget import Budget, Machine, Quantity, amount, words

Basis = Literal["of the build", "derived", "largest seen"]
"""Where a figure comes from: a size is the build's; what a call takes is the worst case derived from the code, which no
call exceeds, or where none could be derived the largest over the inputs that were tried."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """One limit on one target, held against the build with ``option``.

    ``measured`` and ``met`` are None where nothing measured it; ``why`` then says what is missing. ``seen`` is
    the largest over the inputs that were tried, for what varies with them.
    """

    function: str
    limit: Budget
    target: Machine
    option: str
    measured: int | None
    basis: Basis
    seen: int | None
    met: bool | None
    why: str
    instead: str
    """Another build that was measured and meets the limit; empty where this one does, or none."""


def confirm(
    budgets: Mapping[str, Sequence[Budget]], records: Sequence[Record], option: str, missing: Mapping[str, str]
) -> tuple[Verdict, ...]:
    """A verdict for each limit of a function on each target that was asked for.

    ``option`` is that of the build which is judged, ``missing`` the targets without a compiler and how to get one.
    """
    return tuple(
        verdict
        for function, limits in budgets.items()
        for limit in limits
        for target in limit.machines
        for verdict in _verdict(function, limit, target, records, option, missing)
    )


def _verdict(
    function: str,
    limit: Budget,
    target: Machine,
    records: Sequence[Record],
    option: str,
    missing: Mapping[str, str],
) -> Iterator[Verdict]:
    """One verdict, or none where the target was not asked for."""
    builds = {r.option: r for r in records if (r.target, r.function) == (target, function)}
    if option in builds:
        measured, basis = figure(builds[option], limit.quantity)
        met = None if measured is None else measured <= limit.limit
        why = "" if met is not None else "the emulator was not found, or could not run it"
        instead = "" if met is not False else next((o for o, r in builds.items() if _meets(r, limit)), "")
        seen = _seen(builds[option], limit.quantity)
        yield Verdict(function, limit, target, option, measured, basis, seen, met, why, instead)
    elif target in missing:
        yield Verdict(function, limit, target, option, None, "of the build", None, None, missing[target], "")


def _meets(record: Record, limit: Budget) -> bool:
    measured, _ = figure(record, limit.quantity)
    return measured is not None and measured <= limit.limit


def figure(record: Record, quantity: Quantity) -> tuple[int | None, Basis]:
    """What is held against a limit, and what kind of figure it is."""
    match quantity:
        case "flash":
            return record.flash, "of the build"
        case "ram":
            return record.ram, "of the build"
        case "stack":
            return record.stack, "largest seen"
        case "instructions":
            return _longest(record.instructions_worst, record.instructions_max)
        case "cycles":
            return _longest(record.cycles_worst, record.cycles_max)
        case _:
            assert_never(quantity)


def _seen(record: Record, quantity: Quantity) -> int | None:
    match quantity:
        case "flash" | "ram":
            return None
        case "stack":
            return record.stack
        case "instructions":
            return record.instructions_max
        case "cycles":
            return record.cycles_max
        case _:
            assert_never(quantity)


def _longest(worst: int | None, seen: int | None) -> tuple[int | None, Basis]:
    return (seen, "largest seen") if worst is None else (worst, "derived")


def as_data(verdict: Verdict) -> dict[str, object]:
    """A verdict as plain data."""
    return {
        "function": verdict.function,
        "quantity": verdict.limit.quantity,
        "limit": verdict.limit.limit,
        "target": verdict.target,
        "option": verdict.option,
        "measured": verdict.measured,
        "basis": verdict.basis,
        "largest_seen": verdict.seen,
        "met": verdict.met,
        "why": verdict.why,
    }


def as_lines(verdicts: Sequence[Verdict]) -> list[str]:
    """A table a function: the limit, the target, what was measured, met or missed."""
    lines: list[str] = []
    for function, group in groupby(verdicts, key=lambda v: v.function):
        found = list(group)
        rows = [(words(v.limit), v.target, *_outcome(v)) for v in found]
        widths = [max(len(row[i]) for row in rows) for i in range(3)]
        lines.append(f"budget of {function}, held against the -{found[0].option} build")
        for limit, target, measured, outcome in rows:
            cells = (limit.ljust(widths[0]), target.ljust(widths[1]), measured.rjust(widths[2]), outcome)
            lines.append(f"  {'  '.join(cells)}")
        lines.append("")
    return lines


def _outcome(verdict: Verdict) -> tuple[str, str]:
    """What was measured, and what comes of it."""
    if verdict.measured is None:
        return "-", f"not measured: {verdict.why}"
    measured = amount(verdict.limit.quantity, verdict.measured)
    basis = f" ({verdict.basis})" if verdict.basis != "of the build" else ""
    if verdict.met:
        return measured, f"met{basis}"
    if verdict.basis == "derived" and verdict.seen is not None:
        basis = f" (derived; {amount(verdict.limit.quantity, verdict.seen)} is the largest seen)"
    over = verdict.measured - verdict.limit.limit
    instead = f"; met by -{verdict.instead}" if verdict.instead else ""
    return measured, f"MISSED by {amount(verdict.limit.quantity, over)}{basis}{instead}"
