"""The host's C compiler: which one, with which flags, and what it said."""

from __future__ import annotations

import importlib.util
import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from fuzzyspec.diagnostics.refusal import MissingTool, Refusal

STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wsign-conversion", "-Wshadow")
"""What the generated C is clean under, on top of ``-std=c99``."""

SANITIZERS: tuple[tuple[str, ...], ...] = (
    ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer", "-g"),
    ("-fsanitize=undefined", "-fno-sanitize-recover=all", "-g"),
    ("-fsanitize=undefined", "-fsanitize-undefined-trap-on-error", "-g"),
)
"""Best first: some compilers come without the address sanitizer's library, some without either."""

MOST_SECONDS = 600
"""A compiler that takes longer is given up: the longest C that a spec can give takes one minute."""

INTERRUPTED = ("terminated signal", "signal terminated program", "No space left on device", "virtual memory exhausted")
"""What a compiler says that did not come to judge the C."""


class BuildError(Exception):
    """The compiler rejected the C; ``output`` is what it printed."""

    def __init__(self, message: str, output: str) -> None:
        self.output = output
        super().__init__(message)


@dataclass(frozen=True, slots=True)
class Toolchain:
    """A C compiler as the words of its command (``("gcc",)``, ``("python", "-m", "ziglang", "cc")``)."""

    command: tuple[str, ...]

    @property
    def name(self) -> str:
        """For reports: the program's name, without its folder."""
        return "zig cc" if "ziglang" in self.command else Path(self.command[0]).name

    def build(self, sources: Sequence[Path], target: Path, flags: Sequence[str], libraries: Sequence[str] = ()) -> str:
        """Compile and link ``sources`` into ``target``; what the compiler printed is returned.

        ``libraries`` (``-lgcc``) follow the sources, as linkers want it.

        Raises BuildError where it rejects the C, MissingTool where it cannot be started, and Refusal where it comes to
        no verdict: killed, out of disk or memory, out of time, or ended without a file.
        """
        # Relative names, so that what the compiler prints names no temporary folder.
        folder = target.parent
        names = [os.path.relpath(s, folder) for s in sources]
        command = [*self.command, *flags, "-o", target.name, *names, *libraries]
        try:
            done = subprocess.run(
                command,
                cwd=folder,
                env={**os.environ, "LC_ALL": "C"},
                capture_output=True,
                text=True,
                errors="replace",
                check=False,
                timeout=MOST_SECONDS,
            )
        except subprocess.TimeoutExpired as error:
            raise Refusal(f"{self.name} was stopped: it took more than {MOST_SECONDS} seconds") from error
        except OSError as error:
            raise MissingTool(f"cannot run the C compiler `{self.command[0]}`: {error.strerror or error}") from error
        said = done.stdout + done.stderr
        if done.returncode < 0:
            raise Refusal(
                f"{self.name} was killed by signal {-done.returncode} before it was done",
                "try again, with more memory if that was short",
            )
        unwell = next((line for line in said.splitlines() if any(sign in line for sign in INTERRUPTED)), None)
        if done.returncode != 0 and unwell is not None:
            raise Refusal(f"{self.name} could not do its work: {unwell.strip()}")
        if done.returncode == 0 and not target.exists():
            raise Refusal(f"{self.name} reported success, yet made no file", "see whether it is a C compiler")
        if done.returncode != 0:
            raise BuildError(f"{self.name} rejected the C (exit status {done.returncode})", said)
        return said


def find_toolchain(environ: Mapping[str, str] = os.environ) -> Toolchain:
    """``CC`` if set, else gcc, clang, cc, else the ``ziglang`` package; MissingTool if there is none."""
    chosen = environ.get("CC", "").strip()
    if chosen:
        words = tuple(shlex.split(chosen))
        if shutil.which(words[0], path=environ.get("PATH")) is None:
            raise MissingTool(f"CC names `{words[0]}`, which was not found", "unset CC or set it to a C compiler")
        return Toolchain(words)
    for name in ("gcc", "clang", "cc"):
        if shutil.which(name, path=environ.get("PATH")) is not None:
            return Toolchain((name,))
    if importlib.util.find_spec("ziglang") is not None:
        return Toolchain((sys.executable, "-m", "ziglang", "cc"))
    raise MissingTool(
        "no C compiler was found (tried CC, gcc, clang, cc and the ziglang package)",
        "install gcc or clang, or run `pip install ziglang`",
    )


def host_toolchains() -> tuple[Toolchain, ...]:
    """What ``find_toolchain`` finds, and gcc and clang where they are here besides. MissingTool if there is none."""
    found = [find_toolchain(), *(Toolchain((name,)) for name in ("gcc", "clang") if shutil.which(name) is not None)]
    return tuple(dict.fromkeys(found))


def optimised(*, errors: bool, level: str = "O2") -> tuple[str, ...]:
    """Flags of the ordinary build; ``errors`` turns warnings into errors, as for the compiler's own output."""
    return ("-std=c99", f"-{level}", *STRICT, *(("-Werror",) if errors else ()))


def shared() -> tuple[str, ...]:
    """Flags that make a shared object whose own symbols win over those already loaded."""
    return ("-fPIC", "-shared", "-Wl,-Bsymbolic") if sys.platform.startswith("linux") else ("-fPIC", "-shared")
