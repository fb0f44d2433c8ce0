"""Names, units, ranges and rules: from the syntax tree to the checked model, or to what is wrong with it."""

from fuzzyspec.check.module import check

__all__ = ["check"]
