"""What Cppcheck's MISRA addon finds in C, and what of it ``docs/misra.md`` does not allow."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "misra.md"
ROW = re.compile(r"^\| (\d+\.\d+) \| (?:advisory|required|mandatory) \| `(.+?)` \| .+ \| .+ \|$", re.MULTILINE)


@dataclass(frozen=True)
class Finding:
    """A rule, and the line that it was found on."""

    rule: str
    place: str
    line: str


def allowed(page: str) -> dict[str, str]:
    """By rule, what a line with such a finding must hold."""
    return dict(ROW.findall(page))


def findings(folder: Path) -> list[Finding]:
    """What the addon finds in the C files of a folder and in the headers that they read."""
    sources = sorted(p.name for p in folder.glob("*.c"))
    options = ["--addon=misra", "--std=c99", "--platform=unix32", "--enable=style", "--template={file}:{line}:{id}"]
    line = [sys.executable, "-m", "cppcheck", *options, *sources]
    done = subprocess.run(line, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    texts = {p.name: p.read_text(encoding="utf-8").splitlines() for p in folder.iterdir()}
    found = re.findall(r"^(.+):(\d+):misra-c2012-(\d+\.\d+)$", done.stderr, re.MULTILINE)
    return [Finding(rule, f"{name}:{at}", texts[name][int(at) - 1]) for name, at, rule in found]


def beyond(found: list[Finding], page: str) -> list[Finding]:
    """The findings that the page does not allow."""
    lines = allowed(page)
    return [f for f in found if f.rule not in lines or re.search(lines[f.rule], f.line) is None]
