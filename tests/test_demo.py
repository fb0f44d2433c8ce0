"""The demo's five lines say what was found, and no bound is flattered."""

import re
from decimal import Decimal

from hypothesis import given
from hypothesis import strategies as st

from scripts.demo import story, summary, up

VERIFIED = {
    "cases": 1234567,
    "functions": [
        {"kind": "controller", "mismatches": 0, "status_mismatches": 0, "state_mismatches": 0, "outputs": []},
        {
            "kind": "system",
            "mismatches": 1,
            "status_mismatches": 2,
            "state_mismatches": 3,
            "outputs": [
                {"output": "v", "largest_error": 0.001, "bound_percent": 0.2901},
                {"output": "w", "largest_error": 0.001, "bound_percent": None},
                {"output": "acting", "largest_error": None, "bound_percent": None},
            ],
        },
    ],
}
DRIVEN = {
    "runs": [
        {
            "controller": "c",
            "robots": [{"name": "R1", "arrived": 50.18, "episodes": [{"behavior": "MG", "start": 0.0, "end": 50.18}]}],
            "clearance": {"distance": 0.345, "time": 23.3},
        }
    ]
}


@given(st.floats(1e-12, 1e6))
def test_bounds_are_rounded_up(percent: float) -> None:
    """A printed bound is no smaller than the certified one, and larger by a tenth of it at most."""
    printed = up(percent)
    assert re.fullmatch(r"[\d.E+-]+ %", printed)
    assert Decimal(percent) <= Decimal(printed.removesuffix(" %")) <= Decimal(percent) * Decimal("1.1")


def test_summary_takes_every_kind_of_mismatch() -> None:
    """Four lines (the fifth names the files); outputs, status and state all count as mismatches."""
    assert summary(VERIFIED, DRIVEN) == [
        "certified errors  v 0.30 %, w none (of range)",
        "cases compared    1,234,567: C and integer model bit for bit, 6 mismatches",
        "arrivals          R1 after 50.2 s",
        "clearance         0.34 m at 23.3 s",
    ]
    assert story(DRIVEN) == ["R1: MG 0 to 50 s"]
