"""The derived worst case: the longest path over the built code, found by running it over sets of values."""

from __future__ import annotations

from fuzzyspec.cost.worst.bound import Bound, derive

__all__ = ["Bound", "derive"]
