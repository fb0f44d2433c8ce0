"""``fuzzyc prove``: can the C go wrong, whatever it is given?"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from fuzzyspec.cli.spec import percent, spec_path

if TYPE_CHECKING:
    from fuzzyspec.prove import Proof

INT_BITS = ("32", "16")


def register(subparsers: Any) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "prove",
        help="show that the C cannot go wrong, whatever it is given",
        description="Analyse the C with Frama-C's EVA, all inputs, counts and states unconstrained, for an int of 32 "
        "bits and of 16: no undefined behaviour, no wrap-around, no cast that changes a value. The intervals that "
        "the compiler has derived are proved on the way. What the analyser cannot see is proved by SMT solvers, or by "
        "trying every value.",
        epilog="exit status: 0 proved, 1 an alarm is left, 2 wrong usage or a missing tool",
    )
    parser.add_argument("file", metavar="FILE.fz", type=spec_path, help="the spec")
    parser.add_argument("--c", metavar="FILE", type=Path, help="prove this C file instead of the generated one")
    parser.add_argument(
        "--int-bits", action="append", choices=INT_BITS, help="prove for an int of so many bits (default: both)"
    )
    parser.add_argument("--target", default="generic", help="the C that is compiled for this target (default: generic)")
    parser.add_argument("--optimize", default="balanced", help="speed, size or balanced (default: balanced)")
    parser.add_argument(
        "--tolerance", metavar="PERCENT", type=percent, help="an error of every output that you can live with"
    )
    parser.add_argument("--format", choices=("text", "json"), default="text", help="what is printed")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Prove, print, 0 or 1."""
    from fuzzyspec import api
    from fuzzyspec.cli import terminal
    from fuzzyspec.cli.progress import Bar
    from fuzzyspec.diagnostics.refusal import Refusal
    from fuzzyspec.lower import Options
    from fuzzyspec.lower.strategy import Goal, Target
    from fuzzyspec.prove import needed, prove
    from fuzzyspec.prove.eva import AnalyserFailed

    for option, value, known in (
        ("--target", arguments.target, get_args(Target)),
        ("--optimize", arguments.optimize, get_args(Goal)),
    ):
        if value not in known:
            raise Refusal(f"{option} {value} is not known", f"choose from {', '.join(known)}")
    needed()
    spec = api.load(arguments.file).within(arguments.tolerance)
    options = Options(optimize=arguments.optimize, target=arguments.target)
    files = dict(spec.compile(options).files)
    if arguments.c is not None:
        files[f"{spec.name}.c"] = arguments.c.read_bytes()
    program = spec.lower(options).program
    proofs: list[Proof] = []
    try:
        with Bar() as bar:
            for bits in dict.fromkeys(arguments.int_bits or INT_BITS):
                proofs.append(prove(program, files, int(bits), bar.show if sys.stderr.isatty() else None))
    except AnalyserFailed as error:
        terminal.complain(f"{error}\n{error.output}")
        return 1
    if arguments.format == "json":
        import json

        print(json.dumps({"module": spec.name, "proofs": [asdict(p) | {"ok": p.ok} for p in proofs]}, indent=2))
    else:
        print(as_text(spec.name, proofs))
    return 0 if all(p.ok for p in proofs) else 1


def as_text(name: str, proofs: Sequence[Proof]) -> str:
    """A line for each width of int, and one for every alarm."""
    lines: list[str] = []
    for proof in proofs:
        how = ", ".join(f"{count} by {by}" for by, count in sorted(proof.proved.items())) or "none needed"
        lines.append(
            f"int of {proof.bits} bits: {proof.reached} of {proof.statements} statements reached, "
            f"{proof.seen} claims seen by EVA, lemmas: {how}; intervals given up: {proof.given_up}"
            + ("; of states in their ranges, which each call keeps" if proof.kept else "")
        )
        lines += [f"  alarm: {a.function}: {a.kind}: {a.text}" for a in proof.alarms]
    left = sum(len(p.alarms) for p in proofs)
    lines.append(f"{name}: proved" if left == 0 else f"{name}: not proved, {left} alarm{'s' * (left > 1)} left")
    return "\n".join(lines)
