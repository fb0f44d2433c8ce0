"""Limits that keep a hostile or runaway file from costing more than a diagnostic."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source, Span
from fuzzyspec.syntax import tree
from fuzzyspec.syntax.tokens import Token

MAX_CHARACTERS = 1 << 19
"""Characters of one file."""
MAX_NESTING = 32
"""Brackets open at once."""
MAX_DEPTH = 100
"""Steps from the whole of an expression or condition down to its innermost part."""


def too_large(source: Source) -> Diagnostic | None:
    """Refuses a file beyond any spec's size."""
    if len(source.text) <= MAX_CHARACTERS:
        return None
    return Diagnostic(
        "FZ120",
        f"the file has {len(source.text)} characters",
        Span(0, 0),
        help=f"a spec has at most {MAX_CHARACTERS} characters; nothing of this file was read",
    )


def too_nested(tokens: list[Token]) -> Diagnostic | None:
    """Finds the bracket at which too many are open."""
    depth = 0
    for token in tokens:
        if token.kind in ("LBRACE", "LPAR", "LSQB"):
            depth += 1
            if depth > MAX_NESTING:
                return Diagnostic(
                    "FZ121",
                    f"more than {MAX_NESTING} brackets within one another",
                    token.span,
                    "one too many",
                    help="give the inner part a name by `let`; nothing of this file was read",
                )
        elif token.kind in ("RBRACE", "RPAR", "RSQB"):
            depth = max(0, depth - 1)
    return None


def too_deep(module: tree.Module) -> Diagnostic | None:
    """Finds an expression with too many steps one within another, without recursion."""
    stack: list[tuple[object, int]] = [(item, 0) for item in module.items]
    while stack:
        node, depth = stack.pop()
        if isinstance(node, tuple):
            stack.extend((part, depth) for part in node)
            continue
        if not is_dataclass(node) or isinstance(node, Span | tree.Name | tree.UnitExpr):
            continue
        if isinstance(node, tree.Expr | tree.Condition):
            depth += 1
            if depth > MAX_DEPTH:
                return Diagnostic(
                    "FZ121",
                    f"an expression of more than {MAX_DEPTH} steps",
                    node.span,
                    "this lies too deep in it",
                    help="divide it: give parts names by `let`, or fold over a list; nothing of this file was read",
                )
        stack.extend((getattr(node, f.name), depth) for f in fields(node))
    return None


def too_many(token: Token, count: int) -> Diagnostic:
    """Says where reading stopped."""
    return Diagnostic(
        "FZ123",
        f"more than {count} syntax errors: the rest of the file was not read",
        token.span,
        "reading stopped here",
        severity="note",
    )
