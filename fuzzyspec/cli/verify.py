"""``fuzzyc verify``: is the C what the spec says?"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fuzzyspec.cli.lowering import add_lowering, lowering
from fuzzyspec.cli.spec import spec_path

if TYPE_CHECKING:
    from fuzzyspec.verify import Machines

MACHINES = ("host", "cortex-m0plus", "cortex-m4", "cortex-m7", "rv32imc", "avr", "mips-be", "wasm32")
LEVELS = ("O0", "O2", "Os", "O3")


def register(subparsers: Any) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "verify",
        help="show that the C does what the spec says",
        description="Build the C for this machine (strict warnings; again under sanitizers) and run it, the integer "
        "program and the exact meaning over random and aimed inputs: C and program must agree bit for bit, program "
        "and meaning within the certified bounds.",
        epilog="exit status: 0 verified, 1 not, 2 wrong usage or no C compiler",
    )
    parser.add_argument("file", metavar="FILE.fz", type=spec_path, help="the spec")
    parser.add_argument("--c", metavar="FILE", type=Path, help="verify this C file instead of the generated one")
    parser.add_argument("--only", metavar="NAME", action="append", default=[], help="verify this controller or system")
    parser.add_argument("--scenario", metavar="CSV", type=Path, help="replay recorded inputs instead of making them up")
    parser.add_argument("--raw", action="store_true", help="the scenario holds raws, not values in declared units")
    parser.add_argument("--seed", metavar="N", type=_natural, help="seed of the random inputs")
    parser.add_argument("--cases", metavar="N", type=_natural, help="random cases a function, besides the aimed ones")
    parser.add_argument(
        "--worst", action="store_true", help="also search for each output's largest error, and say where it is"
    )
    parser.add_argument("--no-sanitize", action="store_true", help="leave out the build under sanitizers")
    parser.add_argument(
        "--target",
        metavar="NAME[,NAME]",
        type=_machines,
        action="extend",
        help=f"also run the C on these machines: {', '.join(MACHINES)}; `all` are those whose tools are here",
    )
    parser.add_argument(
        "--levels",
        metavar="LEVEL[,LEVEL]",
        type=_levels,
        help=f"optimisation levels of the builds for --target (default: {','.join(LEVELS)})",
    )
    parser.add_argument("--compiler", choices=("gcc", "zig"), help="build for --target with these only (default: all)")
    parser.add_argument(
        "--target-cases",
        metavar="N",
        type=_natural,
        help="cases of a function that each build for --target runs (default: 100000; 20000 in simavr)",
    )
    add_lowering(parser)
    parser.add_argument("--format", choices=("text", "json"), default="text", help="what is printed")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Verify, print, 0 or 1."""
    from fuzzyspec import api
    from fuzzyspec.cli.progress import Bar
    from fuzzyspec.diagnostics.refusal import Refusal

    if arguments.raw and arguments.scenario is None:
        raise Refusal("--raw says how to read a scenario", "give --scenario too")
    machines = _found(arguments)
    spec = api.load(arguments.file)
    known = list(spec.functions)
    for name in arguments.only:
        if name not in known:
            raise Refusal(f"{spec.name} has no controller or system `{name}`", f"it has {', '.join(known)}")
    with Bar() as bar:
        report = spec.verify(
            seed=arguments.seed,
            cases=arguments.cases,
            only=tuple(arguments.only),
            c=arguments.c,
            scenario=arguments.scenario,
            raw=arguments.raw,
            sanitize=not arguments.no_sanitize,
            worst=arguments.worst,
            options=lowering(arguments),
            machines=machines,
            progress=bar.show if sys.stderr.isatty() else None,
        )
    from fuzzyspec.verify import as_json, as_text

    if arguments.format == "json":
        import json

        print(json.dumps(as_json(report), indent=2))
    else:
        print(as_text(report, worst=arguments.worst))
    return 0 if report.ok else 1


def _found(arguments: argparse.Namespace) -> Machines | None:
    """The builds for other machines; Refusal where there is none to which an option applies."""
    from fuzzyspec.diagnostics.refusal import Refusal
    from fuzzyspec.verify import find_machines

    if arguments.target:
        levels = arguments.levels or LEVELS
        return find_machines(arguments.target, levels, arguments.compiler, arguments.target_cases)
    for option in ("levels", "compiler", "target_cases"):
        if getattr(arguments, option) is not None:
            raise Refusal(f"--{option.replace('_', '-')} is about the builds for --target", "give --target too")
    return None


def _machines(text: str) -> list[str]:
    return _listed(text, (*MACHINES, "all"))


def _levels(text: str) -> list[str]:
    return _listed(text.replace("-O", "O"), ("O0", "O1", "O2", "O3", "Os"))


def _listed(text: str, known: tuple[str, ...]) -> list[str]:
    """Words with commas between them, each once."""
    words = list(dict.fromkeys(text.split(",")))
    for word in words:
        if word not in known:
            raise argparse.ArgumentTypeError(f"`{word}` is none of {', '.join(known)}")
    return words


def _natural(text: str) -> int:
    if not text.isascii() or not text.isdigit() or len(text) > 18:
        raise argparse.ArgumentTypeError(f"`{text}` is no whole number from 0 on")
    return int(text)
