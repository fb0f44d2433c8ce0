"""Text to syntax tree, with every syntax problem of a file found in one run."""

from fuzzyspec.syntax.parser import parse

__all__ = ["parse"]
