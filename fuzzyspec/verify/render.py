"""A report as text for people and as data for machines."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from fuzzyspec.verify.report import Build, Example, Failure, FunctionFound, MachineFound, OutputFound, Report


def as_text(report: Report, *, worst: bool = False) -> str:
    """Several lines: what was built, a table for each function, failures with their smallest inputs, the verdict.

    With ``worst`` also the input at which each output's error was largest.
    """
    return "\n".join(_lines(report, worst))


def _lines(report: Report, worst: bool) -> Iterator[str]:
    strict = f"{report.compiler} -std=c99 -O2, strict warnings"
    checked = f"; again with {' and '.join(report.sanitizers)} sanitizers" if report.sanitizers else ""
    yield f"{report.module}: {strict}{checked}; seed {report.seed}"
    if report.selftest is not None:
        yield f"self-test: {'passed' if report.selftest == 0 else f'golden vector {report.selftest - 1} differs'}"
    for found in report.functions:
        yield ""
        yield from _function(found)
        for output in found.outputs if worst else ():
            if output.worst is not None:
                yield f"  largest error of {output.output} at"
                yield from (f"    {line}" for line in example_lines(output.worst))
            yield from (f"    {line}" for line in _tightness(output))
    if report.machines:
        yield ""
        yield from _machines(report.machines)
    for note in report.notes:
        yield ""
        yield f"note: {note}"
    for failure in report.failures:
        yield ""
        yield from _failure(failure)
    yield ""
    if report.ok:
        targets = len({m.build.target for m in report.machines})
        machines = "1 machine" if targets == 1 else f"{targets} machines"
        more = f"; {sum(m.cases for m in report.machines):,} more on {machines}" if report.machines else ""
        yield f"{report.module}: verified, {report.cases:,} cases, 0 mismatches{more}"
    else:
        many = "1 failure" if len(report.failures) == 1 else f"{len(report.failures)} failures"
        yield f"{report.module}: NOT verified, {many}"


def _tightness(output: OutputFound) -> Iterator[str]:
    """How far the bound is above what was found, and what it owes that to."""
    if output.ratio is not None:
        yield f"certified: {output.ratio:.1f} times that"
    if output.dominant is not None:
        yield f"most of the bound: {output.dominant.kernel}, {output.dominant.percent} %"
        yield f"    where it is largest: {output.dominant.where}"


def _function(found: FunctionFound) -> Iterator[str]:
    sanitized = f", {found.sanitized:,} of them under sanitizers" if found.sanitized else ""
    yield f"{found.kind} {found.function}: {found.cases:,} cases{sanitized}"
    rows: list[tuple[str, ...]] = [("output", "mismatches", "largest error", "", "certified bound", "")]
    for output in found.outputs:
        bound = error = percent = bound_percent = ""
        if output.largest_error is not None and output.largest_percent is not None:
            error = f"{output.largest_error:.3g} {output.unit}".strip()
            percent = f"{output.largest_percent:.4f} %"
        if output.bound is not None:
            bound = f"{float(output.bound):.3g} {output.unit}".strip()
            bound_percent = "" if output.bound_percent is None else f"{float(output.bound_percent):.4f} %"
        elif output.largest_error is not None:
            bound = "none"
        else:
            bound = "a decision"
        rows.append((output.output, f"{output.mismatches:,}", error, percent, bound, bound_percent))
    rows.append(("status", f"{found.status_mismatches:,}", "", "", "", ""))
    if found.state_mismatches or any(k == "traces" for k in found.kinds):
        rows.append(("state", f"{found.state_mismatches:,}", "", "", "", ""))
    yield from _table(rows, "<>>>>>")
    if found.decisions:
        rows = [("decision", "taken", "exact differs", "furthest apart", "band")]
        for d in found.decisions:
            band = "none: both agree" if d.band is None else f"{float(d.band):.3g}"
            apart = f"{d.largest_margin:.3g}" if d.disagreed else ""
            rows.append((d.key, f"{d.taken:,}", f"{d.disagreed:,}", apart, band))
        yield from _table(rows, "<>>>>")


def _machines(found: Sequence[MachineFound]) -> Iterator[str]:
    """A line for the levels of a compiler that came out alike."""
    rows: list[tuple[str, ...]] = [("machine", "compiler", "level", "run by", "cases", "mismatches", "self-test")]
    alike: dict[tuple[str, ...], list[str]] = {}
    for m in found:
        emulator = m.emulator or "itself"
        selftest = {None: "not run", 0: "passed"}.get(m.selftest, "differs")
        key = (m.build.target, m.build.compiler, emulator, f"{m.cases:,}", f"{m.mismatches:,}", selftest)
        alike.setdefault(key, []).append(f"-{m.build.level}")
    rows += [(target, compiler, " ".join(levels), *rest) for (target, compiler, *rest), levels in alike.items()]
    yield "the same C on machines (cases a level, over all functions)"
    yield from _table(rows, "<<<<>><")
    reasons = {f"{m.build.target} -{m.build.level}: {m.left_out}": None for m in found if m.left_out}
    reasons |= {
        f"{m.build.target} -{m.build.level}: {f.function} was not run: {f.left_out}": None
        for m in found
        for f in m.functions
        if f.left_out
    }
    yield from (f"  {reason}" for reason in reasons)


def _table(rows: Sequence[tuple[str, ...]], align: str) -> Iterator[str]:
    widths = [max(len(r[c]) for r in rows) for c in range(len(align))]
    for row in rows:
        yield ("  " + "  ".join(f"{cell:{a}{w}}" for cell, a, w in zip(row, align, widths, strict=True))).rstrip()


def _failure(failure: Failure) -> Iterator[str]:
    where = f" {failure.function}:" if failure.function is not None else ""
    yield f"FAILED{where} {failure.message}"
    if failure.example is not None:
        yield "  smallest input found:"
        yield from (f"    {line}" for line in example_lines(failure.example))
    if failure.differences:
        rows = [("", "expected", "got"), *((d.what, d.expected, d.got) for d in failure.differences)]
        yield from (f"  {line}" for line in _table(rows, "<<<"))
    if failure.output:
        yield from (f"  | {line}" for line in failure.output.rstrip().splitlines()[:40])


def example_lines(example: Example) -> Iterator[str]:
    """``signal = value (raw n)``, a line each; list elements as ``list.0.field``."""
    for key, raw in example.inputs.items():
        values = example.values.get(key)
        if isinstance(raw, tuple):
            name, _, field = key.partition(".")
            assert values is None or isinstance(values, tuple)
            for j, r in enumerate(raw):
                yield f"{name}.{j}.{field} = {values[j] if values else r} (raw {r})"
        elif values is None:
            yield f"{key} = {raw}"
        else:
            yield f"{key} = {values} (raw {raw})"
    for key, raw in example.state.items():
        yield f"state {key} = {example.values.get(f'state {key}', '')} (raw {raw})"


# --- data ----------------------------------------------------------------------------------------


def as_json(report: Report) -> dict[str, Any]:
    """The same as plain data; exact numbers as ``p/q`` strings beside their decimal value."""
    return {
        "module": report.module,
        "ok": report.ok,
        "seed": report.seed,
        "cases": report.cases,
        "compiler": report.compiler,
        "sanitizers": list(report.sanitizers),
        "selftest": report.selftest,
        "functions": [_function_json(f) for f in report.functions],
        "machines": [_machine_json(m) for m in report.machines],
        "failures": [_failure_json(f) for f in report.failures],
        "notes": list(report.notes),
    }


def _function_json(found: FunctionFound) -> dict[str, Any]:
    return {
        "function": found.function,
        "kind": found.kind,
        "cases": found.cases,
        "kinds": dict(found.kinds),
        "sanitized": found.sanitized,
        "mismatches": found.mismatches,
        "status_mismatches": found.status_mismatches,
        "state_mismatches": found.state_mismatches,
        "outputs": [
            {
                "output": o.output,
                "unit": o.unit,
                "cases": o.cases,
                "mismatches": o.mismatches,
                "largest_error": o.largest_error,
                "largest_error_percent": o.largest_percent,
                "bound": None if o.bound is None else float(o.bound),
                "bound_exact": None if o.bound is None else str(o.bound),
                "bound_percent": None if o.bound_percent is None else float(o.bound_percent),
                "bound_over_largest_error": o.ratio,
                "dominant": None
                if o.dominant is None
                else {"where": o.dominant.where, "kernel": o.dominant.kernel, "percent": o.dominant.percent},
                "worst": _example_json(o.worst),
            }
            for o in found.outputs
        ],
        "decisions": [
            {
                "key": d.key,
                "what": d.what,
                "taken": d.taken,
                "exact_differs": d.disagreed,
                "largest_margin": d.largest_margin,
                "band": None if d.band is None else float(d.band),
                "band_exact": None if d.band is None else str(d.band),
            }
            for d in found.decisions
        ],
    }


def _machine_json(found: MachineFound) -> dict[str, Any]:
    return {
        **_build_json(found.build),
        "emulator": found.emulator or None,
        "cases": found.cases,
        "mismatches": found.mismatches,
        "selftest": found.selftest,
        "left_out": found.left_out or None,
        "functions": [
            {"function": f.function, "cases": f.cases, "mismatches": f.mismatches, "left_out": f.left_out or None}
            for f in found.functions
        ],
    }


def _build_json(build: Build) -> dict[str, Any]:
    return {"target": build.target, "compiler": build.compiler, "level": build.level}


def _failure_json(failure: Failure) -> dict[str, Any]:
    return {
        "kind": failure.kind,
        "function": failure.function,
        "message": failure.message,
        "on": None if failure.on is None else _build_json(failure.on),
        "example": _example_json(failure.example),
        "differences": [{"what": d.what, "expected": d.expected, "got": d.got} for d in failure.differences],
        "output": failure.output,
    }


def _example_json(example: Example | None) -> dict[str, Any] | None:
    if example is None:
        return None
    return {
        "raws": {k: list(v) if isinstance(v, tuple) else v for k, v in example.inputs.items()},
        "state": dict(example.state),
        "values": {k: list(v) if isinstance(v, tuple) else v for k, v in example.values.items()},
    }
