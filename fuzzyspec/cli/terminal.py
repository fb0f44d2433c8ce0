"""What reaches the terminal: encoding, colour, diagnostics, complaints, and the box around a bug of ours."""

from __future__ import annotations

import io
import json
import os
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import TextIO

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source
from fuzzyspec.version import __version__


def speak_utf8() -> None:
    """Write UTF-8 whatever the locale says, and never fail over a character; a stream that is closed takes anything."""
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(encoding="utf-8", errors="backslashreplace")


def wants_color(stream: TextIO) -> bool:
    """Colour for a terminal that can show it, unless ``NO_COLOR`` is set; ``FORCE_COLOR`` asks for it anyway."""
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return stream.isatty() and os.environ.get("TERM") != "dumb"


def print_diagnostics(diagnostics: Sequence[Diagnostic], source: Source, stream: TextIO | None = None) -> None:
    """Render diagnostics with their source lines, to standard error unless told otherwise."""
    from fuzzyspec.diagnostics.render import render

    stream = sys.stderr if stream is None else stream
    if diagnostics:
        print(render(tuple(diagnostics), source, color=wants_color(stream)), file=stream)


def print_diagnostics_as_json(diagnostics: Sequence[Diagnostic], source: Source) -> None:
    """What a command with ``--format json`` prints instead of its result when the spec has errors."""
    from fuzzyspec.diagnostics.render import as_json

    print(json.dumps({"ok": False, "diagnostics": as_json(diagnostics, source)}, indent=2))


def complain(message: str) -> None:
    """One line on standard error, in the tool's name."""
    print(f"fuzzyc: {message}", file=sys.stderr)


def print_failure_as_json(message: str) -> None:
    """What a command with ``--format json`` prints instead of its result when it could not do its work."""
    print(json.dumps({"ok": False, "error": message}, indent=2))


def print_bug_box(error: Exception, argv: Sequence[str]) -> None:
    """Say that the fault is ours, where it happened and how to report it; the traceback under ``FUZZYC_DEBUG=1``."""
    if os.environ.get("FUZZYC_DEBUG"):
        traceback.print_exception(error)
    frames = traceback.extract_tb(error.__traceback__)
    where = f"{Path(frames[-1].filename).name}:{frames[-1].lineno} in {frames[-1].name}" if frames else "unknown"
    what = "".join(traceback.format_exception_only(error)).strip().splitlines()[0]
    body = (
        f"{what[:200]}",
        f"at {where}",
        "",
        "Your spec should never cause this, right or wrong. Please report it with the spec and",
        f"the output of: FUZZYC_DEBUG=1 fuzzyc {' '.join(argv)}",
    )
    title = f"a bug in fuzzyc {__version__} (python {sys.version.split()[0]}, {sys.platform})"
    print(f"+-- {title}", *(f"| {line}".rstrip() for line in body), "+--", sep="\n", file=sys.stderr)
