"""Every edit of the C that changes an output is found: one token after the other is changed, and verify has to see it.

What "changes an output" means is settled by eight million cases that verify does not use.
"""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from dataclasses import dataclass

import pytest

from fuzzyspec import api
from fuzzyspec.lower import Options
from fuzzyspec.native import BuildError, Death, NativeModule, NativeProcess
from fuzzyspec.verify.bench import BLOCK, Bench
from fuzzyspec.verify.cases import batches, bulk
from tests.verify import verify_specs

CASES = 100_000
TRUTH = range(512)
OFTEN = 5
"""Blocks of the truth that a changed constant shows in, or it may escape; tables and comparisons may not."""

SWAPS = {"<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"), "==": ("!=",), "!=": ("==",)}


@dataclass(frozen=True)
class Mutant:
    """One changed token, and what kind it is of."""

    kind: str
    line: int
    text: str
    source: str


def mutants(source: str) -> Iterator[Mutant]:
    """Numbers up and down by one, comparisons at their edge and turned round; no comments, no directives."""
    code = re.sub(r"/\*.*?\*/|^#.*?$", lambda m: " " * len(m[0]), source, flags=re.DOTALL | re.MULTILINE)
    tables = [m.span() for m in re.finditer(r"static const [^;]*;", code)]
    for match in re.finditer(r"(?<![\w.])(\d+)(U?)\b|(?<= )(<=|>=|<|>|==|!=)(?= )", code):
        in_table = any(a <= match.start() < b for a, b in tables)
        if match[3]:
            changed = [("comparison", other) for other in SWAPS[match[3]]]
        else:
            near = [int(match[1]) + d for d in (1, -1) if int(match[1]) + d >= 0]
            changed = [("table" if in_table else "constant", f"{n}{match[2]}") for n in near]
        for kind, text in changed:
            yield Mutant(
                kind,
                source.count("\n", 0, match.start()) + 1,
                f"{match[0]} -> {text}",
                source[: match.start()] + text + source[match.end() :],
            )


@dataclass
class Judge:
    """Knows the truth about a mutant, and what verify says of it."""

    spec: api.Spec
    files: dict[str, bytes]
    module: NativeModule

    def blocks_that_differ(self, process: NativeProcess) -> int:
        """Of the truth; all of them where it dies."""
        name = self.spec.default_function
        seen = process.hashes(name, 999, TRUTH, BLOCK)
        return len(TRUTH) if isinstance(seen, Death) else sum(a != b for a, b in zip(self.truth, seen, strict=True))

    def found(self, process: NativeProcess) -> bool:
        """Whether verify finds the mutant without its sanitizers."""
        bench = Bench(self.subject, process, None)
        for batch, run in self.cases:
            bench._through_c(batch, run)
            if bench.failures:
                return True
        bench.in_bulk(process, self.module, 1, range(bulk(self.subject, CASES) // BLOCK))
        return bool(bench.failures)

    def found_by_sanitizers(self, files: dict[str, bytes]) -> bool:
        """What reads beyond an array may give one result here and another there: that is for the sanitizers."""
        with NativeProcess(self.spec.lowered.program, files, sanitize=True, warnings_are_errors=False) as process:
            bench = Bench(self.subject, None, process)
            for batch, _ in self.cases:
                bench._through_sanitizers(batch)
            return bool(bench.failures)

    def __post_init__(self) -> None:
        self.subject = self.spec._subjects[0]
        self.truth = self.module.hashes(self.subject.name, 999, TRUTH, BLOCK)
        self.cases = [(b, self.subject.fixed(b.inputs, b.state)) for b in batches(self.subject, 1, CASES)]


@pytest.fixture(scope="module", params=["size", "speed"])
def judge(request: pytest.FixtureRequest) -> Iterator[Judge]:
    """Of the danger controller: by loops and tables, and with code of its own for every block of cells."""
    spec = api.load(verify_specs.DANGER)
    files = dict(spec.compile(Options(optimize=request.param)).files)
    with NativeModule(spec.lowered.program, files) as module:
        yield Judge(spec, files, module)


def escaped(judge: Judge, chosen: list[Mutant]) -> list[str]:
    """The mutants that differ, but are not found; a complaint where none is found at all."""
    missed, found = [], 0
    for mutant in chosen:
        edited = {**judge.files, "small.c": mutant.source.encode()}
        try:
            process = NativeProcess(judge.spec.lowered.program, edited, warnings_are_errors=False)
        except BuildError:
            continue
        with process:
            if judge.found(process):
                found += 1
                continue
            often = judge.blocks_that_differ(process)
            enough = often >= (OFTEN if mutant.kind == "constant" else 1)
            if enough and not judge.found_by_sanitizers(edited):
                missed.append(f"line {mutant.line}: {mutant.text} ({often} blocks)")
    return missed if found or not chosen else ["no mutant is found"]


def all_mutants(judge: Judge) -> list[Mutant]:
    """In an order without order."""
    found = list(mutants(judge.files["small.c"].decode()))
    random.Random(7).shuffle(found)
    return found


@pytest.mark.parametrize(("kind", "many"), [("table", 8), ("comparison", 4), ("constant", 6)])
def test_mutants_are_found(kind: str, many: int, judge: Judge) -> None:
    """A sample of each kind: those that differ are found. Only what has no tables has none of their kind."""
    chosen = [m for m in all_mutants(judge) if m.kind == kind][:many]
    assert chosen or (kind == "table" and b"static const" not in judge.files["small.c"])
    assert escaped(judge, chosen) == []


@pytest.mark.long
def test_all_mutants_are_found(judge: Judge) -> None:
    """Every single one."""
    assert escaped(judge, all_mutants(judge)) == []
