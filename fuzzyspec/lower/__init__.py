"""A checked model becomes an integer program with its certificates."""

from fuzzyspec.lower.module import Lowered, LoweringError, Options, lower

__all__ = ["Lowered", "LoweringError", "Options", "lower"]
