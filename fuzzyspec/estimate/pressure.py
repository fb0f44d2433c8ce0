"""How many locals live at once: beyond a machine's registers they are kept on the stack, and read from there.

Liveness is that of the structured program, backwards: a loop's body is walked twice, so that what the next round reads
lives to the end of this one. Local arrays are in memory anyway and do not count.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import get_args

from fuzzyspec.estimate.features import bits_of
from fuzzyspec.fixed.program import (
    Branch,
    CallFunction,
    CType,
    Define,
    DefineArray,
    Each,
    Local,
    Loop,
    Stmt,
)
from fuzzyspec.fixed.prune import expressions, nodes, statements

WORDS = (4, 7, 11)
"""Registers that a 32-bit machine may have left for locals, as steps that a fit may weigh."""
BYTES = (8, 16, 24)
"""The same of an 8-bit machine."""
SIZES: Mapping[CType, int] = {t: bits_of(t) // 8 for t in get_args(CType)}
Live = dict[str, int]
"""Locals and their bytes."""


@dataclass
class Pressure:
    """``blocks``: per block, by id, the features ``crowded_N`` (words) and ``crowded_bytes_N``; ``words``, ``bytes``:
    the most that lives at once."""

    blocks: dict[int, dict[str, float]] = field(default_factory=dict)
    words: int = 0
    bytes: int = 0


def pressure(body: tuple[Stmt, ...]) -> Pressure:
    """Of a function's pruned body."""
    found = Pressure()
    _block(body, {}, found)
    return found


def arrays(body: tuple[Stmt, ...]) -> int:
    """Bytes of the local arrays."""
    return sum(s.size * bits_of(s.ctype) // 8 for s in statements(body) if isinstance(s, DefineArray))


def _block(body: tuple[Stmt, ...], after: Live, found: Pressure | None) -> Live:
    """What lives before the block, of what lives after it. Without ``found`` nothing is noted."""
    live = dict(after)
    count: dict[str, float] = {}
    for statement in reversed(body):
        read = _read(statement)
        match statement:
            case Define(local, _, _):
                live.pop(local.name, None)
            case Loop(body=inner) | Each(body=inner):
                live |= _block(inner, live, None)
                live |= _block(inner, live, found)
            case Branch(_, then, other):
                live = _block(then, live, found) | _block(other, live, found)
            case CallFunction(results=results):
                for _, local in results:
                    live.pop(local.name, None)
            case _:
                # Also what is assigned: that may stand in a branch, and before it the value that it replaces lives.
                pass
        live |= read
        if found is not None:
            _crowded(live, len(read), found, count)
    if found is not None:
        found.blocks[id(body)] = count
    return live


def _crowded(live: Live, reads: int, found: Pressure, count: dict[str, float]) -> None:
    """Of what is read, the part that the registers do not hold, were it spread evenly."""
    words, size = len(live), sum(live.values())
    found.words, found.bytes = max(found.words, words), max(found.bytes, size)
    if not reads:
        return
    for limit in WORDS:
        if words > limit:
            name = f"crowded_{limit}"
            count[name] = count.get(name, 0.0) + reads * (words - limit) / words
    for limit in BYTES:
        if size > limit:
            name = f"crowded_bytes_{limit}"
            count[name] = count.get(name, 0.0) + reads * (size - limit) / size


def _read(statement: Stmt) -> Live:
    """The locals that a statement itself reads, without the blocks inside it."""
    match statement:
        case Branch(test):
            own: Iterable[object] = nodes(test)
        case Loop() | Each():
            return {}
        case _:
            own = (n for e in expressions((statement,)) for n in nodes(e))
    return {n.name: SIZES[n.ctype] for n in own if isinstance(n, Local)}
