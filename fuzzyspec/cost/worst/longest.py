"""The longest path of a call: the code is run over sets of values, every loop round by round.

Where two paths meet, their states are joined and the longer way so far is kept; a branch whose condition is settled
goes one way. So what is found is never below what any run takes, and every loop whose count follows from the code ends
by itself: no bound has to be told.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from operator import or_

from fuzzyspec.cost.worst.code import CONTRARY, Branch, Call, Decode, Expr, Jump, Leave, NotModelled
from fuzzyspec.cost.worst.flowgraph import Block, Graph, flow_graph
from fuzzyspec.cost.worst.semantics import apply, evaluate, run, where
from fuzzyspec.cost.worst.state import Frame, State, joined, loss
from fuzzyspec.cost.worst.values import Value

_MOST_BLOCKS = 400_000
_MOST_CALLS = 20


class NoBound(Exception):
    """No bound could be derived; the message says why."""


@dataclass(frozen=True, slots=True)
class Cost:
    """Instructions, and cycles where there is a model of them."""

    instructions: int
    cycles: int | None

    def __or__(self, other: Cost) -> Cost:
        """The larger of each."""
        cycles = None if self.cycles is None or other.cycles is None else max(self.cycles, other.cycles)
        return Cost(max(self.instructions, other.instructions), cycles)


_Key = tuple[int, ...]
"""The order in which arrivals are run: every way leads to a larger one."""


@dataclass(frozen=True, slots=True)
class _Arrival:
    """A block about to be run, in one round of every loop around it; ``callers`` are the blocks whose calls are under
    way, outermost first. ``ways``: the states it is reached in, each with the longest way there."""

    key: _Key
    callers: tuple[_Arrival, ...]
    graph: Graph
    block: Block
    rounds: tuple[int, ...]
    ways: list[tuple[State, Cost]]


class Search:
    """One call.

    ``name_of`` puts an address into words; ``width_of`` tells how many states are told apart at a place;
    ``most_rounds`` is where a loop is given up.
    """

    def __init__(
        self,
        decode: Decode,
        name_of: Callable[[int], str],
        width_of: Callable[[int], int],
        stack_pointer: Expr,
        most_rounds: int,
    ) -> None:
        self._decode = decode
        self._name_of = name_of
        self._width_of = width_of
        self._pointer = stack_pointer
        self._most_rounds = most_rounds
        self._graphs: dict[int, Graph] = {}
        self._waiting: dict[_Key, _Arrival] = {}
        self._order: list[_Key] = []
        self.rounds: dict[int, int] = {}
        """The most rounds that any loop took, by its first block's address; the round that ends it counts."""

    def longest(self, entry: int, end: int, state: State) -> Cost:
        """The longest way from an entry to ``end``. Raises NoBound."""
        try:
            return self._longest(entry, end, state)
        except NotModelled as error:
            raise NoBound(f"not followed: {error}") from error

    def _longest(self, entry: int, end: int, state: State) -> Cost:
        self._enter((), entry, state, Cost(0, 0))
        best: Cost | None = None
        for _ in range(_MOST_BLOCKS):
            if not self._order:
                break
            arrival = self._waiting.pop(heapq.heappop(self._order))
            for start, cost in arrival.ways:
                left = self._through(arrival, start, cost, end)
                if left is not None:
                    best = left if best is None else best | left
        else:
            raise NoBound("its paths are too many")
        if best is None:
            raise NoBound("it does not return")
        return best

    def _graph(self, entry: int) -> Graph:
        graph = self._graphs.get(entry)
        if graph is None:
            graph = self._graphs[entry] = flow_graph(entry, self._decode)
        return graph

    def _through(self, arrival: _Arrival, state: State, cost: Cost, end: int) -> Cost | None:
        """Run a block and go on from it; the cost where that ends the call."""
        block = arrival.block
        cycles = cost.cycles
        for instruction in block.instructions:
            cycles = None if cycles is None or instruction.cycles is None else cycles + instruction.cycles
        cost = Cost(cost.instructions + len(block.instructions), cycles)
        found: list[Cost] = []
        for before in run(block.instructions[:-1], state):
            left = self._onwards(arrival, before, cost, end)
            found += [] if left is None else [left]
        return reduce(or_, found) if found else None

    def _onwards(self, arrival: _Arrival, state: State, cost: Cost, end: int) -> Cost | None:
        """Run the last instruction of a block, and follow where it goes."""
        last = arrival.block.last
        flow, on = last.flow, last.after
        if last.guard is not None and flow is not None:
            passed = None if state.assumed == last.guard else where(CONTRARY[last.guard], None, state.copy())
            if passed is not None:
                self._go(arrival, on, passed, cost)
            if state.assumed == CONTRARY[last.guard]:
                return None
            taken = where(last.guard, None, state)
            if taken is None:
                return None
            state = taken
            for effect in last.effects:
                apply(effect, state)
        else:
            (state,) = run([last], state)
        state.assumed = None
        match flow:
            case None:
                self._go(arrival, on, state, cost)
            case Jump(target):
                self._go(arrival, target, state, cost)
            case Branch(condition, target):
                passed = where(CONTRARY[condition], flow, state.copy())
                if passed is not None:
                    self._go(arrival, on, passed, cost)
                taken = where(condition, flow, state)
                if taken is not None:
                    more = None if cost.cycles is None else cost.cycles + last.taken
                    self._go(arrival, target, taken, Cost(cost.instructions, more))
            case Call(target):
                pointer = evaluate(self._pointer, state, 32)
                if pointer.step:
                    raise NoBound(f"the stack pointer at {self._name_of(last.address)} is not known")
                state.frames = (*state.frames, Frame(pointer.lo, state.written))
                state.written = 0
                self._enter((*arrival.callers, arrival), target, state, cost)
            case Leave(target):
                return self._leave(arrival, evaluate(target, state, 32), state, cost, end)
        return None

    def _leave(self, arrival: _Arrival, to: Value, state: State, cost: Cost, end: int) -> Cost | None:
        """A return: to the caller, or the end of the call."""
        back = arrival.callers[-1].block.last.after if arrival.callers else end
        if to.step != 0 or to.lo & ~1 != back:
            raise NoBound(f"where {self._name_of(arrival.block.last.address)} goes is not known")
        if not arrival.callers:
            return cost
        state.written |= state.frames[-1].written
        state.frames = state.frames[:-1]
        self._go(arrival.callers[-1], back, state, cost)
        return None

    def _enter(self, callers: tuple[_Arrival, ...], entry: int, state: State, cost: Cost) -> None:
        if len(callers) > _MOST_CALLS:
            raise NoBound("its calls nest too deep")
        graph = self._graph(entry)
        self._arrive(callers, graph, entry, (0,) * len(graph.places[entry].loops), state, cost)

    def _go(self, at: _Arrival, target: int, state: State, cost: Cost) -> None:
        """On to another block of the same function: into the next round where that leads a loop we are in."""
        here, there = at.graph.places[at.block.start], at.graph.places[target]
        common = 0
        for mine, other in zip(here.loops, there.loops, strict=False):
            if mine != other:
                break
            common += 1
        rounds = at.rounds[:common] + (0,) * (len(there.loops) - common)
        ahead = here.heads and here.loops == there.loops and here.indices < there.indices
        if there.heads and common == len(there.loops) and not ahead:
            rounds = (*rounds[:-1], rounds[-1] + 1)
        self._arrive(at.callers, at.graph, target, rounds, state, cost)

    def _arrive(
        self,
        callers: tuple[_Arrival, ...],
        graph: Graph,
        start: int,
        rounds: tuple[int, ...],
        state: State,
        cost: Cost,
    ) -> None:
        """Note a way to a block; ways beyond the number told apart are joined, the most alike first."""
        place = graph.places[start]
        key = callers[-1].key if callers else ()
        for index, count in zip(place.indices, rounds, strict=False):
            key = (*key, index, count)
        key = (*key, place.indices[-1])
        arrival = self._waiting.get(key)
        if arrival is None:
            if place.heads:
                self._count_round(start, rounds[-1])
            self._waiting[key] = arrival = _Arrival(key, callers, graph, graph.blocks[start], rounds, [])
            heapq.heappush(self._order, key)
        ways = arrival.ways
        ways.append((state, cost))
        if len(ways) > self._width_of(start):
            pairs = [(loss(ways[i][0], ways[j][0]), i, j) for j in range(1, len(ways)) for i in range(j)]
            _, i, j = min(pairs) if len(pairs) > 1 else pairs[0]
            (one, first), (other, second) = ways[i], ways.pop(j)
            ways[i] = (joined(one, other), first | second)

    def _count_round(self, start: int, count: int) -> None:
        self.rounds[start] = max(self.rounds.get(start, 0), count + 1)
        if count > self._most_rounds:
            raise NoBound(f"the loop at {self._name_of(start)} has no bound that could be derived")
