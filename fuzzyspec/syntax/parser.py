"""Runs the tokens of a file through the machine."""

from __future__ import annotations

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source, Span
from fuzzyspec.syntax import tree
from fuzzyspec.syntax.machine import advance, bottom
from fuzzyspec.syntax.table import load
from fuzzyspec.syntax.tokens import tokenize


def parse(source: Source) -> tuple[tree.Module, tuple[Diagnostic, ...]]:
    """The tree of a file and what was wrong with it."""
    tokens, found = tokenize(source)
    table = load()
    cell = bottom()
    for token in tokens:
        after = advance(table, cell, token)
        if after is None:
            found.append(Diagnostic("FZ101", f"`{token.text}` is not expected here", token.span))
            return tree.Module(None, (), Span(0, len(source.text))), tuple(found)
        cell = after
    assert cell.below is not None
    module: tree.Module = cell.below.value
    return module, tuple(found)
