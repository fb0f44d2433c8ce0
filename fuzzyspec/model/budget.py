"""What a call may cost: the limits that a spec sets, and what can be told of each machine at all."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, get_args

from fuzzyspec.diagnostics.diagnostic import Span

Quantity = Literal["flash", "ram", "stack", "instructions", "cycles"]
QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)
Machine = Literal["cortex-m0plus", "cortex-m4", "cortex-m7", "rv32imc", "avr"]
MACHINES: tuple[Machine, ...] = get_args(Machine)

MEMORY: frozenset[Quantity] = frozenset({"flash", "ram", "stack"})
"""Quantities in bytes; the others are plain counts."""

TOLD_ON: Mapping[Quantity, tuple[Machine, ...]] = MappingProxyType(
    {
        "flash": MACHINES,
        "ram": MACHINES,
        "stack": MACHINES,
        "instructions": ("cortex-m0plus", "cortex-m4", "cortex-m7", "rv32imc"),
        "cycles": ("cortex-m0plus", "avr"),
    }
)
"""Where each can be told without guessing. Cycles of the larger Cortex-M depend on flash wait states and on what the
core runs side by side, those of RV32IMC on the core; on AVR cycles are counted, instructions are not."""


@dataclass(frozen=True, slots=True)
class Budget:
    """One call needs at most ``limit`` of ``quantity`` (bytes, or a count), on ``target`` or, where that is None, on
    every machine on which the quantity can be told."""

    quantity: Quantity
    limit: int
    target: Machine | None
    span: Span

    @property
    def machines(self) -> tuple[Machine, ...]:
        """Where it holds."""
        return TOLD_ON[self.quantity] if self.target is None else (self.target,)


def amount(quantity: Quantity, value: int) -> str:
    """A value with its unit: ``1,536 B``, ``900``."""
    return f"{value:,} B" if quantity in MEMORY else f"{value:,}"


def words(budget: Budget) -> str:
    """A limit as a spec would have it: ``flash <= 1 KiB on avr``."""
    where = "" if budget.target is None else f" on {budget.target}"
    kib = budget.limit // 1024 if budget.quantity in MEMORY and budget.limit % 1024 == 0 else 0
    return f"{budget.quantity} <= {f'{kib:,} KiB' if kib else amount(budget.quantity, budget.limit)}{where}"
