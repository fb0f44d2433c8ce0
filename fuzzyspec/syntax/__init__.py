"""Text to syntax tree, with every syntax problem of a file found in one run."""

from fuzzyspec.syntax.parser import parse
from fuzzyspec.syntax.source import source_from_bytes

__all__ = ["parse", "source_from_bytes"]
