"""``fuzzyc verify``: is the C what the spec says?"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fuzzyspec.cli import terminal
from fuzzyspec.cli.lowering import add_lowering, lowering
from fuzzyspec.cli.spec import spec_path

if TYPE_CHECKING:
    from fuzzyspec.api import Spec
    from fuzzyspec.certify import Progress
    from fuzzyspec.verify import Machines, Report, Sweep

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
        epilog="exit status: 0 verified, 1 not, 2 wrong usage or a missing tool",
    )
    parser.add_argument(
        "file", metavar="FILE.fz", type=spec_path, nargs="?", help="the spec; not needed with --recheck"
    )
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
        "--emulator",
        choices=("unicorn", "qemu"),
        help="what runs Cortex-M, RISC-V and MIPS (default: unicorn, else qemu)",
    )
    parser.add_argument(
        "--target-cases",
        metavar="N",
        type=_natural,
        help="cases of a function that each build for --target runs (default: 100000; 20000 in simavr)",
    )
    parser.add_argument(
        "--exhaustive",
        action="store_true",
        help="then sweep every input there is, where a function has at most 2^32, on all processors",
    )
    parser.add_argument(
        "--state",
        metavar="FILE",
        type=Path,
        help="keep in this file how far --exhaustive has come, and go on from there",
    )
    add_lowering(parser)
    parser.add_argument(
        "--certificate", metavar="FILE", type=Path, help="write what was shown, how, and of which spec, C and tool"
    )
    parser.add_argument(
        "--recheck",
        metavar="FILE",
        type=Path,
        help="verify again what a certificate says; a spec or a --c named beside must be the one that it is of",
    )
    parser.add_argument("--format", choices=("text", "json"), default="text", help="what is printed")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Verify, print, 0 or 1."""
    from fuzzyspec import api
    from fuzzyspec.cli.progress import Bar
    from fuzzyspec.diagnostics.refusal import Refusal

    if arguments.recheck is not None:
        return _recheck(arguments)
    if arguments.file is None:
        raise Refusal("no spec is named", "name one, or a certificate by --recheck")
    if arguments.raw and arguments.scenario is None:
        raise Refusal("--raw says how to read a scenario", "give --scenario too")
    if arguments.certificate is not None and arguments.scenario is not None:
        raise Refusal("a certificate is about generated cases", "leave out --scenario or --certificate")
    if arguments.state is not None and not arguments.exhaustive:
        raise Refusal("--state is about --exhaustive", "give --exhaustive too")
    if arguments.state is not None and arguments.certificate is not None:
        raise Refusal("a certificate tells of one run, and --state joins several", "leave out one of the two")
    machines = _found(arguments)
    spec = api.load(arguments.file)
    known = list(spec.functions)
    for name in arguments.only:
        if name not in known:
            raise Refusal(f"{spec.name} has no controller or system `{name}`", f"it has {', '.join(known)}")
    with _told(arguments.state), Bar() as bar:
        progress = bar.show if sys.stderr.isatty() else None
        if arguments.certificate is not None:
            report = _certified(arguments, spec, progress)
        else:
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
                sweep=_sweep(arguments) if arguments.exhaustive else None,
                progress=progress,
            )
    from fuzzyspec.verify import as_json, as_text

    if arguments.format == "json":
        import json

        print(json.dumps(as_json(report), indent=2))
    else:
        print(as_text(report, worst=arguments.worst))
    return 0 if report.ok else 1


