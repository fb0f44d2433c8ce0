"""The longest path of small functions whose cost is known, and of those that have none."""

from __future__ import annotations

import pytest

from fuzzyspec.cost.worst.avr import decode_avr, words
from fuzzyspec.cost.worst.code import Instruction, Pair, Reg
from fuzzyspec.cost.worst.flowgraph import flow_graph
from fuzzyspec.cost.worst.longest import Cost, NoBound, Search
from fuzzyspec.cost.worst.riscv import decode_riscv
from fuzzyspec.cost.worst.state import NO_FLAGS, Frame, State
from fuzzyspec.cost.worst.values import anything, constant

END = 0x8000
RET = 0x8067
A0, A1, A2 = 10, 11, 12


def addi(rd: int, rs: int, value: int) -> int:
    """``addi rd, rs, value``."""
    return (value & 0xFFF) << 20 | rs << 15 | rd << 7 | 0x13


def branch(f3: int, rs1: int, rs2: int, offset: int) -> int:
    """A conditional branch; f3 is 0 for equal, 1 for unequal, 6 for below."""
    bits = (offset >> 12 & 1) << 31 | (offset >> 5 & 63) << 25 | (offset >> 1 & 15) << 8 | (offset >> 11 & 1) << 7
    return bits | rs2 << 20 | rs1 << 15 | f3 << 12 | 0x63


def jal(rd: int, offset: int) -> int:
    """``jal rd, offset``."""
    bits = (offset >> 20 & 1) << 31 | (offset >> 1 & 1023) << 21 | (offset >> 11 & 1) << 20 | (offset >> 12 & 255) << 12
    return bits | rd << 7 | 0x6F


def search(code: list[int], most: int = 100) -> tuple[Search, State]:
    """A search over RV32 words from address 0, and the state at a call: arguments unknown, x1 the way back."""
    raw = b"".join(word.to_bytes(4, "little") for word in code)

    def decode(at: int) -> Instruction:
        return decode_riscv(raw[at : at + 4], at, raw[max(0, at - 4) : at])

    registers = [anything(32)] * 32
    registers[0], registers[1], registers[2] = constant(0, 32), constant(END, 32), constant(0x9000, 32)
    state = State(32, registers, {}, NO_FLAGS, lambda *_: None, (Frame(0x9000, 0),))
    return Search(decode, hex, lambda _: 1, Reg(2), most), state


def longest(code: list[int]) -> int:
    """Instructions of the longest path."""
    found, state = search(code)
    return found.longest(0, END, state).instructions


def test_straight_code_takes_its_length() -> None:
    """Two instructions and the return."""
    assert longest([addi(A0, A0, 1), addi(A0, A0, 1), RET]) == 3


def test_of_a_diamond_the_longer_side_counts() -> None:
    """Branch, one instruction and a jump on one side, three on the other."""
    code = [branch(0, A0, 0, 12), addi(A1, A1, 1), jal(0, 16), addi(A1, A1, 1), addi(A1, A1, 1), addi(A1, A1, 1), RET]
    assert longest(code) == 1 + 3 + 1


def test_a_side_that_cannot_be_taken_does_not_count() -> None:
    """The same diamond, where the branch is settled by what was set before it."""
    code = [addi(A0, 0, 5), branch(0, A0, 0, 12), addi(A1, A1, 1), jal(0, 16)]
    code += [addi(A1, A1, 1), addi(A1, A1, 1), addi(A1, A1, 1), RET]
    assert longest(code) == 2 + 2 + 1


def test_a_loop_takes_as_many_rounds_as_its_counter_says() -> None:
    """Ten rounds of two instructions, and what is around them."""
    code = [addi(A0, 0, 10), addi(A0, A0, -1), branch(1, A0, 0, -4), RET]
    assert longest(code) == 1 + 10 * 2 + 1


def test_a_loop_inside_a_loop_takes_the_product() -> None:
    """Three rounds of four rounds of two, each of the three with three more."""
    code = [addi(A0, 0, 3), addi(A1, 0, 4), addi(A1, A1, -1), branch(1, A1, 0, -4), addi(A0, A0, -1)]
    code += [branch(1, A0, 0, -16), RET]
    assert longest(code) == 1 + 3 * (1 + 4 * 2 + 2) + 1


