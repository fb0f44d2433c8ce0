"""Did you mean: the known name that a misspelt one is nearest to."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def nearest(name: str, known: Iterable[str]) -> str | None:
    """The known name most like ``name``, or None where none is much like it. Case alone never keeps them apart."""
    candidates = list(known)
    for candidate in candidates:
        if candidate.lower() == name.lower():
            return candidate
    found = difflib.get_close_matches(name.lower(), [c.lower() for c in candidates], n=1, cutoff=0.6)
    return next((c for c in candidates if found and c.lower() == found[0]), None)


def did_you_mean(name: str, known: Iterable[str]) -> str | None:
    """A line of help, or None where no known name is near."""
    candidate = nearest(name, known)
    return None if candidate is None else f"did you mean `{candidate}`?"
