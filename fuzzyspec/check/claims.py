"""Claims: what tables and behaviors say about the antecedent space, before priorities.

Every rule over cells claims a box, the product of one set of terms for each input.
"""

from __future__ import annotations

from dataclasses import dataclass

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.model.controller import Input

Box = tuple[tuple[int, ...], ...]
"""For each input of the controller, in order, the indices of the terms that belong: sorted, never empty."""


@dataclass(frozen=True, slots=True)
class Claim:
    """One rule over cells.

    ``owner`` is the index of the behavior among the controller's behavior blocks, None for a table's entry; ``table``
    the index of the table, None for a behavior's rule. ``sets`` are (output, term) indices.
    """

    owner: int | None
    table: int | None
    box: Box
    sets: tuple[tuple[int, int], ...]
    span: Span


def whole(inputs: tuple[Input, ...]) -> list[tuple[int, ...]]:
    """The box of every cell, as a list to narrow."""
    return [tuple(range(len(v.terms))) for v in inputs]


def describe_box(box: Box, inputs: tuple[Input, ...]) -> str:
    """A box as a condition: ``target is C and left in {M, B}``; inputs that do not narrow it are left out."""
    parts = []
    for terms, variable in zip(box, inputs, strict=True):
        if len(terms) == len(variable.terms) and len(terms) > 1:
            continue
        names = [variable.terms[t].name for t in terms]
        parts.append(
            f"{variable.name} is {names[0]}" if len(names) == 1 else f"{variable.name} in {{{', '.join(names)}}}"
        )
    return " and ".join(parts) or "every cell"


def describe_cell(cell: tuple[int, ...], inputs: tuple[Input, ...]) -> str:
    """One cell, every input named: ``left is S and front is M and target is C``."""
    return " and ".join(f"{v.name} is {v.terms[t].name}" for t, v in zip(cell, inputs, strict=True))
