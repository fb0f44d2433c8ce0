"""From the integer program to files: an in-memory plan, written at the edge."""

from fuzzyspec.emit.files import emit
from fuzzyspec.emit.plan import Plan, stale, write

__all__ = ["Plan", "emit", "stale", "write"]
