"""How often a program does what: the features of a call, as a mean over drawn inputs and along the longest path.

How often a block is entered is not guessed: the integer program is run over the first cases of the stream that every
cost is measured with (``inputs``), and the blocks that they enter are counted. That is the program's own arithmetic, so
it comes out the same everywhere.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace

from fuzzyspec.estimate.features import Features, add, bits_of, of_statement
from fuzzyspec.estimate.inputs import draw_cases
from fuzzyspec.estimate.pressure import Pressure, arrays, pressure
from fuzzyspec.estimate.weights import Weights
from fuzzyspec.fixed.division import CELLS, kernel_of, shared
from fuzzyspec.fixed.program import (
    Branch,
    CallFunction,
    Each,
    Element,
    Function,
    ListPort,
    Loop,
    MulHigh,
    Program,
    Quotient,
    Stmt,
    Window,
)
from fuzzyspec.fixed.prune import expressions, nodes, prune, statements
from fuzzyspec.fixed.run import run

CASES = 64
"""Inputs that a profile is a mean over."""
ONCE = ("multiply.32", "multiply_wide.16", "multiply_wide.32", "divide")
"""What a machine may call its compiler's library for, which is then there once."""


@dataclass(frozen=True)
class Profile:
    """Features of one function with all that it calls.

    ``mean``: executed in a call. ``code``: written, each function once, and ``kernel_*`` for what is there once.
    ``tables``: bytes of tables. ``frame``: what decides the stack, callees by the deepest.
    """

    mean: Features
    code: Features
    tables: int
    frame: Features
    paths: Mapping[str, Path]
    root: str

    def longest(self, weights: Weights) -> float:
        """The weight of the heaviest path through the function: every list full, every loop to its end."""
        known: dict[str, float] = {}
        for name, path in self.paths.items():
            known[name] = path.longest(weights, known)
        return known[self.root]


@dataclass(frozen=True)
class Path:
    """A block as a path goes through it; ``rounds`` of ``inner`` blocks, the heavier one of each ``forks``."""

    features: Features
    inner: tuple[tuple[int, Path], ...]
    forks: tuple[tuple[Path, Path], ...]
    calls: tuple[str, ...]

    def longest(self, weights: Weights, known: Mapping[str, float]) -> float:
        """``known``: the longest of the functions called."""
        own = weights.of(self.features)
        own += sum(n * p.longest(weights, known) for n, p in self.inner)
        own += sum(max(a.longest(weights, known), b.longest(weights, known)) for a, b in self.forks)
        return own + sum(known[c] for c in self.calls)


def profile(program: Program, name: str, cases: int = CASES) -> Profile:
    """Of one function. The program is pruned here, as C prints it."""
    needed = _needed(program, name)
    bare = Program(program.name, tuple(replace(f, body=prune(f.body)) for f in needed))
    visits: Counter[int] = Counter()

    def visit(body: tuple[Stmt, ...], lanes: int) -> None:
        visits[id(body)] += lanes

    function = bare.function(name)
    inputs, state = draw_cases(bare, function, cases)
    run(bare, name, inputs, state, visit=visit)
    crowds = {f.name: pressure(f.body) for f in bare.functions}
    blocks: dict[int, Features] = {}
    code: dict[str, float] = {}
    paths: dict[str, Path] = {}
    for f in bare.functions:
        lists = {p.name: p.capacity for p in f.inputs if isinstance(p, ListPort)}
        paths[f.name] = _path(f.body, "entry", crowds[f.name], lists, blocks, code)
    mean: dict[str, float] = {}
    for key, features in blocks.items():
        add(mean, features, visits[key] / cases)
    add(code, _kernels(bare))
    return Profile(
        {k: v for k, v in mean.items() if v},
        dict(code),
        _table_bytes(bare),
        _frame(bare, crowds, name),
        paths,
        name,
    )


def _needed(program: Program, name: str) -> tuple[Function, ...]:
    """The function and all that it calls, callees first."""
    wanted = {name}
    for f in reversed(program.functions):
        if f.name in wanted:
            wanted |= {s.callee for s in statements(f.body) if isinstance(s, CallFunction)}
    return tuple(f for f in program.functions if f.name in wanted)


def _path(
    body: tuple[Stmt, ...],
    entered: str,
    crowd: Pressure,
    lists: Mapping[str, int],
    blocks: dict[int, Features],
    code: dict[str, float],
) -> Path:
    """``entered``: the feature that entering the block is, as a function, a loop's round or nothing."""
    if not body:
        return Path({}, (), (), ())
    found = dict(crowd.blocks[id(body)])
    if entered:
        add(found, {entered: 1})
    inner: list[tuple[int, Path]] = []
    forks: list[tuple[Path, Path]] = []
    calls: list[str] = []
    for statement in body:
        add(found, of_statement(statement))
        match statement:
            case Loop(_, count, block):
                inner.append((count, _path(block, "round", crowd, lists, blocks, code)))
            case Each(name, _, block):
                inner.append((lists[name], _path(block, "element", crowd, lists, blocks, code)))
            case Branch(_, then, other):
                arms = [_path(arm, "", crowd, lists, blocks, code) for arm in (then, other)]
                forks.append((arms[0], arms[1]))
            case CallFunction(callee=callee):
                calls.append(callee)
            case _:
                pass
    add(code, found)
    blocks[id(body)] = found
    return Path(found, tuple(inner), tuple(forks), tuple(calls))


def _kernels(program: Program) -> Features:
    """What is there once, however often it is called."""
    found: dict[str, float] = {}
    bodies = [f.body for f in program.functions]
    used = [node for body in bodies for e in expressions(body) for node in nodes(e)]
    dividing = {kernel_of(node) for node in used if isinstance(node, Quotient)}
    for kernel in sorted(set(shared(dividing).values())):
        add(found, {f"kernel_{kernel.by}.{kernel.digit_bits}": 1, "kernel_steps": len(kernel.steps)})
    if any(isinstance(node, MulHigh) for node in used):
        add(found, {"kernel_mul_high": 1})
    library = {feature for body in bodies for s in statements(body) for feature in of_statement(s)}
    add(found, {f"kernel_{feature}": 1 for feature in ONCE if feature in library})
    return found


def _table_bytes(program: Program) -> int:
    size = 0
    for f in program.functions:
        used = [node for e in expressions(f.body) for node in nodes(e)]
        read = {n.array for n in used if isinstance(n, Element) and n.table}
        read |= {s.table for s in statements(f.body) if isinstance(s, Window)}
        size += sum(len(t.values) * bits_of(t.ctype) // 8 for t in f.tables if t.name in read)
    by_table = any(
        isinstance(n, Quotient) and n.by == "reciprocal"
        for f in program.functions
        for e in expressions(f.body)
        for n in nodes(e)
    )
    return size + (CELLS if by_table else 0)


def _frame(program: Program, crowds: Mapping[str, Pressure], name: str) -> Features:
    """The deepest chain of calls by what it keeps."""
    deepest: dict[str, dict[str, float]] = {}
    for f in program.functions:
        crowd = crowds[f.name]
        own: dict[str, float] = {"entry": 1, "arrays": arrays(f.body), "words": crowd.words, "bytes": crowd.bytes}
        called = [s for s in statements(f.body) if isinstance(s, CallFunction)]
        own["passed"] = sum(len(s.arguments) + len(s.results) for s in called)
        below = [deepest[s.callee] for s in called]
        if below:
            add(own, max(below, key=lambda c: (c["arrays"] + c["bytes"], c["words"])))
        deepest[f.name] = own
    return deepest[name]
