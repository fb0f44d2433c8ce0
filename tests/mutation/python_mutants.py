"""``make mutants-python``: do the tests notice a changed compiler? One place is changed, its nearest tests are run.

Sampled over ``fixed/``, ``lower/``, ``exact/`` and ``check/`` with a fixed seed, in a copy of the checkout. The nearest
tests are those whose file is named after the module, then the rest of its package's, up to the first that fails.
"""

from __future__ import annotations

import argparse
import ast
import itertools
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
TESTS = {
    "fixed": ("tests/fixed", "tests/lower/test_strategies.py"),
    "lower": ("tests/lower", "tests/emit/test_generated.py"),
    "exact": ("tests/exact",),
    "check": ("tests/check", "tests/check_rules"),
}
"""By package: what is run."""
SLOWER = 4
"""So many times what a package's tests take unchanged is no end: a changed loop may never end."""

_COMPARISONS = {
    ast.Lt: ("<", "<="),
    ast.LtE: ("<=", "<"),
    ast.Gt: (">", ">="),
    ast.GtE: (">=", ">"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
    ast.In: ("in", "not in"),
    ast.NotIn: ("not in", "in"),
    ast.Is: ("is", "is not"),
    ast.IsNot: ("is not", "is"),
}
_OPERATORS = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "+"),
    ast.Div: ("/", "*"),
    ast.FloorDiv: ("//", "*"),
    ast.Mod: ("%", "//"),
    ast.LShift: ("<<", ">>"),
    ast.RShift: (">>", "<<"),
    ast.BitAnd: ("&", "|"),
    ast.BitOr: ("|", "&"),
    ast.Pow: ("**", "*"),
}
_CALLS = {"min": "max", "max": "min", "all": "any", "any": "all", "sorted": "list", "floor": "ceil", "ceil": "floor"}


@dataclass(frozen=True)
class Change:
    """``old`` at ``start`` (in bytes) of a module becomes ``new``."""

    module: str
    line: int
    start: int
    old: str
    new: str

    def of(self, source: bytes) -> bytes:
        """The changed module."""
        return source[: self.start] + self.new.encode() + source[self.start + len(self.old.encode()) :]

    def __str__(self) -> str:
        return f"{self.module}:{self.line}: {self.old!r} -> {self.new!r}"


def changes(module: str, source: bytes) -> list[Change]:
    """Every change of a module that leaves it Python."""
    lines = [0]
    for line in source.splitlines(keepends=True):
        lines.append(lines[-1] + len(line))

    def offset(line: int, column: int) -> int:
        return lines[line - 1] + column

    found = []
    for first, last, old, new in _changed(ast.parse(source)):
        start, end = offset(*first), offset(*last)
        old = old or source[start:end].decode()
        at = source.find(old.encode(), start, end)
        if at >= 0 and b"#" not in source[start:at]:
            found.append(Change(module, source.count(b"\n", 0, at) + 1, at, old, new))
    return found


Place = tuple[int, int]


def _changed(tree: ast.AST) -> Iterator[tuple[Place, Place, str, str]]:
    """Between two places: a text ("": all there is) and what it becomes.

    Annotations, docstrings, assertions, messages and what is raised are left alone.
    """
    for node in _code(tree):
        match node:
            case ast.Compare(left, ops, comparators):
                for one, operator, other in zip([left, *comparators], ops, comparators, strict=False):
                    yield _end(one), _begin(other), *_COMPARISONS[type(operator)]
            case ast.BinOp(left, operator, right) if type(operator) in _OPERATORS:
                yield _end(left), _begin(right), *_OPERATORS[type(operator)]
            case ast.AugAssign(target, operator, value) if type(operator) in _OPERATORS:
                old, new = _OPERATORS[type(operator)]
                yield _end(target), _begin(value), f"{old}=", f"{new}="
            case ast.BoolOp(operator, values):
                old, new = ("and", "or") if isinstance(operator, ast.And) else ("or", "and")
                for one, other in itertools.pairwise(values):
                    yield _end(one), _begin(other), old, new
            case ast.UnaryOp(ast.Not(), operand):
                yield _begin(node), _begin(operand), "not ", ""
            case ast.Constant(value) if type(value) is int:
                yield _begin(node), _end(node), "", str(value + 1)
            case ast.Constant(value) if type(value) is bool:
                yield _begin(node), _end(node), str(value), str(not value)
            case ast.Call(ast.Name(name) as function) if name in _CALLS:
                yield _begin(function), _end(function), "", _CALLS[name]
            case ast.Call(ast.Attribute(value, name) as function) if name in _CALLS:
                yield _end(value), _end(function), f".{name}", f".{_CALLS[name]}"
            case ast.Continue():
                yield _begin(node), _end(node), "continue", "break"


