"""FZ9xx: what went wrong on our side."""

from __future__ import annotations

from textwrap import dedent

from fuzzyspec.diagnostics.code import Code

CODES: tuple[Code, ...] = (
    Code(
        "FZ901",
        "a bug in fuzzyc",
        "error",
        dedent(
            """
            The compiler met something that it should have told you about earlier, or not at all. No spec, right
            or wrong, should lead here: please report it with the spec. Nothing was written.
            """
        ).strip()
        + "\n",
    ),
)
