"""What stops a run although no spec is at fault: wrong usage, a missing file, a missing tool.

Everything here ends the command with one line on standard error and exit status 2.
"""

from __future__ import annotations


class Refusal(Exception):
    """The request cannot be carried out; ``way_out`` says what the user can do about it."""

    def __init__(self, message: str, way_out: str | None = None) -> None:
        self.message = message
        self.way_out = way_out
        super().__init__(message if way_out is None else f"{message}; {way_out}")


class MissingTool(Refusal):
    """A tool outside of this package is needed and was not found; ``way_out`` says how to get it."""