def _code(node: ast.AST) -> Iterator[ast.AST]:
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant):
                continue
            if isinstance(child, ast.JoinedStr | ast.Assert | ast.Raise):
                continue
            if isinstance(child, ast.AST):
                yield child
                yield from _code(child)


def _begin(node: ast.expr) -> Place:
    return node.lineno, node.col_offset


def _end(node: ast.expr) -> Place:
    assert node.end_lineno is not None and node.end_col_offset is not None
    return node.end_lineno, node.end_col_offset


def sample(package: str, most: int, seed: int) -> list[Change]:
    """Some changes of a package's modules."""
    everything: list[Change] = []
    for path in sorted((ROOT / "fuzzyspec" / package).rglob("*.py")):
        everything += changes(path.relative_to(ROOT).as_posix(), path.read_bytes())
    return random.Random(f"{seed} {package}").sample(everything, min(most, len(everything)))


def nearest(change: Change, package: str, tree: Path) -> list[str]:
    """The tests to run, those first that are named after the module, or after its folder."""
    parts = Path(change.module).with_suffix("").parts[2:]
    files = [f for entry in TESTS[package] for f in _files(tree / entry)]
    first = [f for f in files if any(p.removesuffix("s") in f.stem for p in parts)]
    return [f.relative_to(tree).as_posix() for f in (*first, *(f for f in files if f not in first))]


def _files(path: Path) -> list[Path]:
    return sorted(path.rglob("test_*.py"), key=lambda p: p.stat().st_size) if path.is_dir() else [path]


def unchanged(package: str, tree: Path) -> float:
    """How many seconds the package's tests take as they are. Exits where one fails."""
    start = time.monotonic()
    by = failing([f.relative_to(tree).as_posix() for entry in TESTS[package] for f in _files(tree / entry)], tree, None)
    if by:
        sys.exit(f"{package}: {by} fails before anything is changed")
    return time.monotonic() - start


def killed_by(change: Change, package: str, tree: Path, seconds: float) -> str:
    """The first test that fails for a change; "" where none does."""
    path = tree / change.module
    before = path.read_bytes()
    path.write_bytes(change.of(before))
    try:
        return failing(nearest(change, package, tree), tree, seconds)
    finally:
        path.write_bytes(before)


def failing(tests: list[str], tree: Path, seconds: float | None) -> str:
    """The first of the tests that fails, "no end" where they take longer, "" where none does."""
    environment = {**os.environ, "PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-n", "0", "-m", "not long"]
    try:
        done = subprocess.run(
            [*command, *tests],
            cwd=tree,
            env=environment,
            capture_output=True,
            text=True,
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return "no end"
    if done.returncode == 0:
        return ""
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return failed[0].split(" - ")[0] if failed else f"exit status {done.returncode}"


def copied(folder: Path) -> Path:
    """The checkout without what git does not know."""
    tree = folder / "tree"
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in filter(None, listed.split("\0")):
        if (ROOT / name).is_file():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, tree / name)
    return tree


def main() -> int:
    """Print what survives, and the score of each package."""
    parser = argparse.ArgumentParser(prog="make mutants-python", description=__doc__)
    parser.add_argument("--sample", type=int, default=75, help="mutants of each package")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=TESTS, nargs="*", default=list(TESTS))
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        tree = copied(Path(folder))
        for package in given.only:
            chosen = sample(package, given.sample, given.seed)
            left, seconds = 0, SLOWER * unchanged(package, tree)
            for change in chosen:
                start = time.monotonic()
                by = killed_by(change, package, tree, seconds)
                left += not by
                print(f"  {time.monotonic() - start:4.0f} s  {change}  {by or 'SURVIVED'}", flush=True)
            print(f"{package}: {len(chosen) - left} of {len(chosen)} killed", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
