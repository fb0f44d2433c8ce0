"""What holds of any text that is read and checked, a spec or not."""

from __future__ import annotations

from fuzzyspec.check import check
from fuzzyspec.diagnostics.codes import REGISTRY
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source
from fuzzyspec.diagnostics.render import as_json, render
from fuzzyspec.model.system import Module
from fuzzyspec.syntax import parse


def checked(source: Source) -> tuple[Module | None, tuple[Diagnostic, ...]]:
    """The model and all that was told: each diagnostic can be shown, and one is an error where there is no model."""
    tree, torn = parse(source)
    model, found = check(tree, source, torn)
    told = (*torn, *found)
    for color in (False, True):
        render(told, source, color)
    as_json(told, source)
    for d in told:
        assert d.severity == REGISTRY[d.code].severity, d
        assert all(0 <= s.start <= s.end <= len(source.text) for s in (d.span, *(each.span for each in d.labels))), d
    assert (model is None) == any(d.severity == "error" for d in told), told
    return model, told
