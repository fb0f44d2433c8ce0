"""Rule tables: header, rows and entries, as claims on cells."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from fuzzyspec.check.claims import Claim, whole
from fuzzyspec.check.rule_names import RuleNames
from fuzzyspec.check.similar import listing
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Span
from fuzzyspec.syntax import tree


@dataclass(frozen=True, slots=True)
class Missing:
    """What a table leaves out: whole rows and whole columns, in words; ``table`` is its index."""

    table: int
    outputs: tuple[int, ...]
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    span: Span


def resolve_tables(tables: tuple[tree.Table, ...], names: RuleNames) -> tuple[tuple[Claim, ...], tuple[Missing, ...]]:
    """The claims of every entry that could be resolved, and what each sound table leaves out."""
    claims: list[Claim] = []
    missing: list[Missing] = []
    for index, table in enumerate(tables):
        header = _header(table, names)
        if header is None:
            continue
        outputs, inputs = header
        if len(inputs) == 1:
            lists, columns = _list_rows(table, inputs[0], names), None
        else:
            if _other_inputs_header(table, inputs, names) or _header_is_off(table, inputs[-1], names):
                continue
            columns = _columns(table, inputs[-1], names)
            lists = _grid_rows(table, inputs, columns, names)
        for where, entry, span in lists:
            sets = _entry(entry, table, outputs, span, names)
            if sets is not None:
                box = whole(names.inputs)
                for i, t in where.items():
                    box[i] = (t,)
                claims.append(Claim(None, index, tuple(box), sets, span))
        left_out = _missing(index, table, outputs, inputs, columns, lists, names)
        if left_out.rows or left_out.columns:
            missing.append(left_out)
    return tuple(claims), tuple(missing)


_Row = tuple[dict[int, int], tuple[tree.Name, ...], Span]
"""Input index to term index, the entry, and the entry's span."""


def _header(table: tree.Table, names: RuleNames) -> tuple[tuple[int, ...], tuple[int, ...]] | None:
    """Output and input indices, or None where the header cannot be resolved."""
    complete = True
    for written, kind in ((table.outputs, "output"), (table.inputs, "input")):
        first: dict[str, tree.Name] = {}
        for name in written:
            earlier = first.setdefault(name.text, name)
            if earlier is not name:
                complete = False
                names.error(
                    Diagnostic(
                        "FZ314",
                        f"the table's header names {kind} `{name.text}` twice",
                        name.span,
                        label="named again",
                        labels=(Label(earlier.span, "first here"),),
                        help="name it once",
                    )
                )
    outputs = [names.output(name) for name in table.outputs]
    inputs = [names.input(name) for name in table.inputs]
    if not complete or None in outputs or None in inputs or not outputs or not inputs:
        return None
    return tuple(o for o in outputs if o is not None), tuple(i for i in inputs if i is not None)


def _columns(table: tree.Table, last: int, names: RuleNames) -> tuple[int | None, ...]:
    """Term indices of the header line; None where a column cannot be used."""
    found: list[int | None] = []
    first: dict[int, tree.Name] = {}
    for name in table.columns:
        term = names.input_term(last, name)
        if term is not None and term in first:
            names.error(
                Diagnostic(
                    "FZ319",
                    f"column `{name.text}` stands twice",
                    name.span,
                    label="again here",
                    labels=(Label(first[term].span, "first here"),),
                    help=f"each term of `{names.inputs[last].name}` has one column",
                )
            )
            term = None
        elif term is not None:
            first[term] = name
        found.append(term)
    return tuple(found)


def _other_inputs_header(table: tree.Table, inputs: tuple[int, ...], names: RuleNames) -> bool:
    """Reports a header whose columns are all terms of an input that labels the rows."""
    written = {c.text for c in table.columns}
    last, *others = (names.inputs[i] for i in (inputs[-1], *inputs[:-1]))
    if not written or written & {t.name for t in last.terms}:
        return False
    meant = next((v for v in others if written <= {t.name for t in v.terms}), None)
    if meant is None:
        return False
    order = ", ".join([*(v.name for v in (*others, last) if v is not meant), meant.name])
    names.error(
        Diagnostic(
            "FZ320",
            f"the header runs over `{meant.name}`, but the last input of the table is `{last.name}`",
            table.columns[0].span.to(table.columns[-1].span),
            label=f"terms of `{meant.name}`",
            labels=(Label(table.inputs[-1].span, "this one runs across"),),
            help=f"write `by {order}`, or run across the terms of `{last.name}`",
        )
    )
    return True


def _header_is_off(table: tree.Table, last: int, names: RuleNames) -> bool:
    """Reports a header that fits none of the rows, where these have an entry for each term."""
    terms = [t.name for t in names.inputs[last].terms]
    if not table.columns or any(len(row.entries) != len(terms) for row in table.rows):
        return False
    written = [c.text for c in table.columns]
    if len(written) == len(terms):
        return False
    lacking = [t for t in terms if t not in written]
    names.error(
        Diagnostic(
            "FZ320",
            f"the header has {_count(len(written), 'column')}, but every row has {len(terms)} entries",
            table.columns[0].span.to(table.columns[-1].span),
            label=f"lacks {listing(lacking)}" if lacking else f"`{names.inputs[last].name}` has {len(terms)} terms",
            help=f"name each term of `{names.inputs[last].name}` once, in the order of the entries",
        )
    )
    return True


