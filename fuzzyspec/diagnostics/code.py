"""What the registry keeps about one diagnostic code."""

from __future__ import annotations

from dataclasses import dataclass
from textwrap import dedent

from fuzzyspec.diagnostics.diagnostic import Severity


@dataclass(frozen=True, slots=True)
class Code:
    """One kind of finding.

    ``title`` is a short phrase, ``page`` what ``fuzzyc explain CODE`` prints: what it means, an example that
    triggers it and how to mend it.
    """

    code: str
    title: str
    severity: Severity
    page: str


def explained(code: str, title: str, page: str, severity: Severity = "error") -> Code:
    """A code with its page as it stands indented in the source."""
    return Code(code, title, severity, dedent(page).strip() + "\n")