def test_a_count_that_is_clamped_bounds_its_loop() -> None:
    """An argument of any size, no more than 16 of which is used, as with a list."""
    code = [addi(A1, 0, 16), branch(6, A0, A1, 8), addi(A0, 0, 16), addi(A2, 0, 0)]
    code += [branch(0, A2, A0, 12), addi(A2, A2, 1), jal(0, -8), RET]
    assert longest(code) == 4 + 16 * 3 + 1 + 1


def test_a_call_counts_every_time_with_its_arguments() -> None:
    """A callee that loops as often as it is told: twice and five times."""
    callee = 6 * 4
    code = [addi(8, 1, 0), addi(A0, 0, 2), jal(1, callee - 8), addi(A0, 0, 5), jal(1, callee - 16), 0x00040067]
    code += [addi(A0, A0, -1), branch(1, A0, 0, -4), RET]
    assert longest(code) == 6 + (2 * 2 + 1) + (5 * 2 + 1)


@pytest.mark.parametrize(
    ("code", "why"),
    [
        ([addi(A0, A0, -1), branch(1, A0, 0, -4), RET], "has no bound that could be derived"),
        ([jal(0, 0)], "has no bound"),
        ([addi(1, A0, 0), RET], "is not known"),
        ([0x00050067], "is not known"),
        ([0xFFFFFFFF], "not followed"),
    ],
    ids=["unknown count", "no end", "lost way back", "computed jump", "no instruction"],
)
def test_what_cannot_be_bounded_gives_a_reason_and_no_number(code: list[int], why: str) -> None:
    """A count that is an argument, a loop without end, ways that are computed, bytes that are no code."""
    found, state = search(code)
    with pytest.raises(NoBound, match=why):
        found.longest(0, END, state)


def test_places_grow_along_every_edge_but_a_loops_next_round() -> None:
    """The order in which blocks are run, on the loop inside a loop."""
    code = [addi(A0, 0, 3), addi(A1, 0, 4), addi(A1, A1, -1), branch(1, A1, 0, -4), addi(A0, A0, -1)]
    code += [branch(1, A0, 0, -16), RET]
    raw = b"".join(word.to_bytes(4, "little") for word in code)
    graph = flow_graph(0, lambda at: decode_riscv(raw[at : at + 4], at))
    backwards = [(a, b) for a, block in graph.blocks.items() for b in block.following if not_after(graph, a, b)]
    assert sorted(backwards) == [(8, 8), (16, 4)]
    assert [len(graph.places[a].loops) for a in (0, 4, 8, 16, 24)] == [0, 1, 2, 1, 0]


def not_after(graph: object, a: int, b: int) -> bool:
    """Whether the place of b is not above that of a."""
    places = graph.places  # type: ignore[attr-defined]
    return bool(places[b].indices <= places[a].indices)


def test_cycles_of_avr_count_taken_branches_and_skips() -> None:
    """``ldi r24, 3; dec r24; brne .-4; sbrc r24, 0; nop; ret``: the branch takes 2, at last 1, the skip 2."""
    code = b"".join(w.to_bytes(2, "little") for w in (0xE083, 0x958A, 0xF7F1, 0xFD80, 0x0000, 0x9508))

    def decode(at: int) -> Instruction:
        return decode_avr(code[at : at + 4], at, lambda a: words(int.from_bytes(code[a : a + 2], "little")))

    registers = [anything(8)] * 34
    registers[32], registers[33] = constant(0xF0, 8), constant(0x08, 8)
    state = State(8, registers, {}, NO_FLAGS, lambda *_: None, (Frame(0x8F0, 0),))
    state.store(constant(0x8F2, 16), 1, constant(END // 2, 8), True)
    state.store(constant(0x8F1, 16), 1, constant(END // 2 >> 8, 8), True)
    found = Search(decode, hex, lambda _: 1, Pair(32), 100)
    assert found.longest(0, END, state) == Cost(1 + 3 * 2 + 2, 1 + 3 + (2 + 2 + 1) + 2 + 4)
