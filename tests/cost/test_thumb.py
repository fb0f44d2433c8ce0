"""Cycles of a Cortex-M0+ by instruction, against its manual's table."""

from __future__ import annotations

import pytest

from fuzzyspec.cost.thumb import decode_thumb

TABLE = {
    "movs r0, #1": ("0120", 1),
    "lsls r1, r0, #3": ("c100", 1),
    "muls r0, r1": ("4843", 1),
    "mov r8, r0": ("8046", 1),
    "mov pc, r0": ("8746", 2),
    "cmp r8, pc": ("f845", 1),
    "bx lr": ("7047", 2),
    "blx r3": ("9847", 2),
    "ldr r0, [pc, #4]": ("0148", 2),
    "ldrh r0, [r1, r2]": ("885a", 2),
    "strh r0, [r1, #2]": ("4880", 2),
    "ldr r0, [sp, #8]": ("0298", 2),
    "add r0, sp, #8": ("02a8", 1),
    "sub sp, #16": ("84b0", 1),
    "uxth r0, r0": ("80b2", 1),
    "rev r0, r0": ("00ba", 1),
    "push {r4, r5}": ("30b4", 3),
    "push {r4, r5, lr}": ("30b5", 4),
    "pop {r4, r5}": ("30bc", 3),
    "pop {r4, r5, pc}": ("30bd", 5),
    "stmia r0!, {r1, r2}": ("06c0", 3),
    "ldmia r0!, {r1, r2, r3}": ("0ec8", 4),
    "b .": ("fee7", 2),
    "bl .": ("fff7feff", 3),
    "nop": ("00bf", 1),
}


@pytest.mark.parametrize("name", TABLE)
def test_every_kind_of_instruction_takes_what_the_manual_says(name: str) -> None:
    """One instruction, its cycles, and no conditional branch."""
    code, cycles = TABLE[name]
    block = decode_thumb(bytes.fromhex(code))
    assert (block.instructions, block.cycles, block.conditional) == (1, cycles, False)


def test_a_conditional_branch_ends_a_block_that_is_open() -> None:
    """Counted as not taken; whoever sees where it went adds the cycle."""
    block = decode_thumb(bytes.fromhex("0128fed0"))
    assert (block.instructions, block.cycles, block.conditional) == (2, 2, True)


def test_what_the_manual_does_not_list_has_no_cycles() -> None:
    """udiv is one instruction, but not of this core; IT is none of its either."""
    for code in ("b0fbf1f0", "08bf"):
        block = decode_thumb(bytes.fromhex(code))
        assert (block.instructions, block.cycles) == (1, None)
