"""Recorded inputs: a CSV file becomes the cases of a replay."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from fuzzyspec.diagnostics.refusal import Refusal
from fuzzyspec.fixed.program import ListPort, Port
from fuzzyspec.fixed.quantise import nearest
from fuzzyspec.model.variable import RAW_LIMITS
from fuzzyspec.verify.cases import BATCH, Batch
from fuzzyspec.verify.points import Raws
from fuzzyspec.verify.subject import Subject

IGNORED = ("t", "time")
"""Columns that may stand beside the signals."""

_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?\Z")


class ScenarioError(Refusal):
    """A recording that cannot be read; the message names the file, the line and the column."""


@dataclass(frozen=True, slots=True)
class _Cell:
    """Where a column goes: a scalar, a list's count, or a field of its element ``index``."""

    key: str
    port: Port | None
    listed: ListPort | None = None
    index: int = 0


def read_scenario(subject: Subject, text: str, name: str, *, raw: bool = False) -> tuple[Batch, ...]:
    """The rows of a CSV in order, as batches. A function that remembers steps from row to row, from its first state.

    Columns are named as signals: ``target_bearing``, ``obstacles.0.distance``, and, where it is not simply the number
    of elements that a row fills, ``obstacles.count``. Values are in declared units, or raws with ``raw``.
    """
    rows = list(csv.reader(io.StringIO(text.removeprefix("\ufeff"), newline="")))
    if not rows or not any(cell.strip() for cell in rows[0]):
        raise ScenarioError(f"{name}: no header line", "the first line names the signals")
    cells = _columns(subject, [c.strip() for c in rows[0]], name)
    records = [(number, row) for number, row in enumerate(rows[1:], 2) if any(c.strip() for c in row)]
    if not records:
        raise ScenarioError(f"{name}: no rows")
    inputs = {k: np.zeros(len(records), dtype=np.int64) for k in (p.name for p in subject.scalars)}
    for listed in subject.lists:
        width = max((c.index + 1 for c in cells if c and c.listed is listed and c.port), default=0)
        inputs |= {f"{listed.name}.{f.name}": np.zeros((len(records), width), dtype=np.int64) for f in listed.fields}
        inputs[f"{listed.name}.count"] = np.zeros(len(records), dtype=np.int64)
    for at, (number, row) in enumerate(records):
        if len(row) != len(cells):
            raise ScenarioError(f"{name}:{number}: {len(row)} values under {len(cells)} columns")
        _fill(subject, inputs, at, cells, row, f"{name}:{number}", raw)
    return tuple(_batches(subject, inputs, len(records)))


def _batches(subject: Subject, inputs: dict[str, Raws], n: int) -> Iterable[Batch]:
    if not subject.state:
        for start in range(0, n, BATCH):
            yield Batch("scenario", {k: v[start : start + BATCH] for k, v in inputs.items()}, {})
        return
    first = {k: np.array([v], dtype=np.int64) for k, v in subject.initial.items()}
    for at in range(n):
        row = {k: v[at : at + 1] for k, v in inputs.items()}
        yield Batch("scenario", row, first if at == 0 else {}, follow=at > 0)


def _columns(subject: Subject, header: Sequence[str], name: str) -> list[_Cell | None]:
    scalars = {p.name: p for p in subject.scalars}
    lists = {p.name: p for p in subject.lists}
    cells: list[_Cell | None] = []
    for column in header:
        parts = column.split(".")
        listed = lists.get(parts[0])
        fields = {f.name: f for f in listed.fields} if listed is not None else {}
        if header.count(column) > 1:
            raise ScenarioError(f"{name}:1: the column `{column}` appears twice")
        if column in scalars:
            cells.append(_Cell(column, scalars[column]))
        elif listed is not None and parts[1:] == ["count"]:
            cells.append(_Cell(column, None, listed))
        elif listed is not None and len(parts) == 3 and parts[1].isdigit() and parts[2] in fields:
            if int(parts[1]) >= 256:
                raise ScenarioError(f"{name}:1: the column `{column}` is beyond any list")
            cells.append(_Cell(f"{listed.name}.{parts[2]}", fields[parts[2]], listed, int(parts[1])))
        elif column.lower() in IGNORED:
            cells.append(None)
        else:
            known = [*scalars, *(f"{p.name}.0.{f.name}" for p in subject.lists for f in p.fields)]
            raise ScenarioError(
                f"{name}:1: `{subject.name}` has no signal `{column}`", f"its signals are {', '.join(known)}"
            )
    given = {c.key for c in cells if c is not None}
    for missing in (p.name for p in subject.scalars if p.name not in given):
        raise ScenarioError(f"{name}:1: no column `{missing}`", f"`{subject.name}` wants every input")
    for listed in subject.lists:
        indices = {c.index for c in cells if c is not None and c.listed is listed and c.port is not None}
        for index in sorted(indices):
            there = {c.key for c in cells if c is not None and c.listed is listed and c.port and c.index == index}
            for field in listed.fields:
                if f"{listed.name}.{field.name}" not in there:
                    raise ScenarioError(f"{name}:1: no column `{listed.name}.{index}.{field.name}`")
    return cells


def _fill(
    subject: Subject,
    inputs: dict[str, Raws],
    at: int,
    cells: Sequence[_Cell | None],
    row: Sequence[str],
    where: str,
    raw: bool,
) -> None:
    filled: dict[str, set[int]] = {p.name: set() for p in subject.lists}
    blank: dict[str, set[int]] = {p.name: set() for p in subject.lists}
    counts: dict[str, int] = {}
    for cell, written in zip(cells, (w.strip() for w in row), strict=True):
        if cell is None:
            continue
        if cell.port is None:
            assert cell.listed is not None
            if written:
                if not written.isdigit() or int(written) > 255:
                    raise ScenarioError(f"{where}: {cell.key}: `{written}` is no count from 0 to 255")
                counts[cell.listed.name] = int(written)
        elif cell.listed is None:
            inputs[cell.key][at] = raw_of(cell.port, written, f"{where}: {cell.key}", raw)
        elif written:
            column = f"{cell.listed.name}.{cell.index}.{cell.port.name}"
            inputs[cell.key][at, cell.index] = raw_of(cell.port, written, f"{where}: {column}", raw)
            filled[cell.listed.name].add(cell.index)
        else:
            blank[cell.listed.name].add(cell.index)
    for listed in subject.lists:
        complete = filled[listed.name] - blank[listed.name]
        count = counts.get(listed.name, len(complete))
        needed = set(range(min(count, listed.capacity)))
        if not needed <= complete or (listed.name not in counts and filled[listed.name] != needed):
            wrong = min((needed | filled[listed.name]) - (complete & needed))
            raise ScenarioError(
                f"{where}: element {wrong} of `{listed.name}` is not filled as its count of {count} says"
            )
        inputs[f"{listed.name}.count"][at] = count


def raw_of(port: Port, written: str, where: str, raw: bool) -> int:
    """The raw for a written value: nearest, ties up, held within the C type (not within the range: that is the C's)."""
    assert port.variable is not None
    if _NUMBER.match(written) is None:
        raise ScenarioError(f"{where}: `{written}` is no number" if written else f"{where}: no value")
    value = Fraction(written)
    low, high = RAW_LIMITS[port.variable.raw.ctype]
    if raw:
        if value.denominator != 1 or not low <= value <= high:
            raise ScenarioError(f"{where}: `{written}` is no raw of {port.ctype}_t")
        return int(value)
    return nearest(port.variable, value)
