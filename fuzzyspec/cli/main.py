"""``fuzzyc``: find the command, run it, turn whatever happens into an exit status.

Exit status: 0 fine; 1 the spec or the verification failed; 2 wrong usage or a missing tool; 70 a bug of
ours; 130 interrupted; 141 whoever read our output went away.
"""

from __future__ import annotations

import argparse
import errno
import importlib
import os
import sys
from collections.abc import Sequence
from itertools import pairwise

from fuzzyspec.cli import terminal
from fuzzyspec.cli.intermixed import IntermixedParser
from fuzzyspec.diagnostics.diagnostic import SpecError
from fuzzyspec.diagnostics.refusal import Refusal
from fuzzyspec.version import __version__

COMMANDS = ("compile", "check", "verify", "prove", "eval", "explain", "cost", "sim", "doctor")
"""Modules of ``fuzzyspec.cli``, in the order that ``--help`` shows them."""

FINE, FAILED, MISUSED, BUG, INTERRUPTED, UNREAD = 0, 1, 2, 70, 130, 141


def build_parser() -> argparse.ArgumentParser:
    """The whole command line. Cheap: commands import what they need when they run."""
    parser = argparse.ArgumentParser(
        prog="fuzzyc",
        description="Compile a fuzzy controller to fixed-point C, and show that the C does what the spec says.",
        epilog="exit status: 0 fine, 1 the spec or the verification failed, 2 wrong usage or a missing tool, "
        "70 a bug in fuzzyc",
    )
    parser.add_argument("--version", action="version", version=f"fuzzyc {__version__}")
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True, parser_class=IntermixedParser)
    for name in COMMANDS:
        importlib.import_module(f"fuzzyspec.cli.{name}").register(subparsers)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; the exit status. Only what Python raises for ``--help`` and wrong usage leaves as SystemExit."""
    terminal.speak_utf8()
    words = list(sys.argv[1:] if argv is None else argv)
    try:
        arguments = build_parser().parse_args(argv)
        status = _run(arguments)
        sys.stdout.flush()
    except Refusal as error:
        return _stopped(str(error), words)
    except BrokenPipeError:
        # What is still buffered must not fail again when the interpreter flushes on its way out.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return UNREAD
    except OSError as error:
        return _stopped(_told(error), words)
    except MemoryError:
        return _stopped("out of memory", words)
    except KeyboardInterrupt:
        terminal.complain("interrupted")
        return INTERRUPTED
    except Exception as error:
        terminal.print_bug_box(error, words)
        if _wants_json(words):
            terminal.print_failure_as_json(f"a bug in fuzzyc: {type(error).__name__}")
        return BUG
    return status


def _stopped(message: str, words: list[str]) -> int:
    """Wrong usage, a missing tool or a file that cannot be used: one line, and data for a machine that reads on."""
    terminal.complain(message)
    if _wants_json(words):
        terminal.print_failure_as_json(message)
    return MISUSED


def _told(error: OSError) -> str:
    """What the system refused, and at which file; writing does not name the file that a full disk had no room for."""
    if error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    if error.errno == errno.ENOSPC:
        import tempfile

        return f"{error.strerror}; temporary files are in {tempfile.gettempdir()}, and TMPDIR names another folder"
    return str(error)


def _wants_json(words: list[str]) -> bool:
    """Whether the command line asks for data; the parser may have stopped before it knew."""
    return "--format=json" in words or ("--format", "json") in pairwise(words)


def _run(arguments: argparse.Namespace) -> int:
    """The command itself. A spec with errors reads the same whichever command met them."""
    try:
        status: int = arguments.run(arguments)
    except SpecError as error:
        if getattr(arguments, "format", "text") == "json":
            terminal.print_diagnostics_as_json(error.diagnostics, error.source)
        else:
            terminal.print_diagnostics(error.diagnostics, error.source)
        return FAILED
    return status


def entry() -> None:
    """The console script."""
    sys.exit(main())