def _list_rows(table: tree.Table, only: int, names: RuleNames) -> list[_Row]:
    """``N: S  Z: M``: one label and one entry each."""
    rows: list[_Row] = []
    seen: dict[tuple[int, ...], Span] = {}
    for row in table.rows:
        key = _label(row, (only,), seen, names)
        if len(row.entries) != 1:
            _wrong_entries(
                row, 1, names, f"a table by one input, `{names.inputs[only].name}`, has one entry for each term"
            )
        elif key is not None:
            rows.append(({only: key[0]}, row.entries[0], _span(row.entries[0], row)))
    return rows


def _grid_rows(
    table: tree.Table, inputs: tuple[int, ...], columns: tuple[int | None, ...], names: RuleNames
) -> list[_Row]:
    """The rows of a table with a header line: labels for all inputs but the last, an entry for each column."""
    rows: list[_Row] = []
    seen: dict[tuple[int, ...], Span] = {}
    for row in table.rows:
        key = _label(row, inputs[:-1], seen, names)
        if len(row.entries) != len(columns):
            _wrong_entries(row, len(columns), names, "a row has one entry for each column of the header line")
        elif key is not None:
            where = dict(zip(inputs[:-1], key, strict=True))
            for term, entry in zip(columns, row.entries, strict=True):
                if term is not None:
                    rows.append(({**where, inputs[-1]: term}, entry, _span(entry, row)))
    return rows


def _label(
    row: tree.TableRow, inputs: tuple[int, ...], seen: dict[tuple[int, ...], Span], names: RuleNames
) -> tuple[int, ...] | None:
    """Term indices of a row's labels, or None where the row cannot be placed."""
    span = _span(row.labels, row)
    if len(row.labels) != len(inputs):
        wanted = ", ".join(f"`{names.inputs[i].name}`" for i in inputs)
        names.error(
            Diagnostic(
                "FZ316",
                f"this row has {_count(len(row.labels), 'label')}, but the table needs {len(inputs)}",
                span,
                label=f"expected a term of {wanted}",
                help="label a row `A:` for one input, `(A, B):` for several, in the order of the table's `by`",
            )
        )
        return None
    found = [names.input_term(i, label) for i, label in zip(inputs, row.labels, strict=True)]
    key = tuple(t for t in found if t is not None)
    if len(key) != len(found):
        return None
    if key in seen:
        names.error(
            Diagnostic(
                "FZ319",
                f"row `{_row_text(key, inputs, names)}` stands twice",
                span,
                label="again here",
                labels=(Label(seen[key], "first here"),),
                help="each combination of labels has one row",
            )
        )
        return None
    seen[key] = span
    return key


def _entry(
    entry: tuple[tree.Name, ...], table: tree.Table, outputs: tuple[int, ...], span: Span, names: RuleNames
) -> tuple[tuple[int, int], ...] | None:
    """(output, term) indices of an entry, or None where it cannot be resolved."""
    if len(entry) != len(outputs):
        wanted = "/".join(name.text for name in table.outputs)
        names.error(
            Diagnostic(
                "FZ318",
                f"this entry names {_count(len(entry), 'term')}, but the table sets {_count(len(outputs), 'output')}",
                span,
                label=f"expected one term each for {wanted}",
                help="separate the terms of an entry by `/`, in the order of the table's outputs",
            )
        )
        return None
    found = [names.output_term(o, name) for o, name in zip(outputs, entry, strict=True)]
    sets = tuple((o, t) for o, t in zip(outputs, found, strict=True) if t is not None)
    return sets if len(sets) == len(outputs) else None


def _missing(
    index: int,
    table: tree.Table,
    outputs: tuple[int, ...],
    inputs: tuple[int, ...],
    columns: tuple[int | None, ...] | None,
    rows: list[_Row],
    names: RuleNames,
) -> Missing:
    labels = inputs if columns is None else inputs[:-1]
    present = {tuple(where[i] for i in labels) for where, _, _ in rows}
    every = itertools.product(*(range(len(names.inputs[i].terms)) for i in labels))
    terms = names.inputs[inputs[-1]].terms
    return Missing(
        index,
        outputs,
        tuple(_row_text(key, labels, names) for key in every if key not in present),
        () if columns is None else tuple(t.name for k, t in enumerate(terms) if k not in columns),
        table.span,
    )


def _wrong_entries(row: tree.TableRow, wanted: int, names: RuleNames, why: str) -> None:
    names.error(
        Diagnostic(
            "FZ317",
            f"this row has {_count(len(row.entries), 'entry', 'entries')}, but the table needs {wanted}",
            row.span,
            label=f"expected {_count(wanted, 'entry', 'entries')}",
            help=why,
        )
    )


def _span(written: tuple[tree.Name, ...], row: tree.TableRow) -> Span:
    return written[0].span.to(written[-1].span) if written else row.span


def _row_text(key: tuple[int, ...], inputs: tuple[int, ...], names: RuleNames) -> str:
    words = [names.inputs[i].terms[t].name for i, t in zip(inputs, key, strict=True)]
    return words[0] if len(words) == 1 else f"({', '.join(words)})"


def _count(number: int, one: str, many: str | None = None) -> str:
    return f"{number} {one if number == 1 else many or one + 's'}"
