"""What a program will cost, without a compiler: what it does is counted and weighed, target by target."""

from fuzzyspec.estimate.model import Estimate, band, estimate

__all__ = ["Estimate", "band", "estimate"]
