"""What the registry keeps about one diagnostic code."""

from __future__ import annotations

from dataclasses import dataclass

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
