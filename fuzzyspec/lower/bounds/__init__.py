"""Certified bounds of a controller: lemmas composed over boxes of its inputs (docs/numbers.md)."""

from fuzzyspec.lower.bounds.search import Effort, bound_controller, means

__all__ = ["Effort", "bound_controller", "means"]
