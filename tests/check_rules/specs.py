"""Specs given as text or by name, checked."""

from __future__ import annotations

from pathlib import Path

from fuzzyspec.check import check
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source
from fuzzyspec.model.controller import Controller
from fuzzyspec.model.system import Module
from fuzzyspec.syntax import parse

ROOT = Path(__file__).parents[2]
FIXTURES = ROOT / "tests" / "fixtures"
EXAMPLES = ROOT / "examples"


def checked(source: Source) -> tuple[Module | None, tuple[Diagnostic, ...]]:
    """The model and everything that was found."""
    tree, problems = parse(source)
    model, found = check(tree, source, problems)
    return model, (*problems, *found)


def from_file(path: Path) -> tuple[Module | None, tuple[Diagnostic, ...], Source]:
    """The same for a file, with its source."""
    source = Source(path.name, path.read_text(encoding="utf-8"))
    return *checked(source), source


def from_text(text: str) -> tuple[Module | None, tuple[Diagnostic, ...]]:
    """The same for a text without its ``module`` line."""
    return checked(Source("spec.fz", f"module spec\n{text}"))


def the_controller(text: str) -> Controller:
    """The only controller of a text that has no errors."""
    model, found = from_text(text)
    assert model is not None, [(d.code, d.message) for d in found]
    (controller,) = model.controllers
    return controller
