"""Budgets of random specs."""

from __future__ import annotations

import random

MEMORY = ("flash", "ram", "stack")
TOLD_ON = {
    "flash": ("cortex-m0plus", "cortex-m4", "cortex-m7", "rv32imc", "avr"),
    "ram": ("cortex-m4", "avr"),
    "stack": ("cortex-m0plus", "rv32imc", "avr"),
    "instructions": ("cortex-m0plus", "cortex-m4", "cortex-m7", "rv32imc"),
    "cycles": ("cortex-m0plus", "avr"),
}


def with_budget(text: str, dice: random.Random) -> str:
    """A declaration with a budget as its last item, now and then."""
    if dice.random() < 0.7:
        return text
    limits = {}
    for _ in range(dice.randint(1, 4)):
        quantity = dice.choice(list(TOLD_ON))
        on = dice.choice(("", *(f" on {target}" for target in TOLD_ON[quantity])))
        limits[quantity + on] = f"{quantity} <= {_limit(quantity, dice)}{on}"
    comma = dice.choice(("", ","))
    return f"{text.removesuffix('}')}  budget {{ {', '.join(limits.values())}{comma} }}\n}}"


def _limit(quantity: str, dice: random.Random) -> str:
    if quantity not in MEMORY:
        return dice.choice(("900", "25000", "2 * 400 + 1", "1000 * third"))
    return dice.choice(("1 KiB", "1.5 kB", "48 B", "2 * 16 B", "third * 3 KiB"))
