"""Runs the tokens of a file through the machine; where they do not fit, repairs or skips, and goes on."""

from __future__ import annotations

from dataclasses import replace

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source, Span
from fuzzyspec.syntax import layout, limits, repair, skip, tree
from fuzzyspec.syntax.edits import CAPITALS
from fuzzyspec.syntax.machine import Cell, advance, bottom
from fuzzyspec.syntax.reading import stack_at
from fuzzyspec.syntax.table import load
from fuzzyspec.syntax.tokens import END, Token, tokenize, unit_behind

MAX_ERRORS = 50
"""Syntax errors of one file after which its rest is left unread."""


def parse(source: Source) -> tuple[tree.Module, tuple[Diagnostic, ...]]:
    """The tree of a file and every syntax problem in it, by position. Never raises, whatever the text.

    Where there are problems the tree is partial: items that could not be read are missing, and a name that recovery had
    to put in is ``tokens.MISSING``. A file that breaks a limit has an empty tree.
    """
    if problem := limits.too_large(source):
        return _nothing(source), (problem,)
    tokens, found = tokenize(source)
    if problem := limits.too_nested(tokens):
        return _nothing(source), (*found, problem)
    if len(tokens) == 1:
        return _nothing(source), (*found, _empty(source))
    reading = _Reading(source, tokens)
    module = reading.run()
    found += _alike_once(reading.found)
    if problem := limits.too_deep(module):
        return _nothing(source), (*_sorted(found), problem)
    if module.name is None and not any(d.span.start <= tokens[0].end for d in found):
        found.append(_headless(source, tokens[0]))
    items, rows = layout.settle(module, source)
    found += rows
    return replace(module, items=items), _sorted(found)


def _sorted(found: list[Diagnostic]) -> tuple[Diagnostic, ...]:
    return tuple(sorted(found, key=lambda d: (d.span, d.code)))


def _alike_once(found: list[Diagnostic]) -> list[Diagnostic]:
    """Whoever writes one keyword in capitals writes all, and what lost its block stands wrong as a whole: told once."""
    alike: dict[str, list[Diagnostic]] = {}
    kept: list[Diagnostic] = []
    for d in found:
        cause = CAPITALS if d.help == CAPITALS else d.message if d.code == "FZ116" else ""
        if cause:
            alike.setdefault(cause, []).append(d)
        if not cause or len(alike[cause]) == 1:
            kept.append(d)
    return [_counting(d, alike.get(CAPITALS if d.help == CAPITALS else d.message, [d])) for d in kept]


def _counting(first: Diagnostic, alike: list[Diagnostic]) -> Diagnostic:
    more = len(alike) - 1
    if not more:
        return first
    if first.help == CAPITALS:
        note = f"{more} more keyword{'s' if more > 1 else ''} in capitals in this file"
    else:
        note = f"the same in {more} other place{'s' if more > 1 else ''}"
    return replace(first, notes=(*first.notes, note))


def _nothing(source: Source) -> tree.Module:
    return tree.Module(None, (), Span(0, len(source.text)))


def _empty(source: Source) -> Diagnostic:
    return Diagnostic(
        "FZ113",
        "the file holds no spec",
        Span(0, 0),
        help="a spec begins with `module NAME` and has at least one `controller`",
    )


def _headless(source: Source, first: Token) -> Diagnostic:
    return Diagnostic(
        "FZ112",
        "the file does not begin with `module` and a name",
        first.span,
        "expected `module NAME` before this",
        help="the module's name becomes the prefix of every C name: `module nav` gives `nav_step`",
    )


class _Reading:
    """One run over a file's tokens."""

    def __init__(self, source: Source, tokens: list[Token]) -> None:
        self.source = source
        self.table = load()
        self.tokens = tokens
        self.trail: list[Cell] = []
        self.cell = bottom()
        self.found: list[Diagnostic] = []

    def run(self) -> tree.Module:
        index = 0
        while True:
            token = self.tokens[index]
            after = advance(self.table, self.cell, token)
            if after is None:
                index = self._recover(index)
                continue
            if token.kind == END:
                break
            self.trail.append(self.cell)
            self.cell = after
            index += 1
        assert after.below is not None
        module: tree.Module = after.below.value
        return module

    def _recover(self, index: int) -> int:
        """Makes an edit or skips, so that reading can go on; returns where."""
        if sum(d.help != CAPITALS for d in self.found) >= MAX_ERRORS:
            self.found.append(limits.too_many(self.tokens[index], MAX_ERRORS))
            return self._give_up(index)
        edit = repair.best(self, index)
        if edit is not None:
            self.found.append(edit.diagnostic)
            for i, token in edit.swaps.items():
                self.tokens[i] = token
                if token.kind == "RSQB":
                    unit_behind(self.tokens, i + 1, self.source.text)
            self.tokens[edit.at : edit.at + edit.drop] = edit.insert
            self.cell = stack_at(self, edit.at)
            del self.trail[edit.at :]
            return edit.at
        self.found.append(skip.misfit(self, index))
        index, self.cell = skip.to_next(self, index)
        self.trail += [self.cell] * (index - len(self.trail))
        return index

    def _give_up(self, index: int) -> int:
        """Leaves the rest of the file unread."""
        self.cell = skip.whole(self)
        self.tokens[index:-1] = []
        return index
