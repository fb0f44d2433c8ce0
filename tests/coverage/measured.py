"""Which outcomes of its conditions the generated C has had, once verify's own cases have gone through it."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fuzzyspec.fixed.program import Program
from fuzzyspec.native import Death, NativeProcess
from fuzzyspec.native.toolchain import Toolchain
from fuzzyspec.native.workspace import PRODUCT
from fuzzyspec.verify import DEFAULT_SEED
from fuzzyspec.verify.cases import DEFAULT_CASES, batches
from fuzzyspec.verify.subject import Arrays, Subject

PROGRAM, RAW = "runner", "counts-%m.profraw"
"""What is run, and where it adds up its counts (%m: the same file for all runs of one program)."""
COVERED = Toolchain(("clang-19", f"-fprofile-instr-generate={RAW}", "-fcoverage-mapping", "-fcoverage-mcdc"))


@dataclass(frozen=True, order=True)
class Condition:
    """What decides a branch, by where it stands in the C: from line and column to line and column, from 1 on."""

    line: int
    column: int
    end_line: int
    end_column: int
    function: str

    def of(self, source: str) -> str:
        """Its text, on one line."""
        lines = source.splitlines()[self.line - 1 : self.end_line]
        lines[-1] = lines[-1][: self.end_column - 1]
        lines[0] = lines[0][self.column - 1 :]
        return " ".join(" ".join(lines).split())


@dataclass(frozen=True)
class Outcome:
    """A condition and a side of it."""

    condition: Condition
    holds: bool


@dataclass(frozen=True)
class Coverage:
    """``had`` and ``missed``: the outcomes that came up, and those that did not.

    ``conditions``: how many there are in decisions of several. ``tied``: those of them for which no two cases show
    that they change the decision by themselves.
    """

    had: tuple[Outcome, ...]
    missed: tuple[Outcome, ...]
    conditions: int
    tied: tuple[Condition, ...]


def measured(
    program: Program, files: Mapping[str, bytes], subjects: tuple[Subject, ...], cases: int = DEFAULT_CASES
) -> Coverage:
    """Run verify's batches for every function through the C, as verify would with its defaults."""
    with NativeProcess(program, files, COVERED, warnings_are_errors=False, seconds=120.0) as process:
        for subject in subjects:
            left: Arrays = {}
            for batch in batches(subject, DEFAULT_SEED, cases):
                done = process.run(subject.name, batch.inputs, left if batch.follow else batch.state)
                assert not isinstance(done, Death), done
                left = done.state
        source = next(n for n in files if n.endswith(".c") and not n.endswith("_selftest.c"))
        return _read(process._workspace.path, source)


def _read(folder: Path, source: str) -> Coverage:
    raw = [p.name for p in folder.glob("*.profraw")]
    _tool(folder, "llvm-profdata-19", "merge", "-o", "counts.profdata", *raw)
    words = ("export", "-format=text", "-instr-profile=counts.profdata", PROGRAM, f"{PRODUCT}/{source}")
    (told,) = json.loads(_tool(folder, "llvm-cov-19", *words))["data"]
    counts: dict[Outcome, int] = {}
    tied: list[Condition] = []
    conditions = 0
    for function in told["functions"]:
        if Path(function["filenames"][0]).name != source:
            continue
        name = function["name"].rpartition(":")[2]
        places = sorted(_place(branch, name) for branch in function["branches"])
        for branch in function["branches"]:
            for holds, count in ((True, branch[4]), (False, branch[5])):
                counts[Outcome(_place(branch, name), holds)] = count
        for record in function.get("mcdc_records", []):
            whole, alone = _place(record, name), record[-1]
            parts = [p for p in places if _inside(p, whole)]
            assert len(parts) == len(alone), whole
            conditions += len(parts)
            tied += [part for part, shown in zip(parts, alone, strict=True) if not shown]
    had, missed = ([o for o, count in counts.items() if bool(count) == came] for came in (True, False))
    return Coverage(tuple(had), tuple(missed), conditions, tuple(tied))


def _inside(part: Condition, whole: Condition) -> bool:
    start, end = (part.line, part.column), (part.end_line, part.end_column)
    return (whole.line, whole.column) <= start and end <= (whole.end_line, whole.end_column)


def _place(row: list[Any], function: str) -> Condition:
    line, column, end_line, end_column = row[:4]
    return Condition(line, column, end_line, end_column, function)


def _tool(folder: Path, *words: str) -> str:
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, check=True).stdout
