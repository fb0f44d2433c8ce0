"""Did you mean: the known name that a misspelt one is nearest to."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from itertools import islice

_MOST = 300
"""Known names that are looked at; a file with more has other worries than a slow search."""


def nearest(name: str, known: Iterable[str]) -> str | None:
    """The known name most like ``name``, or None where none is much like it. Case alone never keeps them apart."""
    candidates = list(islice(known, _MOST))
    for candidate in candidates:
        if candidate.lower() == name.lower():
            return candidate
    found = difflib.get_close_matches(name.lower(), [c.lower() for c in candidates], n=1, cutoff=0.6)
    return next((c for c in candidates if found and c.lower() == found[0]), None)


def did_you_mean(name: str, known: Iterable[str]) -> str | None:
    """A line of help, or None where no known name is near."""
    candidate = nearest(name, known)
    return None if candidate is None else f"did you mean `{candidate}`?"


def listing(names: Iterable[str], most: int = 12) -> str:
    """``a, b and c`` in the given order, cut short after ``most``."""
    shown = [f"`{n}`" for n in names]
    if len(shown) > most:
        return ", ".join(shown[:most]) + f" and {len(shown) - most} more"
    return " and ".join(part for part in (", ".join(shown[:-1]), *shown[-1:]) if part)


def hint(name: str, known: Iterable[str], kind: str) -> str:
    """The help of an unknown name: its likeliest meaning, else what there is to choose from."""
    names = list(dict.fromkeys(islice(known, _MOST)))
    guess = did_you_mean(name, names)
    if guess is not None:
        return guess
    return f"{kind} known here: {listing(names)}" if names else f"no {kind} are known here"