def _certified(arguments: argparse.Namespace, spec: Spec, progress: Progress | None) -> Report:
    """Verify, and write the certificate where that succeeds: it says what was shown."""
    import json

    from fuzzyspec.certify import certify
    from fuzzyspec.emit import Plan, write
    from fuzzyspec.verify.evidence import Asked

    asked = Asked(
        seed=arguments.seed,
        cases=arguments.cases,
        only=tuple(arguments.only),
        sanitize=not arguments.no_sanitize,
        worst=arguments.worst,
        bounds=arguments.bounds,
        optimize=arguments.optimize,
        chosen_for=arguments.chosen_for,
        tolerance=None if arguments.tolerance is None else str(arguments.tolerance),
        targets=tuple(arguments.target or ()),
        levels=None if arguments.levels is None else tuple(arguments.levels),
        compiler=arguments.compiler,
        emulator=arguments.emulator,
        target_cases=arguments.target_cases,
        exhaustive=arguments.exhaustive,
    )
    sweep = _sweep(arguments) if arguments.exhaustive else None
    report, certificate = certify(spec, asked, arguments.c, progress, sweep)
    if report.ok:
        text = json.dumps(certificate, indent=1) + "\n"
        write(Plan({arguments.certificate.name: text.encode()}), arguments.certificate.parent)
    return report


def _recheck(arguments: argparse.Namespace) -> int:
    """Verify a certificate again: 0 where all of it holds, else 1 and what does not."""
    import hashlib
    import json

    from fuzzyspec import api
    from fuzzyspec.certify import recheck
    from fuzzyspec.cli.progress import Bar
    from fuzzyspec.diagnostics.refusal import Refusal

    try:
        certificate = json.loads(arguments.recheck.read_bytes())
    except ValueError as error:
        raise Refusal(f"{arguments.recheck} is no certificate: it is not JSON") from error
    with Bar() as bar:
        broken, notes = recheck(certificate, bar.show if sys.stderr.isatty() else None)
    if arguments.file is not None and api.read(arguments.file)[0].sha256 != certificate["spec"]["sha256"]:
        broken.append(f"{arguments.file} is not the spec that was verified")
    if arguments.c is not None:
        found = hashlib.sha256(arguments.c.read_bytes()).hexdigest()
        if found not in (entry["sha256"] for entry in certificate["c"].values()):
            broken.append(f"{arguments.c} is not the C that was verified")
    if arguments.format == "json":
        print(json.dumps({"ok": not broken, "broken": broken, "notes": notes}, indent=2))
    else:
        for note in notes:
            print(f"note: {note}")
        for line in broken:
            print(f"FAILED {line}")
        holds = "holds" if not broken else "does NOT hold"
        print(f"{arguments.recheck}: {holds}, {len(certificate['shown'])} claims of {certificate['spec']['name']}")
    return 1 if broken else 0


@contextmanager
def _told(state: Path | None) -> Iterator[None]:
    """Whoever interrupts a sweep that keeps its state is told how to go on."""
    try:
        yield
    except KeyboardInterrupt:
        if state is not None and state.exists():
            terminal.complain(f"{state} holds how far it came: the same command goes on from there")
        raise


def _sweep(arguments: argparse.Namespace) -> Sweep:
    """A sweep that says beforehand how long it will take, and keeps its state in the file given."""
    from fuzzyspec.cli.progress import duration
    from fuzzyspec.cli.sweepfile import SweepFile
    from fuzzyspec.verify import Sweep

    def begin(inputs: int, seconds: float, processors: int) -> None:
        on = "1 processor" if processors == 1 else f"{processors} processors"
        print(f"\r{inputs:,} inputs to sweep: about {duration(seconds)} on {on}{'':20}", file=sys.stderr)

    return Sweep(None if arguments.state is None else SweepFile(arguments.state), begin)


def _found(arguments: argparse.Namespace) -> Machines | None:
    """The builds for other machines; Refusal where there is none to which an option applies."""
    from fuzzyspec.diagnostics.refusal import Refusal
    from fuzzyspec.verify import find_machines

    if arguments.target:
        levels = arguments.levels or LEVELS
        cases, emulator = arguments.target_cases, arguments.emulator
        return find_machines(arguments.target, levels, arguments.compiler, cases, emulator)
    for option in ("levels", "compiler", "emulator", "target_cases"):
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
