"""The generator leaves out nothing of the language: what it never writes is listed here, and no valid spec has it."""

from __future__ import annotations

import inspect
from collections import Counter
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from types import ModuleType, NoneType, UnionType
from typing import Any, Literal, get_args, get_origin, get_type_hints

import pytest

from fuzzyspec import SpecError, load
from fuzzyspec.diagnostics.diagnostic import Source, Span
from fuzzyspec.fixed import program
from fuzzyspec.fixed.build import RangeError
from fuzzyspec.lower import Options
from fuzzyspec.lower.choice import strategies
from fuzzyspec.lower.controller import lower_controller
from fuzzyspec.lower.strategy import Strategy
from fuzzyspec.model import account, budget, controller, system, term, variable
from fuzzyspec.syntax import machine, parse
from fuzzyspec.syntax.table import Production, Table
from fuzzyspec.syntax.table import load as table
from tests.random_specs.generator import spec

SEEDS = range(120)
SAID = "module m controller c { input x in [0, 1] { partition A B } output y in [0, 1] { partition C D } %s } %s"
RULED = SAID % ("table y by x { A: C  B: D }", "%s")
REFUSED = {
    "start: __start_star_0": "param p = 1",
    "start: header": "module m",
    "controller: CONTROLLER NAME LBRACE RBRACE": "module m controller c { }",
    "system: SYSTEM NAME LBRACE RBRACE": RULED % "system s { }",
    "behavior: BEHAVIOR NAME PRIORITY sum LBRACE RBRACE": SAID % ("behavior P priority 1 { }", ""),
    "terms: LBRACE RBRACE": "module m controller c { input x in [0, 1] { } }",
    "_placing: placed_term": "module m controller c { input x in [0, 1] { partition A at 0 } }",
    "term: TERM NAME EQUAL POINTS LPAR _pair RPAR": "module m controller c { input x in [0, 1] { term A = points((0, 1)) } }",  # noqa: E501
    "primary: NAME LPAR RPAR": RULED % "system s { output z = max() }",
    "primary: NAME LPAR RPAR DOT NAME": RULED % "system s { output z = c().y }",
    "machine: NAME PLUS": SAID % ("budget { ram <= 0 B on avr+ }", ""),
    "machine: NAME __machine_star_20 PLUS": SAID % ("budget { ram <= 0 B on cortex-m0+ }", ""),
    "__machine_star_20: __machine_star_20 MINUS NAME": SAID % ("budget { ram <= 0 B on cortex-m-0 }", ""),
}
"""What no valid spec has, each with a text that has it."""

Alternative = tuple[str, str, Any]
"""A class and its field, and what stands there: a word of its Literal, a truth, or whether there is anything."""

FEW = 6


def productions(monkeypatch: pytest.MonkeyPatch, texts: list[str]) -> set[str]:
    """What the parser reduced on its way through sound texts."""
    reduce, found = machine._reduce, set()

    def noted(by: Table, cell: machine.Cell, production: Production) -> machine.Cell:
        found.add(named(production))
        return reduce(by, cell, production)

    monkeypatch.setattr(machine, "_reduce", noted)
    for text in texts:
        parse(Source("spec.fz", text))
    return found


def named(production: Production) -> str:
    """A production to be read."""
    return f"{production.origin}: {' '.join(production.symbols)}".rstrip()


def test_every_rule_of_the_grammar_is_used(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of all productions only those are never used that no valid spec has; nor is the one of an empty file."""
    every = {named(p) for state in table().states for _, p in state.values() if p is not None}
    assert every - productions(monkeypatch, [spec(seed) for seed in SEEDS]) == {*REFUSED, "start:"}


@pytest.mark.parametrize("production", REFUSED)
def test_what_is_never_written_is_refused(production: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A text with the production is no spec."""
    text = REFUSED[production]
    assert production in productions(monkeypatch, [text])
    with pytest.raises(SpecError):
        load(f"{text}\n")


def alternatives(of: type) -> Iterator[Alternative]:
    """What the fields of a class may hold, as far as that is a choice."""
    for name, hint in get_type_hints(of).items():
        if get_origin(hint) is Literal:
            yield from ((of.__name__, name, word) for word in get_args(hint))
        elif hint is bool:
            yield from ((of.__name__, name, truth) for truth in (True, False))
        elif isinstance(hint, UnionType) and NoneType in get_args(hint):
            yield from ((of.__name__, name, there) for there in ("nothing", "something"))


def taken(node: object, seen: set[int]) -> Iterator[Alternative | str]:
    """The classes of a tree of dataclasses, and of their fields' alternatives those that are taken."""
    if isinstance(node, tuple):
        for part in node:
            yield from taken(part, seen)
    elif is_dataclass(node) and not isinstance(node, Span) and id(node) not in seen:
        seen.add(id(node))
        name = type(node).__name__
        yield name
        for f in fields(node):
            value = getattr(node, f.name)
            yield (name, f.name, "nothing" if value is None else "something")
            if isinstance(value, str | bool):
                yield (name, f.name, value)
            yield from taken(value, seen)


def expected(modules: list[ModuleType]) -> set[Alternative | str]:
    """All classes and alternatives of the modules."""
    found: set[Alternative | str] = set()
    for module in modules:
        for of in vars(module).values():
            if inspect.isclass(of) and is_dataclass(of) and of.__module__ == module.__name__:
                found |= {of.__name__, *alternatives(of)}
    return found


def test_every_node_of_the_model_is_made() -> None:
    """Each class of the model, with each word, truth and absence that its fields allow."""
    found: set[Alternative | str] = set()
    for seed in SEEDS:
        found |= set(taken(load(spec(seed)).module, set()))
    assert expected([account, budget, controller, system, term, variable]) - found == set()


@pytest.mark.gate
def test_every_node_of_the_program_is_made() -> None:
    """Each class of the integer program with its words (types apart: ``widths`` gives those): of each strategy the
    first few controllers that it applies to, and some systems."""
    found: set[Alternative | str] = set()
    tried: Counter[Strategy] = Counter()
    for each in (c for seed in range(60) for c in load(spec(seed)).module.controllers):
        for strategy in strategies(each):
            tried[strategy] += 1
            if tried[strategy] <= FEW:
                try:
                    found |= set(taken(lower_controller(each, strategy)[0], set()))
                except RangeError:
                    continue
    for seed in range(FEW):
        loaded = load(spec(seed))
        try:
            found |= set(taken(loaded.lower(Options(target="avr" if seed % 2 else "generic")).program, set()))
        except SpecError:
            continue
    wanted = {of for of in expected([program]) if isinstance(of, str) or of[1] != "ctype"}
    assert wanted - found == set()
