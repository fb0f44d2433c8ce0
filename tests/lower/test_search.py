"""The search for a bound ends."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzzyspec import load
from fuzzyspec.lower.bounds import search
from fuzzyspec.lower.bounds.strengths import Boxes

REGRESSIONS = Path(__file__).resolve().parents[1] / "regressions"


def test_a_jump_does_not_keep_the_search_going(monkeypatch: pytest.MonkeyPatch) -> None:
    """At a jump the bound falls with no splitting: boxes that no degree moves over are left alone."""
    rounds = 0
    split = search.Search._split

    def counted(self: search.Search, *arguments: object) -> Boxes:
        nonlocal rounds
        rounds += 1
        return split(self, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(search.Search, "_split", counted)
    assert load(REGRESSIONS / "bound_at_a_jump.fz").lowered.certificates
    assert 0 < rounds < 200
