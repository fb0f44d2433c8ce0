"""``fuzzyc compile``: a spec to C files, or ``--check`` that the files are what the spec gives."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from fuzzyspec.cli.lowering import add_lowering, lowering
from fuzzyspec.cli.spec import spec_path

if TYPE_CHECKING:
    from fractions import Fraction

    from fuzzyspec.api import Spec
    from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source
    from fuzzyspec.emit import Plan
    from fuzzyspec.estimate.budgets import Forecast
    from fuzzyspec.fixed.certificate import OutputBound
    from fuzzyspec.lower import Lowered, Options
    from fuzzyspec.lower.strategy import Goal
    from fuzzyspec.model.variable import Variable


def register(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``fuzzyc compile``."""
    parser = subparsers.add_parser(
        "compile",
        help="write the C of a spec",
        description="Compile a spec to <module>.h, <module>.c and <module>_selftest.c, all of them or none.",
    )
    parser.add_argument("file", metavar="FILE.fz", type=spec_path, help="the spec")
    parser.add_argument("-o", dest="directory", metavar="DIR", default=".", help="where to write (default: here)")
    parser.add_argument("--check", action="store_true", help="write nothing; exit status 1 where a file is stale")
    add_lowering(parser, "--target")
    parser.add_argument(
        "--over-budget",
        choices=("stop", "warn"),
        default="stop",
        help="where the cost model finds a budget of the spec broken: write nothing, or warn and write (default: stop)",
    )
    parser.add_argument("--format", choices=("text", "json"), default="text")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Compile; 0, or 1 where the spec is wrong, a budget broken or, with ``--check``, a file stale."""
    from fuzzyspec.api import load
    from fuzzyspec.cli import terminal
    from fuzzyspec.diagnostics.diagnostic import SpecError
    from fuzzyspec.emit import emit, stale, write

    as_json = arguments.format == "json"
    options = lowering(arguments)
    spec = load(arguments.file)
    lowered = spec.lower(options)
    forecasts = spec.forecasts(options, lowered)
    over = _over_budget(spec, options, forecasts)
    if arguments.over_budget == "warn":
        over = tuple(replace(d, severity="warning") for d in over)
    found = (*spec.warnings, *over)
    if any(d.severity == "error" for d in found):
        raise SpecError(spec.source, found)
    if not as_json:
        terminal.print_diagnostics(found, spec.source)
    plan = emit(spec.module, lowered, spec.source, options)
    old = stale(plan, arguments.directory) if arguments.check else []
    if not arguments.check:
        write(plan, arguments.directory)
    if as_json:
        told = {"budgets": _budgets(forecasts), "diagnostics": _diagnostics(found, spec.source)}
        print(json.dumps(_as_data(lowered, plan, arguments.directory, old) | told, indent=2))
    elif arguments.check:
        for name in old:
            terminal.complain(f"{Path(arguments.directory, name)} is stale: compile {arguments.file} again")
    else:
        for name in plan.files:
            print(f"wrote {Path(arguments.directory, name)}")
        _print_certificates(lowered)
        _print_forecasts(forecasts)
    return 1 if old else 0


def _over_budget(spec: Spec, options: Options, found: tuple[Forecast, ...]) -> tuple[Diagnostic, ...]:
    """What the model has against the budgets; the other goals are only tried where it has something."""
    if all(f.verdict in ("kept", "close") for f in found):
        return ()
    from fuzzyspec.estimate.budgets import findings

    goals: tuple[Goal, ...] = ("size", "speed")
    others: dict[str, tuple[Forecast, ...]] = {
        g: spec.forecasts(replace(options, optimize=g)) for g in goals if g != options.optimize
    }
    return findings(found, others)


def _print_forecasts(found: tuple[Forecast, ...]) -> None:
    """A line a limit and machine: what it is estimated at."""
    from fuzzyspec.estimate.budgets import as_lines

    if found:
        print("", *as_lines(found), sep="\n")


def _print_certificates(lowered: Lowered) -> None:
    """A line an output: the certified error in its unit and of its range, or why there is none."""
    rows = [("output", "certified error", "% of range", "")]
    for function in lowered.program.functions:
        for port in function.outputs:
            if port.variable is not None:
                found = lowered.certificates[function.name].output(port.name)
                rows.append((f"{function.name}.{port.name}", *_told(found, port.variable)))
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    print()
    for row in rows:
        print("  ".join([*(cell.ljust(width) for cell, width in zip(row, widths, strict=False)), row[3]]).rstrip())


def _told(found: OutputBound, variable: Variable) -> tuple[str, str, str]:
    from fuzzyspec.diagnostics.numerals import upper

    if found.error is None:
        return "none", "", found.reason
    error = f"{upper(found.error)} {variable.unit.symbol}".rstrip()
    return error, upper(found.percent_of_range) if found.percent_of_range is not None else "", ""


def _number(bound: Fraction | None) -> float | None:
    """Six digits, rounded up."""
    from fuzzyspec.diagnostics.numerals import upper

    return None if bound is None else float(upper(bound, 6))


def _budgets(found: tuple[Forecast, ...]) -> list[dict[str, object]]:
    from fuzzyspec.estimate.budgets import as_data

    return [as_data(f) for f in found]


def _diagnostics(found: tuple[Diagnostic, ...], source: Source) -> list[dict[str, object]]:
    from fuzzyspec.diagnostics.render import as_json

    return as_json(found, source)


def _as_data(lowered: Lowered, plan: Plan, directory: str, old: list[str]) -> dict[str, object]:
    def outputs(function: str) -> list[dict[str, object]]:
        return [
            {
                "output": o.output,
                "error": _number(o.error),
                "percent_of_range": _number(o.percent_of_range),
                "reason": o.reason,
            }
            for o in lowered.certificates[function].outputs
        ]

    return {
        "ok": not old,
        "directory": directory,
        "files": list(plan.files),
        "stale": old,
        "sha256": plan.digest,
        "certified": {f.name: outputs(f.name) for f in lowered.program.functions},
    }
