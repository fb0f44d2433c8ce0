"""Certified bounds of a controller: lemmas composed over boxes of its inputs (docs/numbers.md)."""

from fuzzyspec.lower.bounds.carried import bound_controller
from fuzzyspec.lower.bounds.search import ControllerBounds, Effort, means

__all__ = ["ControllerBounds", "Effort", "bound_controller", "means"]
