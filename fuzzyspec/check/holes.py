"""Cells without an answer: claimed by nobody, or claimed with an output left unset."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from fuzzyspec.check.cells import Cells
from fuzzyspec.check.claims import Box, Claim, describe_box
from fuzzyspec.check.degrees import core
from fuzzyspec.check.quantities import quantity
from fuzzyspec.check.rule_names import RuleNames
from fuzzyspec.check.tables import Missing
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Span
from fuzzyspec.model.controller import Input

Bools = NDArray[np.bool_]

SHOWN = 4
"""Blocks of cells that one report lists before it says how many more there are."""


def report_holes(
    cells: Cells,
    claims: tuple[Claim, ...],
    missing: tuple[Missing, ...],
    by_sentence: frozenset[int],
    behaviors: bool,
    names: RuleNames,
    span: Span,
) -> None:
    """Report every cell in which an output without ``otherwise`` is left unset.

    ``by_sentence`` holds the outputs that sentence rules set too: there a hole in the cells is no hole in the output.
    An output that no cell sets at all is left to others.
    """
    needed = [
        o
        for o, output in enumerate(names.outputs)
        if output.fallback is None and o not in by_sentence and (cells.consequents[o] != -1).any()
    ]
    explained = set() if behaviors else _report_missing_rows(needed, cells, claims, missing, names)
    open_outputs = [o for o in needed if o not in explained]
    nobody = ~cells.claimed.reshape(cells.rules.shape)
    if open_outputs and nobody.any():
        _report_unclaimed(nobody, open_outputs, names, span)
    for output in open_outputs:
        unset = (cells.claimed & (cells.consequents[output] == -1)).reshape(cells.rules.shape)
        if unset.any():
            _report_unset(unset, output, cells, claims, names, span)


def _report_unclaimed(nobody: Bools, outputs: list[int], names: RuleNames, span: Span) -> None:
    quoted = ", ".join(f"`{names.outputs[o].name}`" for o in outputs)
    blocks, more = _some_blocks(nobody)
    count = int(nobody.sum())
    names.error(
        Diagnostic(
            "FZ301",
            f"{count} of {_cells(nobody.size)} {'is' if count == 1 else 'are'} claimed by no rule",
            span,
            label=f"{quoted} {'is' if len(outputs) == 1 else 'are'} undefined there",
            help=f"add a rule such as `if {describe_box(blocks[0], names.inputs)} then ..`, "
            f"or give {quoted} an `otherwise`",
            notes=_block_notes(blocks, more, names.inputs),
            point=peak_point(blocks[0], names.inputs),
        )
    )


def _report_unset(
    unset: Bools, output: int, cells: Cells, claims: tuple[Claim, ...], names: RuleNames, span: Span
) -> None:
    name = names.outputs[output].name
    blocks, more = _some_blocks(unset)
    setters = _setters(blocks[0], cells, claims)
    names.error(
        Diagnostic(
            "FZ302",
            f"output `{name}` is left unset in {_cells(int(unset.sum()))}",
            setters[0] if setters else span,
            label=f"wins {_cells(_won(setters[0], cells, unset))} without setting `{name}`" if setters else "",
            labels=tuple(Label(s, "so does this rule") for s in setters[1:]),
            help=f"add `{name} is ..` to the rule, or give `{name}` an `otherwise`",
            notes=_block_notes(blocks, more, names.inputs),
            point=peak_point(blocks[0], names.inputs),
        )
    )


def peak_point(box: Box, inputs: tuple[Input, ...]) -> dict[str, str]:
    """A crisp input in the first cell of a box, where each of its terms is strongest."""
    return {v.name: quantity(core(v, terms[0]), v.variable.unit) for v, terms in zip(inputs, box, strict=True)}


def blocks_of(mask: Bools) -> Iterator[Box]:
    """Disjoint boxes that make up a set of cells, each grown greedily from the first cell that is left."""
    left = mask.copy()
    while left.any():
        seed = [int(k) for k in np.unravel_index(int(np.argmax(left)), left.shape)]
        box: list[tuple[int, ...]] = [(k,) for k in seed]
        for axis in range(left.ndim):
            grown = list(box)
            grown[axis] = tuple(range(left.shape[axis]))
            slab = left[np.ix_(*grown)]
            others = tuple(a for a in range(left.ndim) if a != axis)
            box[axis] = tuple(int(t) for t in np.flatnonzero(slab.all(axis=others)))
        left[np.ix_(*box)] = False
        yield tuple(box)


def _some_blocks(mask: Bools) -> tuple[list[Box], int]:
    """The first few blocks, and how many cells lie in the others."""
    shown: list[Box] = []
    left = int(mask.sum())
    for box in blocks_of(mask):
        shown.append(box)
        left -= int(np.prod([len(terms) for terms in box]))
        if len(shown) == SHOWN:
            break
    return shown, left


def _block_notes(blocks: list[Box], more: int, inputs: tuple[Input, ...]) -> tuple[str, ...]:
    notes = []
    for box in blocks:
        size = int(np.prod([len(terms) for terms in box]))
        notes.append(f"{_cells(size)}: {describe_box(box, inputs)}")
    if more:
        notes.append(f"and {more} more")
    return tuple(notes)


def _setters(box: Box, cells: Cells, claims: tuple[Claim, ...]) -> list[Span]:
    """Spans of up to three rules that take the first cell of a box for some other output."""
    flat = int(np.ravel_multi_index([terms[0] for terms in box], cells.rules.shape))
    rules = sorted({int(s) for s in cells.sources[:, flat] if s >= 0})
    return [claims[r].span for r in rules][:3]


def _won(span: Span, cells: Cells, unset: Bools) -> int:
    """Cells of an unset region that one rule takes."""
    rules = [i for i, r in enumerate(cells.account.rules) if r.span == span]
    return int((np.isin(cells.sources, rules).any(axis=0) & unset.reshape(-1)).sum())


def _report_missing_rows(
    needed: list[int], cells: Cells, claims: tuple[Claim, ...], missing: tuple[Missing, ...], names: RuleNames
) -> set[int]:
    """Outputs whose holes are rows and columns that their only table leaves out, reported as such."""
    explained: set[int] = set()
    tables = {o: {claims[s].table for s in np.unique(cells.sources[o]).tolist() if s >= 0} for o in needed}
    for left_out in missing:
        mine = [o for o in needed if tables[o] == {left_out.table}]
        if not mine:
            continue
        explained.update(mine)
        parts = []
        if left_out.rows:
            shown = ", ".join(f"`{row}`" for row in left_out.rows[:SHOWN])
            rest = len(left_out.rows) - SHOWN
            parts.append(f"no row for {shown}" + (f" and {rest} more" if rest > 0 else ""))
        if left_out.columns:
            parts.append("no column for " + ", ".join(f"`{column}`" for column in left_out.columns))
        unset = (cells.consequents[mine[0]] == -1).reshape(cells.rules.shape)
        blocks, _ = _some_blocks(unset)
        quoted = ", ".join(f"`{names.outputs[o].name}`" for o in mine)
        names.error(
            Diagnostic(
                "FZ320",
                f"the table has {' and '.join(parts)}",
                left_out.span,
                label=f"leaves {_cells(int(unset.sum()))} of {unset.size} without an answer",
                help=f"complete the table, or give {quoted} an `otherwise`",
                notes=(f"for example: {describe_box(blocks[0], names.inputs)}",),
                point=peak_point(blocks[0], names.inputs),
            )
        )
    return explained


def _cells(count: int) -> str:
    return f"{count} cell" if count == 1 else f"{count} cells"
