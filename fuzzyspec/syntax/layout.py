"""Table rows that the grammar alone cannot tell apart: a row whose label lost its colon reads as a longer row above."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source
from fuzzyspec.syntax import tree
from fuzzyspec.syntax.builders import Node

Entry = tuple[tree.Name, ...]


def settle(module: tree.Module, source: Source) -> tuple[tuple[Node, ...], list[Diagnostic]]:
    """The module's items with such rows taken apart again, and a diagnostic for each."""
    found: list[Diagnostic] = []
    items = [
        replace(item, items=tuple(_table(i, source, found) if isinstance(i, tree.Table) else i for i in item.items))
        if isinstance(item, tree.ControllerDecl)
        else item
        for item in module.items
    ]
    return tuple(items), found


def _table(table: tree.Table, source: Source, found: list[Diagnostic]) -> tree.Table:
    if len(table.inputs) == 1:
        return _single(table, found)
    if not table.columns:
        found.append(
            Diagnostic(
                "FZ110",
                "this table has no header",
                table.rows[0].span,
                "the first row stands here",
                help=f"begin with the terms of `{table.inputs[-1].text}`, which runs across",
            )
        )
        return table
    columns, first = _lines(tuple((c,) for c in table.columns), source)
    rows: list[tree.TableRow] = []
    width = len(columns)
    for entries in first:
        rows.append(_unlabelled(entries, len(table.inputs), found))
    for row in table.rows:
        head, rest = _lines(row.entries, source, width)
        rows.append(replace(row, entries=head))
        rows.extend(_unlabelled(entries, len(table.inputs), found) for entries in rest)
    return replace(table, columns=tuple(c[0] for c in columns), rows=tuple(rows))


def _single(table: tree.Table, found: list[Diagnostic]) -> tree.Table:
    """One input: each row is a label and one entry."""
    rows: list[tree.TableRow] = []
    header = tuple((c,) for c in table.columns)
    if len(header) == 2:
        rows.append(_unlabelled(header, 1, found))
    elif header:
        found.append(
            Diagnostic(
                "FZ110",
                "a table by one input has no header",
                header[0][0].span.to(header[-1][0].span),
                help=f"write a row for each term of `{table.inputs[0].text}`: `{header[0][0].text}: TERM`",
            )
        )
    for row in table.rows:
        extra = row.entries[1:]
        if len(extra) % 2 or not extra:
            rows.append(row)
            continue
        rows.append(replace(row, entries=row.entries[:1]))
        rows.extend(_unlabelled(extra[i : i + 2], 1, found) for i in range(0, len(extra), 2))
    return replace(table, columns=(), rows=tuple(rows))


def _lines(
    entries: tuple[Entry, ...], source: Source, width: int | None = None
) -> tuple[tuple[Entry, ...], list[tuple[Entry, ...]]]:
    """Entries up to the first line's end, and those of each later line, where these look like rows of their own.

    With ``width`` (of the header) given, the first line must be as long as it; else a later line must be one longer
    than the first, as a row with its label is.
    """
    starts = [0]
    for i, (a, b) in enumerate(pairwise(entries), start=1):
        if source.position(a[0].span.start)[0] != source.position(b[0].span.start)[0]:
            starts.append(i)
    lines = [entries[a:b] for a, b in pairwise([*starts, len(entries)])]
    first, later = lines[0], lines[1:]
    if width is None:
        is_row = bool(later) and all(len(line) == len(first) + 1 for line in later)
    else:
        is_row = bool(later) and len(first) == width
    return (first, later) if is_row else (entries, [])


def _unlabelled(entries: tuple[Entry, ...], inputs: int, found: list[Diagnostic]) -> tree.TableRow:
    """The row that begins at a name which should have been a label."""
    name = entries[0][0]
    found.append(
        Diagnostic(
            "FZ109",
            f"expected `:` after the row's label `{name.text}`" if inputs < 3 else "expected a row's label",
            name.span,
            "needs a colon behind it" if inputs < 3 else "this line begins without one",
            help=None if inputs < 3 else f"begin the row with {inputs - 1} terms in parentheses: `(A, B):`",
        )
    )
    last = entries[-1][-1]
    labels = (name,)
    return tree.TableRow(labels, entries[1:] or ((name,),), name.span.to(last.span))
