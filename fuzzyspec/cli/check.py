"""``fuzzyc check``: everything that is wrong with a spec, and what its rules come to."""

from __future__ import annotations

import argparse
import json
from fractions import Fraction
from typing import TYPE_CHECKING

from fuzzyspec.cli.lowering import add_tolerance
from fuzzyspec.cli.spec import spec_path

if TYPE_CHECKING:
    from fuzzyspec.check.report import ModuleReport
    from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source
    from fuzzyspec.model.system import Module


def register(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``fuzzyc check``."""
    parser = subparsers.add_parser(
        "check",
        help="check specs and account for their rules",
        description="Report everything that is wrong with specs (on standard error), and of sound ones what their "
        "rules come to: cells and who wins them, coverage, what outputs reach, decisions on computed values.",
    )
    parser.add_argument("files", metavar="FILE.fz", type=spec_path, nargs="+", help="the specs")
    add_tolerance(parser)
    parser.add_argument("--format", choices=("text", "json"), default="text")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Check every file; 1 where one has errors."""
    from fuzzyspec.api import read
    from fuzzyspec.cli import terminal
    from fuzzyspec.diagnostics.render import as_json

    results = []
    sources = [read(file) for file in arguments.files]
    for index, (source, unreadable) in enumerate(sources):
        report, diagnostics = checked(source, unreadable, arguments.tolerance)
        if arguments.format == "json":
            results.append(
                {
                    "file": source.name,
                    "ok": report is not None,
                    "diagnostics": as_json(diagnostics, source),
                    "report": None if report is None else report.as_json(),
                }
            )
            continue
        terminal.print_diagnostics(diagnostics, source)
        if report is not None:
            print(report.text() + ("\n" if index + 1 < len(sources) else ""))
        results.append({"ok": report is not None})
    fine = all(result["ok"] for result in results)
    if arguments.format == "json":
        print(json.dumps({"ok": fine, "files": results}, indent=2))
    return 0 if fine else 1


def checked(
    source: Source, unreadable: tuple[Diagnostic, ...] = (), tolerance: Fraction | None = None
) -> tuple[ModuleReport | None, tuple[Diagnostic, ...]]:
    """The report, or None where something is wrong, and everything that was found on the way to an integer program, one
    that keeps to the ``tolerance`` in percent where there is one."""
    from fuzzyspec.check import check
    from fuzzyspec.check.report import module_report
    from fuzzyspec.syntax import parse

    tree, torn = parse(source)
    problems = (*unreadable, *torn)
    module, found = check(tree, source, problems)
    diagnostics = (*problems, *found)
    if module is None:
        return None, diagnostics
    bands, late = _bands(module, tolerance)
    report = None if any(d.severity == "error" for d in late) else module_report(module, source, bands)
    return report, (*diagnostics, *late)


def _bands(module: Module, tolerance: Fraction | None) -> tuple[dict[str, dict[str, Fraction]], tuple[Diagnostic, ...]]:
    """The widths of all decision bands, or why there is no integer program."""
    from fuzzyspec.lower import LoweringError, Options, lower

    try:
        lowered = lower(module, Options(tolerance=tolerance))
    except LoweringError as error:
        return {}, error.diagnostics
    return {name: {b.key: b.width for b in c.bands} for name, c in lowered.certificates.items()}, ()
