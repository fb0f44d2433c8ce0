"""The blocks of a function, and an order in which loops nest."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from fuzzyspec.cost.worst.code import (
    Add,
    Apply,
    Branch,
    Call,
    Condition,
    Decode,
    Effect,
    Instruction,
    Judge,
    Jump,
    Leave,
    NotModelled,
    Set,
    Subtract,
)


@dataclass(frozen=True, slots=True)
class Block:
    """A straight run of instructions. ``following``: where it may go inside the function, the way of no jump first."""

    instructions: tuple[Instruction, ...]
    following: tuple[int, ...]

    @property
    def start(self) -> int:
        return self.instructions[0].address

    @property
    def last(self) -> Instruction:
        return self.instructions[-1]


@dataclass(frozen=True, slots=True)
class Place:
    """Where a block stands: its index in every loop around it, outermost first, then its own.

    ``loops`` are the first blocks of those loops. ``heads``: it is the first block of the innermost.
    """

    indices: tuple[int, ...]
    loops: tuple[int, ...]
    heads: bool


@dataclass(frozen=True, slots=True)
class Graph:
    """All that is reached from an entry without following calls. Along every edge but those that begin a loop's next
    round the places grow."""

    entry: int
    blocks: Mapping[int, Block]
    places: Mapping[int, Place]


def flow_graph(entry: int, decode: Decode) -> Graph:
    """The graph of the function at an address. Raises NotModelled."""
    found = _instructions(entry, decode)
    starts = {entry}
    for instruction in found.values():
        ways = _ways(instruction)
        if ways is not None:
            starts.update(ways)
            starts.add(instruction.after)
    blocks: dict[int, Block] = {}
    for start in sorted(starts & found.keys()):
        run = [found[start]]
        while _ways(run[-1]) is None and run[-1].after not in starts:
            run.append(found[run[-1].after])
        ways = _ways(run[-1])
        blocks[start] = Block(tuple(run), (run[-1].after,) if ways is None else ways)
    places: dict[int, Place] = {}
    _nest(entry, [entry, *blocks], {a: b.following for a, b in blocks.items()}, (), (), places)
    return Graph(entry, blocks, places)


def _instructions(entry: int, decode: Decode) -> dict[int, Instruction]:
    """Every instruction that may run, by address, with the guards that fall on it."""
    found: dict[int, Instruction] = {}
    waiting = [entry]
    while waiting:
        at = waiting.pop()
        guards: tuple[Condition, ...] = ()
        while at not in found:
            try:
                instruction = decode(at)
            except NotModelled as error:
                raise NotModelled(f"{error} at {at:#x}") from error
            if guards:
                instruction = _guarded(instruction, guards[0])
                guards = guards[1:]
            guards = instruction.guards or guards
            found[at] = instruction
            ways = _ways(instruction)
            if ways is None:
                at = instruction.after
                continue
            if guards and instruction.after in ways:
                raise NotModelled(f"a branch amid guarded instructions at {at:#x}")
            waiting.extend(ways)
            break
    return found


def _guarded(instruction: Instruction, guard: Condition) -> Instruction:
    """The instruction under a guard, where the short ones leave the flags alone, unless they only compare."""
    effects = instruction.effects
    if instruction.size == 2:
        effects = tuple(e for effect in effects for e in _quiet(effect))
    return replace(instruction, effects=effects, guard=guard)


def _quiet(effect: Effect) -> tuple[Effect, ...]:
    match effect:
        case Subtract(register, left, right):
            return (Set(register, Apply("-", left, right)),)
        case Add(register, left, right, carry):
            return (Set(register, Apply("+", Apply("+", left, right), carry)),)
        case Judge():
            return ()
        case _:
            return (effect,)


def _ways(instruction: Instruction) -> tuple[int, ...] | None:
    """Where an instruction may go inside its function; None where it just goes on."""
    on = (instruction.after,)
    match instruction.flow:
        case None:
            return None
        case Jump(target):
            return (*on, target) if instruction.guard is not None else (target,)
        case Branch(_, target):
            return (*on, target)
        case Call():
            if instruction.guard is not None:
                raise NotModelled(f"a conditional call at {instruction.address:#x}")
            return on
        case Leave():
            return on if instruction.guard is not None else ()


def _nest(
    entry: int,
    members: list[int],
    following: Mapping[int, tuple[int, ...]],
    indices: tuple[int, ...],
    loops: tuple[int, ...],
    places: dict[int, Place],
) -> None:
    """Place the members: by components in topological order, a loop's first block before the rest of it, which is
    nested again (Bourdoncle's weak topological order)."""
    for index, component in enumerate(_components(members, set(members), following)):
        head = component[0]
        if len(component) == 1 and head not in following[head]:
            places[head] = Place((*indices, index), loops, False)
            continue
        outside = set(following) - set(component)
        entered = {target for block in outside for target in following[block]} | {entry}
        heads = _heads(component, entered, following)
        inner = (*indices, index)
        around = (*loops, heads[0])
        for order, block in enumerate(heads):
            places[block] = Place((*inner, order - len(heads)), around, True)
        body = [block for block in component if block not in heads]
        _nest(entry, body, following, inner, around, places)


def _heads(component: list[int], entered: set[int], following: Mapping[int, tuple[int, ...]]) -> list[int]:
    """The blocks at which the rounds of a loop begin, in the order in which they may follow on one another.

    It is the one at which the loop is entered; of several, the one without which least of it still goes round, and
    before it those that lead there only. Begun elsewhere, rounds would mix.
    """
    entries = sorted(block for block in component if block in entered)
    members = set(component)
    if len(entries) == 1:
        return entries
    heads = [min(entries, key=lambda entry: _going_round([b for b in component if b != entry], following))]
    waiting = [block for block in entries if block not in heads]
    while more := [block for block in waiting if members.intersection(following[block]) <= set(heads)]:
        heads = [*more, *heads]
        waiting = [block for block in waiting if block not in more]
    return heads


def _going_round(blocks: list[int], following: Mapping[int, tuple[int, ...]]) -> int:
    """How many of the blocks lie in loops among them."""
    found = _components(blocks, set(blocks), following)
    return sum(len(c) for c in found if len(c) > 1 or c[0] in following[c[0]])


def _components(entries: Iterable[int], members: set[int], following: Mapping[int, tuple[int, ...]]) -> list[list[int]]:
    """The strongly connected components of the members reached, in topological order (Tarjan, without recursion); the
    block at which each was entered first leads it."""
    number: dict[int, int] = {}
    low: dict[int, int] = {}
    stack: list[int] = []
    on_stack: set[int] = set()
    found: list[list[int]] = []
    for entry in entries:
        if entry in number:
            continue
        work = [(entry, iter([t for t in following[entry] if t in members]))]
        number[entry] = low[entry] = len(number)
        stack.append(entry)
        on_stack.add(entry)
        while work:
            at, ways = work[-1]
            for target in ways:
                if target not in number:
                    number[target] = low[target] = len(number)
                    stack.append(target)
                    on_stack.add(target)
                    work.append((target, iter([t for t in following[target] if t in members])))
                    break
                if target in on_stack:
                    low[at] = min(low[at], number[target])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[at])
                if low[at] == number[at]:
                    cut = stack.index(at)
                    component = stack[cut:]
                    del stack[cut:]
                    on_stack.difference_update(component)
                    found.append(component)
    found.reverse()
    return found
