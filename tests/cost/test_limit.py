"""The counted limit, against counting by hand."""

from __future__ import annotations

from fuzzyspec import load
from fuzzyspec.cost.limit import limit
from fuzzyspec.model.controller import Controller
from tests.cost.cost_specs import KEEPING, PLAIN


def controller(text: str, name: str) -> Controller:
    """One of a spec's controllers."""
    found = load(text).functions[name]
    assert isinstance(found, Controller)
    return found


def test_the_limit_of_two_inputs_of_two_terms_is_counted_by_hand() -> None:
    """On a Cortex-M4: x can pass its range at one end, y at both; neither has pieces to choose among.

    Inputs 1 + 2 + 2 + 1 and 1 + 4 + 2 + 1; two smaller degrees 2 (2 + 1), one test to order them, one jump; two levels
    of 3 + 2, and 3 + 1 + 2 + 1 for the quotient and the raw; 3 for the call.
    """
    assert limit(controller(PLAIN, "fan"), "cortex-m4") == 6 + 8 + 6 + 2 + 1 + 10 + 7 + 3


def test_sentence_rules_count_their_literals_and_consequents() -> None:
    """One input of two pieces' terms, two rules of a literal each, the mean of two singletons."""
    found = {target: limit(controller(KEEPING, "hold"), target) for target in ("cortex-m0plus", "cortex-m4", "avr")}
    assert found["cortex-m4"] == (1 + 4 + 2 + 1) + 2 * 2 + 10 + 7 + 3
    assert found["cortex-m4"] < found["cortex-m0plus"] < found["avr"]
