"""The integer program, its constructors and its numpy meaning."""

from fuzzyspec.fixed.program import Program
from fuzzyspec.fixed.run import Run, run

__all__ = ["Program", "Run", "run"]
