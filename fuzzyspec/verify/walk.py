"""Every node of a tree of frozen dataclasses, whatever its kinds."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

from fuzzyspec.model.controller import Controller


def nodes(root: object) -> Iterator[object]:
    """``root`` and what it holds, depth first; controllers are not entered."""
    if isinstance(root, Controller):
        return
    if isinstance(root, tuple):
        for item in root:
            yield from nodes(item)
    elif dataclasses.is_dataclass(root) and not isinstance(root, type):
        yield root
        for field in dataclasses.fields(root):
            yield from nodes(getattr(root, field.name))
