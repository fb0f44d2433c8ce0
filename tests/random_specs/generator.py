"""Random valid specs over the whole language. The same seed gives the same spec on every machine."""

from __future__ import annotations

import random

from tests.random_specs.spec_budgets import with_budget
from tests.random_specs.spec_controllers import Controllers
from tests.random_specs.spec_numbers import DECLARED
from tests.random_specs.spec_systems import Systems


def spec(seed: int) -> str:
    """The spec of a seed."""
    dice = random.Random(seed)
    controllers = Controllers(dice)
    made = [controllers.controller(f"stage{i}") for i in range(dice.choice((1, 1, 2, 3)))]
    # Dice of their own, so that what else a seed gives does not hang on them.
    limits = random.Random(f"budgets of {seed}")
    parts = [f"module spec{seed}", DECLARED, *(with_budget(c.text, limits) for c in made)]
    systems = dice.choice((0, 1, 1, 1, 2)) if len(made) == 1 else dice.choice((1, 1, 2))
    for name in ("chain", "other")[:systems]:
        called = [c for c in made if dice.random() < 0.9]
        parts.append(with_budget(Systems(dice).system(name, called), limits))
    return "\n".join(parts) + "\n"
