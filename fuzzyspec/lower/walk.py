"""What an expression of a system needs before it can be computed, and which folds it holds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass

from fuzzyspec.model.system import CallOutput, Fold, ReadLet, SystemOutput


def nodes(root: object) -> Iterator[object]:
    """Every node of an expression, a test or a statement, the root first."""
    yield root
    if isinstance(root, tuple):
        for part in root:
            yield from nodes(part)
    elif is_dataclass(root):
        for f in fields(root):
            value = getattr(root, f.name)
            if isinstance(value, tuple) or (is_dataclass(value) and type(value).__module__ == Fold.__module__):
                yield from nodes(value)


def folds(root: object) -> list[Fold]:
    """The folds in an expression or statement, inner ones included."""
    roots = (root.value,) if isinstance(root, SystemOutput) else (root,)
    return [n for r in roots for n in nodes(r) if isinstance(n, Fold)]


def needs(root: object, of_elements: set[str]) -> set[tuple[str, str]]:
    """Scalar lets and calls that an expression refers to; ``of_elements`` are the ids of calls made once an element."""
    found: set[tuple[str, str]] = set()
    for n in nodes(root):
        if isinstance(n, ReadLet) and n.list is None:
            found.add(("let", n.name))
        elif isinstance(n, CallOutput) and n.call not in of_elements:
            found.add(("call", n.call))
    return found


def needs_of_element(root: object, of_elements: set[str]) -> set[tuple[str, str]]:
    """Lets and calls of the current element that an expression refers to."""
    found: set[tuple[str, str]] = set()
    for n in nodes(root):
        if isinstance(n, ReadLet) and n.list is not None:
            found.add(("let", n.name))
        elif isinstance(n, CallOutput) and n.call in of_elements:
            found.add(("call", n.call))
    return found
