"""Checks specs given as text."""

from __future__ import annotations

from fuzzyspec.check import check
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source
from fuzzyspec.model.system import Module
from fuzzyspec.syntax import parse

DANGER = """
controller danger {
    input  gap in [0, 4] m { partition NEAR FAR }
    output ddc in [0, 1]   { partition LOW HIGH }
    table ddc by gap { NEAR: HIGH  FAR: LOW }
}
"""


def checked(text: str) -> tuple[Module | None, tuple[Diagnostic, ...], Source]:
    """The model of a module's body and everything that was found, the parser's findings first."""
    source = Source("spec.fz", "module spec\n" + text)
    tree, found = parse(source)
    model, more = check(tree, source, found)
    return model, (*found, *more), source


def sound(text: str) -> Module:
    """The model of a body in which nothing is wrong, not even a warning."""
    model, found, source = checked(text)
    assert not found, [(d.code, d.message, source.position(d.span.start)) for d in found]
    assert model is not None
    return model


def complaints(text: str) -> list[tuple[str, str]]:
    """Code and marked text of everything that was found."""
    _, found, source = checked(text)
    return [(d.code, source.text[d.span.start : d.span.end]) for d in found]


def step(body: str, controllers: str = DANGER) -> str:
    """A system with this body, and controllers for it to call."""
    return f"{controllers}\nsystem s {{\n{body}\n}}\n"


TABLE = "table u by e { NEAR: HIGH  FAR: LOW }"


def fuzzy(
    given: str = "[0, 4] { partition NEAR FAR }",
    taken: str = "[0, 1] { partition LOW HIGH }",
    more: str = "",
    rules: str = TABLE,
) -> str:
    """A controller of one input and one output; ``more`` are further items."""
    return f"""
    controller c {{
        input  e in {given}
        output u in {taken}
        {rules}
        {more}
    }}
    """
