"""``fuzzyc cost``: what a call takes on a microcontroller, measured in an emulator."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fuzzyspec.cli.lowering import add_tolerance
from fuzzyspec.cli.spec import spec_path

if TYPE_CHECKING:
    from fuzzyspec.api import Spec
    from fuzzyspec.cost import Conditions, CrossCompiler

TARGETS = ("cortex-m0plus", "cortex-m4", "cortex-m7", "rv32imc", "avr")


def register(subparsers: Any) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "cost",
        help="what a call takes on a microcontroller",
        description="Build the C for a target and run every function in an emulator: instructions, cycles where there "
        "is an honest model of them, flash, RAM and stack. What is computed is compared with the integer program, "
        "what it takes with the spec's budgets.",
        epilog="exit status: 0 measured, 1 an output was wrong, a budget missed, or the worst case derived "
        "exceeded, 2 wrong usage or a missing tool",
    )
    parser.add_argument("file", metavar="FILE.fz", type=spec_path, help="the spec")
    parser.add_argument(
        "--target",
        action="append",
        choices=TARGETS,
        help="measure on this target; may be repeated (default: all that a compiler was found for)",
    )
    parser.add_argument(
        "--opt", action="append", choices=("O2", "Os"), help="build with this option; may be repeated (default: both)"
    )
    parser.add_argument(
        "--optimize",
        choices=("speed", "balanced", "size"),
        help="what fuzzyc chooses its strategies for (default: speed for O2, size for Os)",
    )
    parser.add_argument(
        "--inputs", metavar="N", type=_positive, default=1000, help="inputs to try, of a fixed sequence (default: 1000)"
    )
    parser.add_argument("--only", metavar="NAME", action="append", default=[], help="measure this controller or system")
    parser.add_argument(
        "--pareto",
        action="store_true",
        help="measure every strategy that a controller can be computed by, and mark those that nothing beats",
    )
    parser.add_argument("--compiler", choices=("gcc", "zig"), help="build with this (default: gcc where it is found)")
    add_tolerance(parser)
    parser.add_argument("--format", choices=("text", "json"), default="text", help="what is printed")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Measure, print, 0 or 1."""
    from fuzzyspec import api
    from fuzzyspec.cli import terminal
    from fuzzyspec.cost import OPTIMISATIONS, Conditions, EmulationError
    from fuzzyspec.diagnostics.refusal import Refusal
    from fuzzyspec.native import BuildError

    spec = api.load(arguments.file).within(arguments.tolerance)
    known = list(spec.functions)
    for name in arguments.only:
        if name not in known:
            raise Refusal(f"{spec.name} has no controller or system `{name}`", f"it has {', '.join(known)}")
    compilers, missing = _compilers(arguments.target, arguments.compiler)
    options = tuple(o for o in OPTIMISATIONS if o in (arguments.opt or OPTIMISATIONS))
    conditions = Conditions(compilers, options, arguments.inputs, tuple(arguments.only), worst=True)

    try:
        return (_pareto if arguments.pareto else _measure)(spec, conditions, missing, arguments)
    except BuildError as error:
        terminal.complain(f"{error}\n{error.output}")
    except EmulationError as error:
        terminal.complain(f"the emulated C did not run to its end: {error}")
    return 1


def _measure(spec: Spec, conditions: Conditions, missing: Mapping[str, str], arguments: argparse.Namespace) -> int:
    """What is compiled for each target; 0, or 1 where an output was wrong or a budget is not kept."""
    from functools import cache

    from fuzzyspec.cli.progress import Bar
    from fuzzyspec.cost import as_json, as_text, confirm, measure, with_limits
    from fuzzyspec.lower import Options
    from fuzzyspec.lower.strategy import Goal

    @cache
    def files(target: Any, option: str) -> Mapping[str, bytes]:
        goal: Goal = arguments.optimize or ("size" if option == "Os" else "speed")
        return spec.compile(Options(optimize=goal, target=target)).files

    with Bar() as bar:
        progress = bar.show if sys.stderr.isatty() else None
        measured = with_limits(measure(spec.lowered.program, files, conditions, progress), spec.functions)
    budgets = {name: f.budgets for name, f in spec.functions.items() if name in (arguments.only or spec.functions)}
    verdicts = confirm(budgets, measured.records, _judged(conditions.options, arguments.optimize), missing)
    if arguments.format == "json":
        import json

        print(json.dumps(as_json(spec.name, conditions, measured, missing, verdicts), indent=2))
    else:
        print(as_text(spec.name, conditions, measured, missing, verdicts))
    return 0 if measured.ok and all(v.met is not False for v in verdicts) else 1


def _pareto(spec: Spec, conditions: Conditions, missing: Mapping[str, str], arguments: argparse.Namespace) -> int:
    """Every strategy; 0, or 1 where one of them computed what its program does not."""
    from fuzzyspec.cli.progress import Bar
    from fuzzyspec.cost import pareto, pareto_json, pareto_text

    with Bar() as bar:
        choices = pareto(spec.module, spec.source, conditions, bar.show if sys.stderr.isatty() else None)
    if arguments.format == "json":
        import json

        print(json.dumps(pareto_json(spec.name, conditions, choices, missing), indent=2))
    else:
        print(pareto_text(spec.name, conditions, choices, missing))
    return 1 if choices.mismatches else 0


def _judged(options: tuple[str, ...], goal: str | None) -> str:
    """The option of the build that budgets are held against: -Os where size is the goal, else -O2, if it was built."""
    wanted = "Os" if goal == "size" else "O2"
    return wanted if wanted in options else options[0]


def _compilers(wanted: list[str] | None, kind: Any) -> tuple[tuple[CrossCompiler, ...], dict[str, str]]:
    """The compilers of the targets asked for; of all targets where none is, and how to get those not found."""
    from fuzzyspec.cost import TARGETS, find_compiler
    from fuzzyspec.diagnostics.refusal import MissingTool

    if wanted:
        return tuple(find_compiler(TARGETS[name], kind) for name in dict.fromkeys(wanted)), {}
    found: list[CrossCompiler] = []
    missing: dict[str, str] = {}
    for name, target in TARGETS.items():
        try:
            found.append(find_compiler(target, kind))
        except MissingTool as error:
            missing[name] = str(error)
    if not found:
        raise MissingTool("no compiler for any target was found", "run `pip install 'fuzzyc[targets]'`")
    return tuple(found), missing


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError("must be at least 1")
    return value
