"""The page about the benchmarks, from the results alone: the same results give the same bytes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from decimal import ROUND_CEILING, Decimal
from itertools import groupby
from pathlib import Path

from benchmarks.baselines.interface import template_in
from benchmarks.own import KINDS, Entry
from benchmarks.results import Results
from benchmarks.workloads import WORKLOADS
from fuzzyspec.cost import OPTIMISATIONS, Record

PLOT = "benchmarks.svg"
_TARGETS = {"cortex-m0plus": "M0+", "cortex-m4": "M4", "rv32imc": "RV32", "avr": "AVR"}
_SHORT = [w.name for w in WORKLOADS if w.short]
_LANGUAGES = {"fuzzyc": "C", "fuzzylite": "C++"}
_CELLS = (
    ("cortex-m0plus", ("instructions_mean", "instructions_max", "instructions_worst", "cycles_mean", "flash", "stack")),
    ("cortex-m4", ("instructions_mean", "flash")),
    ("rv32imc", ("instructions_mean", "flash")),
    ("avr", ("cycles_mean", "cycles_worst", "flash", "stack")),
)


def page(results: Results) -> str:
    """docs/benchmarks.md."""
    setting = results.setting
    effort = setting.effort
    measured = {e.workload for e in results.own}
    tools = [f"{target}: {compiler}" for target, compiler in setting.compilers.items()]
    tools += [f"{name} {version}" for name, version in setting.versions.items()]
    return template_in(Path(__file__).parent, "page.md.j2").render(
        short=_short(results),
        comparison=_comparison(results),
        plot=PLOT,
        workloads=[f"{w.name}: {w.what} ([{w.file}](../{w.file}))" for w in WORKLOADS if w.name in measured],
        cost_inputs=f"{effort.cost_inputs:,}",
        error_inputs=f"{effort.error_inputs:,}",
        float_inputs=f"{effort.float_inputs:,}",
        single_inputs=f"{effort.single_inputs:,}",
        tools=[*tools, f"host: {setting.host}"],
        ram="" if any(r.ram for e in results.own for r in e.records) else " None of it needs static RAM.",
        costs=_costs(results),
        errors=_errors(results),
        peers=_peers(results),
        speeds=_speeds(results),
        left_out=_left_out(results),
    )


def _short(results: Results) -> str:
    rows = [
        _short_row(workload, entry)
        for workload in _SHORT
        for kind in KINDS
        if (entry := results.entry(workload, kind)) is not None
    ]
    return _table(["workload", "", *_heads(), "error", "certified"], rows, left=2)


def _heads() -> list[str]:
    """Of costs and sizes."""
    costs = [f"{short} {'cycles' if target == 'avr' else 'instr.'}" for target, short in _TARGETS.items()]
    return [*costs, *(f"M0+ flash -{option}" for option in OPTIMISATIONS)]


def _short_row(workload: str, entry: Entry) -> list[str]:
    costs = [_count(_cost(entry.record(target, "O2"))) for target in _TARGETS]
    sizes = [_count(_flash(entry, option)) for option in OPTIMISATIONS]
    return [workload, _named(entry), *costs, *sizes, _percent(_largest(entry)), _up(entry.certified)]


def _comparison(results: Results) -> str:
    """fuzzyc's figures as multiples of the table's."""
    rows = []
    for workload in _SHORT:
        own, table = results.entry(workload, "fuzzyc"), results.entry(workload, "lookup table")
        if own is not None and table is not None:
            costs = [_ratio(_cost(own.record(t, "O2")), _cost(table.record(t, "O2"))) for t in _TARGETS]
            sizes = [_ratio(_flash(own, o), _flash(table, o)) for o in OPTIMISATIONS]
            rows.append([workload, *costs, *sizes, _ratio(_largest(own), _largest(table))])
    return _table(["workload", *_heads(), "error"], rows, left=1) if rows else ""


def _costs(results: Results) -> str:
    heads = [
        "workload",
        "",
        "option",
        "M0+ instr.",
        "largest",
        "worst",
        "cycles",
        "flash",
        "stack",
        "M4 instr.",
        "flash",
    ]
    heads += ["RV32 instr.", "flash", "AVR cycles", "worst", "flash", "stack"]
    rows = []
    for entry in results.own:
        for option in dict.fromkeys(r.option for r in entry.records):
            rows.append([entry.workload, _named(entry), f"-{option}", *_cost_cells(entry, option)])
    return _table(heads, rows, left=3)


def _cost_cells(entry: Entry, option: str) -> list[str]:
    cells = []
    for target, names in _CELLS:
        record = entry.record(target, option)
        cells += [_count(None if record is None else getattr(record, name)) for name in names]
    return cells


def _errors(results: Results) -> str:
    rows = [
        [e.workload, e.kind, _percent(e.error.largest), _percent(e.error.mean), _up(e.certified)]
        for e in results.own
        if e.error is not None
    ]
    return _table(["workload", "", "largest", "mean", "certified"], rows, left=2)


def _peers(results: Results) -> str:
    rows = [
        [
            p.workload,
            f"{p.peer} {p.version}",
            _LANGUAGES.get(p.peer, "Python"),
            _microseconds(p.nanoseconds),
            _count(p.instructions),
            _percent(p.error.largest),
            _percent(p.error.mean),
            _count(p.error.inputs),
        ]
        for p in results.peers
        if p.error is not None
    ]
    heads = ["workload", "library", "", "µs", "host instr.", "largest error", "mean error", "evaluations"]
    return _table(heads, rows, left=3) if rows else ""


def _speeds(results: Results) -> str:
    rows = [[s.workload, *(_millions(v) for v in (s.native, s.fixed, s.exact))] for s in results.speeds]
    return _table(["workload", "C", "integer program", "exact meaning"], rows, left=1) if rows else ""


def _left_out(results: Results) -> list[str]:
    """What has no figures, and why; one line a reason."""
    reasons = [(e.kind, e.left_out, e.workload) for e in results.own if e.left_out]
    reasons += [(p.peer, p.left_out, p.workload) for p in results.peers if p.left_out]
    reasons.sort(key=lambda r: r[:2])
    lines = [f"{target}: {why}" for target, why in results.setting.missing.items()]
    for (kind, why), group in groupby(reasons, key=lambda r: r[:2]):
        lines.append(f"{kind}: {', '.join(workload for _, _, workload in group)} ({why})")
    return lines


def _named(entry: Entry) -> str:
    return f"{entry.kind}, {entry.form}" if entry.form else entry.kind


def _cost(record: Record | None) -> float | None:
    if record is None:
        return None
    return record.cycles_mean if record.target == "avr" else record.instructions_mean


def _flash(entry: Entry, option: str) -> int | None:
    record = entry.record("cortex-m0plus", option)
    return None if record is None else record.flash


def _largest(entry: Entry) -> float | None:
    return None if entry.error is None else entry.error.largest


def _count(value: float | None) -> str:
    return "-" if value is None else f"{value:,.0f}"


def _percent(value: float | None) -> str:
    """Two digits, down to what is of interest to nobody."""
    if value is None:
        return "-"
    if value < 1e-6:
        return "< 0.000001 %"
    return f"{value:.{max(0, 1 - math.floor(math.log10(value)))}f} %"


def _up(value: float | None) -> str:
    """A bound with two digits, never rounded down."""
    if value is None:
        return "-"
    exact = Decimal(value)
    return f"{exact.quantize(Decimal((0, (1,), exact.adjusted() - 1)), ROUND_CEILING):f} %"


def _ratio(of: float | None, by: float | None) -> str:
    """As many times with two digits; a small part as a fraction."""
    if of is None or by is None or not by:
        return "-"
    if of < by / 10:
        return f"1/{by / of:,.0f}"
    return f"{of / by:.2f}" if of < by else f"{of / by:.1f}"


def _microseconds(nanoseconds: float | None) -> str:
    if nanoseconds is None:
        return "-"
    digits = 0 if nanoseconds >= 1e5 else 1 if nanoseconds >= 1e3 else 3
    return f"{nanoseconds / 1000:,.{digits}f}"


def _millions(value: float) -> str:
    return f"{value / 1e6:.0f}" if value >= 1e7 else f"{value / 1e6:.2g}"


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]], *, left: int) -> str:
    """``left``: columns of words."""
    marks = ["---" if k < left else "--:" for k in range(len(heads))]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (heads, marks, *rows))
