"""``fuzzyc doctor``: which tools are here, which are not, and how to get them."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict, dataclass


@dataclass(frozen=True, slots=True)
class Finding:
    """One tool: what it is for, what was found (None: nothing) and how to get it."""

    tool: str
    use: str
    found: str | None
    way_out: str
    needed: bool


def register(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``fuzzyc doctor``."""
    parser = subparsers.add_parser(
        "doctor",
        help="what tools were found, and how to get the rest",
        description="List the tools that fuzzyc can use, with what was found. Exit status 2 if one that it needs is missing.",
    )
    parser.add_argument("--format", choices=("text", "json"), default="text")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Print the findings; 2 if a needed tool is missing."""
    findings = (python(), *libraries(), *compilers())
    if arguments.format == "json":
        print(json.dumps({"tools": [asdict(finding) for finding in findings]}, indent=2))
    else:
        print_table(findings)
    return 2 if any(f.needed and f.found is None for f in findings) else 0


def print_table(findings: tuple[Finding, ...]) -> None:
    """A line a tool; under a missing one, the way to get it."""
    width = max(len(f.tool) for f in findings)
    for f in findings:
        mark = "ok  " if f.found is not None else ("MISS" if f.needed else "-   ")
        print(f"{mark} {f.tool:<{width}}  {f.found if f.found is not None else 'not found'} ({f.use})")
        if f.found is None:
            print(f"     {'':<{width}}  get it: {f.way_out}")


def python() -> Finding:
    """The interpreter that runs us."""
    from fuzzyspec.version import __version__

    found = f"{sys.version.split()[0]}, fuzzyc {__version__}"
    return Finding("python", "runs the compiler", found, "install Python 3.11 or later", True)


def libraries() -> tuple[Finding, ...]:
    """Python packages: those we need, and those that a command needs."""
    listed = (
        ("lark", "reads specs", True),
        ("jinja2", "lays out C", True),
        ("numpy", "exact and integer models", True),
        ("cffi", "calls the generated C", True),
        ("matplotlib", "fuzzyc sim: figures", False),
    )
    return tuple(
        Finding(name, use, package_version(name), f"pip install {name}", needed) for name, use, needed in listed
    )


def package_version(name: str) -> str | None:
    """Version of an installed distribution."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(name)
    except PackageNotFoundError:
        return None


def compilers() -> tuple[Finding, ...]:
    """The C compiler that ``verify`` builds with, its sanitizers, and the cross compilers."""
    from fuzzyspec.native.toolchain import find_toolchain

    try:
        toolchain = find_toolchain()
    except Exception:
        return ()
    return (Finding("C compiler", "fuzzyc verify", toolchain.name, "", True),)
