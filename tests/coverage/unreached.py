"""Shows that no input gives a condition of the generated C an outcome, or finds an input that does.

What the analyser shows (``analysed``) is done with. For the rest the printed C is run on boxes of inputs (``boxes``),
every one of a function's inputs in one of them. A box in which the outcome cannot come up is done with; any other is
cut in two, at a place where the meaning changes if there is one in it, down to boxes of one input.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import tree_sitter

from fuzzyspec.emit.names import name_module
from fuzzyspec.fixed.program import Program
from fuzzyspec.native.workspace import PRODUCT, Workspace
from fuzzyspec.verify.draw import c_limits
from fuzzyspec.verify.points import special_raws
from fuzzyspec.verify.subject import Subject
from tests.coverage.analysed import impossible
from tests.coverage.boxes import Boxes, Ints, Span
from tests.coverage.measured import Condition, Outcome
from tests.mutation.c_machine import Machine
from tests.mutation.c_mutants import text
from tests.mutation.c_proof import unit
from tests.mutation.c_source import Source, Unclear, child, parameters
from tests.mutation.c_values import Shared
from tests.mutation.c_words import WIDTHS, Word

CHUNK = 1 << 14
"""Boxes that are run together."""
MOST = 1 << 18
"""Boxes of each function that are run before it is given up, unless told otherwise."""
WATCH = "fuzzyc_watched_"

Verdict = Literal["unreachable", "reached", "open"]


@dataclass
class Watching(Boxes):
    """``sides``: of each watched condition the outcome that is asked for. ``may``: in which boxes it may come up."""

    sides: Sequence[bool] = ()
    outer: list[Word] = field(default_factory=list)
    may: dict[int, npt.NDArray[np.bool_]] = field(default_factory=dict)


class Follower(Machine):
    """Follows one function and all that it calls."""

    words: Any

    def _call(self, node: tree_sitter.Node) -> tuple[Word, bool]:
        name = text(child(node, "function"))
        if not name.startswith(WATCH):
            before = len(self.words.outer)
            self.words.outer += self.guards
            found = super()._call(node)
            del self.words.outer[before:]
            return found
        at = int(name.removeprefix(WATCH))
        value, sign = self.value(child(node, "arguments").named_children[0])
        wanted = self.words.truth(value) if self.words.sides[at] else self.words.negated(value)
        claim = self.words.every([*self.words.outer, *self.guards, wanted])
        may = np.full(self.words.many, bool(claim)) if isinstance(claim, int) else claim.hi > 0
        self.words.may[at] = self.words.may.get(at, False) | may
        return value, sign

    def _place(self, node: tree_sitter.Node) -> str:
        if node.type == "subscript_expression" and isinstance(self.value(child(node, "index"))[0], Span):
            raise Unclear("a record of a table")
        return super()._place(node)


def verdicts(
    program: Program,
    files: Mapping[str, bytes],
    subjects: Sequence[Subject],
    missed: Sequence[Outcome],
    most: int = MOST,
) -> dict[Outcome, Verdict]:
    """What becomes of each outcome. ``most``: boxes of each function that are run before it is given up."""
    if not missed:
        return {}
    gone = impossible(program, files, missed, _marked, WATCH)
    rest = [o for o in missed if o not in gone]
    return dict.fromkeys(gone, "unreachable") | _searched(program, files, subjects, rest, most)


def _searched(
    program: Program,
    files: Mapping[str, bytes],
    subjects: Sequence[Subject],
    missed: Sequence[Outcome],
    most: int,
) -> dict[Outcome, Verdict]:
    source = next(n for n in files if n.endswith(".c") and not n.endswith("_selftest.c"))
    marked = _marked(files[source].decode(), [o.condition for o in missed])
    with Workspace(program, files) as workspace:
        parsed = unit(Path(workspace.path) / PRODUCT, marked.encode()).source
    names = name_module(program)
    functions = {names.functions[s.name].function: s for s in subjects}
    said: dict[Outcome, set[Verdict]] = {o: set() for o in missed}
    for name, subject in functions.items():
        asked = [o for o in missed if o.condition.function in _below(parsed, name, set(functions))]
        members = names.functions[subject.name].inputs
        for outcome, verdict in _of(parsed, name, subject, members, missed, asked, most).items():
            said[outcome].add(verdict)
    # One that none of them may have at all has not been looked at.
    return {
        o: "reached" if "reached" in v else "unreachable" if v == {"unreachable"} else "open" for o, v in said.items()
    }


def _marked(source: str, conditions: Sequence[Condition]) -> str:
    """The C with each condition handed to a function of its own."""
    lines = source.split("\n")
    marks = [(c.line, c.column, 1, -c.end_line, -c.end_column, f"{WATCH}{i}(") for i, c in enumerate(conditions)]
    marks += [(c.end_line, c.end_column, 0, -c.line, -c.column, ")") for c in conditions]
    for line, column, _, _, _, mark in sorted(marks, reverse=True):
        lines[line - 1] = lines[line - 1][: column - 1] + mark + lines[line - 1][column - 1 :]
    return "\n".join(lines)


def _below(source: Source, name: str, others: set[str]) -> set[str]:
    """A function and what it calls, but for those that are looked at by themselves, with any input."""
    body = text(source.functions[name])
    called = {n for n in source.functions if n != name and n not in others and f"{n}(" in body}
    return {name}.union(*(_below(source, n, others) for n in called))


def _of(
    source: Source,
    name: str,
    subject: Subject,
    members: Mapping[str, str],
    missed: Sequence[Outcome],
    asked: Sequence[Outcome],
    most: int,
) -> dict[Outcome, Verdict]:
    """What becomes of the outcomes that one function may have."""
    indices = [at for at, o in enumerate(missed) if o in asked]
    if not asked or subject.lists or not subject.ports:
        return dict.fromkeys(asked, "open")
    cuts = {members[k]: s.all for k, s in special_raws(subject).items()}
    whole = {members[k]: np.array([c_limits(p)]) for k, p in subject.ports.items()}
    stack = [(whole, np.ones((1, len(indices)), dtype=np.bool_))]
    reached, run = np.zeros(len(indices), dtype=np.bool_), 0
    while stack and run < most:
        boxes, may = stack.pop(0)
        if len(may) > CHUNK:
            for part in (slice(CHUNK), slice(CHUNK, None)):
                stack.append(({k: v[part] for k, v in boxes.items()}, may[part]))
            continue
        run += len(may)
        try:
            seen = _run(source, name, boxes, [o.holds for o in missed])
        except (Unclear, KeyError, AssertionError):
            return dict.fromkeys(asked, "open")
        for column, at in enumerate(indices):
            may[:, column] &= seen.get(at, False)
        single = np.all([v[:, 0] == v[:, 1] for v in boxes.values()], axis=0)
        reached |= may[single].any(axis=0)
        may &= ~reached
        kept = may.any(axis=1) & ~single
        if kept.any():
            stack.append((_cut({k: v[kept] for k, v in boxes.items()}, cuts), np.concatenate((may[kept], may[kept]))))
    left = np.any([may.any(axis=0) for _, may in stack] or [~reached & False], axis=0) & ~reached
    found: dict[Outcome, Verdict] = {}
    for column, at in enumerate(indices):
        found[missed[at]] = "reached" if reached[column] else "open" if left[column] else "unreachable"
    return found


def _run(source: Source, name: str, boxes: Mapping[str, Ints], sides: Sequence[bool]) -> Mapping[int, Any]:
    many = len(next(iter(boxes.values())))
    words = Watching(many, sides)
    machine = Follower(source, Shared(words, {}), True)  # type: ignore[arg-type]
    for parameter, written in parameters(source.functions[name]):
        _given(machine, parameter, source.true(written))
    for member, ends in boxes.items():
        machine.state[f"in.{member}"] = Span(ends[:, 0], ends[:, 1])  # type: ignore[assignment]
    for node in child(source.functions[name], "body").named_children:
        machine.run(node)
    return words.may


def _given(machine: Machine, place: str, ctype: str) -> None:
    """Anything in every member of a struct."""
    for member, written in machine.source.structs[ctype].items():
        kind = machine.source.true(written)
        if kind in WIDTHS:
            machine.ctypes[f"{place}.{member}"] = kind
            machine.state[f"{place}.{member}"] = machine.words.unknown(kind)
        else:
            _given(machine, f"{place}.{member}", kind)


def _cut(boxes: Mapping[str, Ints], cuts: Mapping[str, Ints]) -> dict[str, Ints]:
    """Each box in two: along the signal with the most marks inside, at the middle one; else along the widest."""
    keys = list(boxes)
    first = [np.searchsorted(cuts[k], boxes[k][:, 0], side="right") for k in keys]
    last = [np.searchsorted(cuts[k], boxes[k][:, 1], side="right") for k in keys]
    marks = np.array([b - a for a, b in zip(first, last, strict=True)])
    width = np.array([boxes[k][:, 1] - boxes[k][:, 0] for k in keys])
    along = np.where(marks.any(axis=0), marks.argmax(axis=0), width.argmax(axis=0))
    made = {k: np.concatenate((v, v)) for k, v in boxes.items()}
    n = len(along)
    for at, key in enumerate(keys):
        mine = np.flatnonzero(along == at)
        ends = boxes[key][mine]
        marked = marks[at][mine] > 0
        middle = np.minimum((first[at][mine] + last[at][mine]) // 2, len(cuts[key]) - 1)
        start = np.where(marked, cuts[key][middle], (ends[:, 0] + ends[:, 1] + 1) // 2)
        made[key][mine, 1] = start - 1
        made[key][mine + n, 0] = start
    return made
