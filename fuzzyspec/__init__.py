"""A compiler from fuzzy-controller specs to fixed-point C with a certified error.

``load``, ``diagnose`` and the rest of ``fuzzyspec.api`` are at hand here; nothing heavy is imported before one is used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fuzzyspec.version import __version__

if TYPE_CHECKING:
    from fuzzyspec.api import Diagnostic, Evaluation, Source, Spec, SpecError, diagnose, load, read

__all__ = ["Diagnostic", "Evaluation", "Source", "Spec", "SpecError", "__version__", "diagnose", "load", "read"]


def __getattr__(name: str) -> Any:
    """Fetch a name of the library at its first use."""
    if name in __all__:
        from fuzzyspec import api

        return getattr(api, name)
    raise AttributeError(f"module 'fuzzyspec' has no attribute {name!r}")
