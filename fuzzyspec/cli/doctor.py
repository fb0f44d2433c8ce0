"""``fuzzyc doctor``: which tools are here, which are not, and how to get them."""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fuzzyspec.native.toolchain import Toolchain


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
        description="List the tools that fuzzyc can use, with what was found. "
        "Exit status 2 if one that it needs is missing.",
    )
    parser.add_argument("--format", choices=("text", "json"), default="text")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Print the findings; 2 if a needed tool is missing."""
    findings = (python(), *libraries(), *host_compiler(), *cross_compilers())
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
        ("jinja2", "lays out C", True),
        ("numpy", "exact and integer models", True),
        ("cffi", "calls the generated C", True),
        ("matplotlib", "fuzzyc sim: figures", False),
        ("ziglang", "fuzzyc cost, verify --target: C for every machine but AVR", False),
        ("unicorn", "fuzzyc cost, verify --target: emulates Cortex-M, RISC-V, MIPS", False),
        ("wasmtime", "fuzzyc verify --target: runs WebAssembly", False),
        ("pyelftools", "fuzzyc cost, verify --target: reads what was built", False),
        ("z3-solver", "fuzzyc prove: lemmas", False),
        ("bitwuzla", "fuzzyc prove: lemmas", False),
        ("lark", "after a change of grammar/: the parser's table", False),
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


def host_compiler() -> tuple[Finding, ...]:
    """The C compiler that ``verify`` builds with, and the sanitizers that it can link."""
    from fuzzyspec.diagnostics.refusal import MissingTool
    from fuzzyspec.native.toolchain import find_toolchain

    compiler, sanitizers = "C compiler", "sanitizers"
    get_compiler = "install gcc or clang (Debian, Ubuntu: apt install gcc), or pip install ziglang"
    get_sanitizers = "install your compiler's libasan and libubsan, or clang"
    try:
        toolchain = find_toolchain()
    except MissingTool as error:
        return (
            Finding(compiler, "fuzzyc verify, eval, sim", None, error.way_out or get_compiler, True),
            Finding(sanitizers, "fuzzyc verify", None, get_sanitizers, False),
        )
    return (
        Finding(compiler, "fuzzyc verify, eval, sim", first_line(toolchain.command), get_compiler, True),
        Finding(sanitizers, "fuzzyc verify", linkable_sanitizers(toolchain), get_sanitizers, False),
    )


def linkable_sanitizers(toolchain: Toolchain) -> str | None:
    """The strongest set of sanitizers that a trivial program builds with."""
    from fuzzyspec.native.toolchain import SANITIZERS, BuildError

    with tempfile.TemporaryDirectory(prefix="fuzzyc") as name:
        source = Path(name) / "trivial.c"
        source.write_text("int main(void) { return 0; }\n", encoding="utf-8")
        for flags in SANITIZERS:
            try:
                toolchain.build([source], source.with_suffix(""), flags)
            except BuildError:
                continue
            return " ".join(flag for flag in flags if flag.startswith("-fsanitize"))
    return None


def cross_compilers() -> tuple[Finding, ...]:
    """Compilers for boards and the emulator of AVR, which a user of the generated C may use too; the analyser."""
    listed = (
        ("arm-none-eabi-gcc", "C for Cortex-M", "apt install --no-install-recommends gcc-arm-none-eabi"),
        ("avr-gcc", "C for AVR", "apt install gcc-avr avr-libc"),
        ("riscv64-unknown-elf-gcc", "C for RISC-V", "apt install gcc-riscv64-unknown-elf"),
        ("mips-linux-gnu-gcc", "C for MIPS, big-endian", "apt install gcc-mips-linux-gnu"),
    )
    here = "found" if shutil.which("simavr") else None
    qemu = "found" if all(shutil.which(f"qemu-{name}") for name in ("arm", "riscv32", "mips")) else None
    emulator = Finding(
        "qemu-user", "fuzzyc verify --emulator qemu: Cortex-M, RISC-V, MIPS", qemu, "apt install qemu-user", False
    )
    avr = Finding("simavr", "fuzzyc cost, verify --target: runs AVR, cycle by cycle", here, "apt install simavr", False)
    here = "found" if shutil.which("frama-c") else None
    eva = Finding("frama-c", "fuzzyc prove", here, "apt install frama-c-base", False)
    compilers = (
        Finding(name, use, first_line((name,)) if shutil.which(name) else None, way_out, False)
        for name, use, way_out in listed
    )
    return (*compilers, avr, emulator, eva)


def first_line(command: tuple[str, ...]) -> str:
    """What a compiler says of its version."""
    done = subprocess.run([*command, "--version"], capture_output=True, text=True, errors="replace", check=False)
    lines = (done.stdout or done.stderr).splitlines()
    return lines[0].strip() if lines else command[0]
