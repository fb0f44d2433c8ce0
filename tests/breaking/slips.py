"""Slips that users make, each an edit of a sound spec: what is replaced, by what, and what must be told of where."""

from __future__ import annotations

from tests.breaking.slip import Slip
from tests.breaking.slips_budgets import BUDGET, SLIPS_IN_BUDGET
from tests.breaking.slips_rules import BEH, RULES, SLIPS_IN_BEH, SLIPS_IN_RULES
from tests.breaking.slips_systems import SLIPS_IN_SYS, SYS
from tests.breaking.slips_tables import FAN, SLIPS_IN_FAN

SLIPS: dict[str, tuple[Slip, ...]] = {
    FAN: SLIPS_IN_FAN,
    RULES: SLIPS_IN_RULES,
    BEH: SLIPS_IN_BEH,
    SYS: SLIPS_IN_SYS,
    BUDGET: SLIPS_IN_BUDGET,
}
