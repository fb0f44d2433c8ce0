"""Mutants that are shown to compute the same: for every state at the changed place, or for every input.

Both files are run on the same unknowns: the changed statement alone, then all that leads to it from the function's
beginning (of a loop any round), then from the beginning of the innermost block around it, of the next, and so on.
Where all values agree behind the changed statement, or behind the block, for every value that the state before may
have in its types, the two functions do the same. Where they agree for every input of the function at its end, so too.
A mutant with a way to undefined behaviour that the original has not is never shown equal.

A controller's own function answers alike to alike, within the interval that its program promises; a divider is asked
only for divisors in the domain that its comment states. A wrong entry in the table of reciprocals is held to the lemma
that the table has to keep (docs/numbers.md, "digit"), by trying every divisor; any other entry may be one that no
input makes the C read.
"""

from __future__ import annotations

import itertools
import re
import subprocess
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Literal

import tree_sitter

from fuzzyspec.fixed.division import CELL_BITS, CELLS, FIRST_CELL, INVERSE_SHIFT, MISSING, REFLECTED, TOP_BITS
from tests.mutation.c_machine import Machine
from tests.mutation.c_mutants import parse, text
from tests.mutation.c_source import Source, Unclear, parameters, plain
from tests.mutation.c_values import Shared
from tests.mutation.c_words import WIDTHS, Word, Words

SECONDS = 10.0
"""For the solver, each time it is asked."""


@dataclass(frozen=True)
class Unit:
    """A preprocessed file; ``domains``: the least and the largest divisor of each divider."""

    root: tree_sitter.Node
    source: Source
    domains: Mapping[str, tuple[int, int]]


def unit(folder: Path, content: bytes) -> Unit:
    """A C file whose headers lie in ``folder``."""
    done = subprocess.run(
        ["gcc", "-E", "-P", "-I", str(folder), "-"], input=content, cwd=folder, capture_output=True, check=True
    )
    root = parse(done.stdout)
    domains = {}
    for comment, name in re.findall(r"/\*((?:(?!\*/).)*?)\*/\nstatic uint32_t (\w+)\(", content.decode(), re.DOTALL):
        if found := re.search(r"(?:2\^(\d+) <= )?den (<=?) 2\^(\d+)", comment):
            low = 2 ** int(found[1]) if found[1] else 0
            domains[name] = (low, 2 ** int(found[3]) - (found[2] == "<"))
    return Unit(root, Source.of(root), domains)


def shown_equal(one: Unit, other: Unit, ranges: Mapping[str, Mapping[str, tuple[int, int]]]) -> bool:
    """Whether a mutant is shown to do the same. ``ranges``: of functions' results by member."""
    if _reciprocals_do(one, other) or _never_read(one, other, ranges):
        return True
    changed = [n for n, f in one.source.functions.items() if plain(text(f)) != plain(text(other.source.functions[n]))]
    if one.source.tables != other.source.tables or len(changed) != 1:
        return False
    (name,) = changed
    places = list(_places(one.source.functions[name], other.source.functions[name]))
    ways: list[tuple[list[_Place], _Start]] = [(places, "alone"), (places, "path")]
    ways += [(places[: n + 1], "block") for n in reversed(range(len(places)))]
    for around, start in ways if places else ():
        for inline in (False, True):
            try:
                if _Claim(one, other, name, around, ranges, inline, start).holds():
                    return True
            except (Unclear, KeyError, AssertionError):
                continue
    return False


_Start = Literal["alone", "path", "block"]
"""From where both are run: the changed statement, the function's beginning straight to it, its block's beginning."""


@dataclass(frozen=True)
class _Place:
    """A block of both files in which one statement differs."""

    block: tree_sitter.Node
    other: tree_sitter.Node
    at: int


def _places(one: tree_sitter.Node, other: tree_sitter.Node) -> Iterator[_Place]:
    """The blocks around the change, outermost first."""
    if one.type == "compound_statement" and other.type == "compound_statement":
        pairs = list(zip(_statements(one), _statements(other), strict=False))
        if len(_statements(one)) == len(_statements(other)):
            at = next((i for i, (a, b) in enumerate(pairs) if plain(text(a)) != plain(text(b))), None)
            if at is not None:
                yield _Place(one, other, at)
    mine, theirs = one.named_children, other.named_children
    if one.type != other.type or len(mine) != len(theirs):
        return
    differing = [(a, b) for a, b in zip(mine, theirs, strict=True) if plain(text(a)) != plain(text(b))]
    if len(differing) == 1:
        yield from _places(*differing[0])


def _body(function: tree_sitter.Node) -> tree_sitter.Node:
    body = function.child_by_field_name("body")
    assert body is not None
    return body


def _statements(block: tree_sitter.Node) -> list[tree_sitter.Node]:
    """A deletion leaves an empty statement, which counts."""
    return [n for n in block.children if n.type not in ("{", "}", "comment")]


@dataclass
class _Claim:
    """That both do the same in the innermost of some blocks, whatever went before."""

    one: Unit
    other: Unit
    function: str
    places: list[_Place]
    ranges: Mapping[str, Mapping[str, tuple[int, int]]]
    inline: bool
    start: _Start

    def holds(self) -> bool:
        """Whether it is shown."""
        words = Words()
        self.shared = Shared(words, self.ranges)
        self.place = self.places[-1]
        machines = [Machine(u.source, self.shared, self.inline) for u in (self.one, self.other)]
        for machine in machines:
            if self.start == "path":
                self._lead(machine)
            else:
                self._begin(machine)
        if self.start == "alone":
            self._declared_before(machines)
        scope = set(machines[0].state)
        blocks = [_statements(self.place.block), _statements(self.place.other)]
        first = self.place.at if self.start == "alone" else 0
        for machine, block in zip(machines, blocks, strict=True):
            for node in block[first : self.place.at + 1]:
                machine.run(node)
        after = self._different(machines, set(machines[0].state) & set(machines[1].state))
        undefined = self._undefined(machines)
        if self._impossible([words.any([*after, undefined])]):
            return True
        if self.start == "alone":
            return False
        for machine, block in zip(machines, blocks, strict=True):
            for node in block[self.place.at + 1 :]:
                machine.run(node)
        end = self._different(machines, {k for k in scope if not self._local(k)})
        # What differs at the end differs behind the statement already.
        return self._impossible([words.any([*after, undefined]), words.any([*end, self._undefined(machines)])])

    def unread(self, table: str, entry: int) -> bool:
        """Whether the function is shown never to read an entry of a table."""
        self.shared = Shared(Words(), self.ranges)
        machine = Machine(self.one.source, self.shared, self.inline, watched=(table, entry))
        self._given(machine)
        for node in _statements(_body(machine.source.functions[self.function])):
            machine.run(node)
        return self._impossible([self.shared.words.any(machine.reads)])

    def _local(self, key: str) -> bool:
        """A parameter, or a local of the function's outermost block, has no meaning once the function has ended."""
        outermost = self.place.block.parent is not None and self.place.block.parent.type == "function_definition"
        return outermost and not key.startswith(("out.", "state."))

    def _impossible(self, claims: list[Word]) -> bool:
        return self.shared.words.impossible([*self.shared.facts, *claims], SECONDS)

    def _different(self, machines: list[Machine], keys: set[str]) -> list[Word]:
        words = self.shared.words
        claims: list[Word] = []
        for key in sorted(keys):
            a, b = (m.state[key] for m in machines)
            both = zip(a, b, strict=True) if isinstance(a, list) and isinstance(b, list) else [(a, b)]
            claims += [words.differ(x, y) for x, y in both]  # type: ignore[arg-type]
        if machines[0].result is not None and machines[1].result is not None:
            claims.append(words.differ(machines[0].result, machines[1].result))
        for name in machines[0].pointers:
            if machines[0].pointers[name] != machines[1].pointers.get(name):
                claims.append(1)
        return claims

    def _undefined(self, machines: list[Machine]) -> Word:
        """The mutant does what has no meaning, and the original does not."""
        words = self.shared.words
        return words.every([words.negated(words.any(machines[0].wrong)), words.any(machines[1].wrong)])

    # --- the state at the beginning -------------------------------------------------------------

    def _begin(self, machine: Machine) -> None:
        """Anything in every variable that the block knows from outside, under the condition that leads into it."""
        self._given(machine)
        function = machine.source.functions[self.function]
        own = self.place.block if machine.source is self.one.source else self.place.other
        around: list[tree_sitter.Node] = []
        node: tree_sitter.Node | None = own
        while node is not None and node != function:
            around.append(node)
            node = node.parent
        for inner, outer in itertools.pairwise(around):
            if outer.type == "compound_statement":
                for before in _statements(outer):
                    if before.start_byte >= inner.start_byte:
                        break
                    self._variables(machine, before)
            elif outer.type == "for_statement":
                start = outer.child_by_field_name("initializer")
                assert start is not None
                self._variables(machine, start)
        holder = own.parent
        if holder is not None and holder.type in ("for_statement", "if_statement"):
            condition = holder.child_by_field_name("condition")
            assert condition is not None
            self.shared.facts.append(self.shared.words.truth(machine.value(condition)[0]))
        elif holder is not None and holder.type == "else_clause" and holder.parent is not None:
            condition = holder.parent.child_by_field_name("condition")
            assert condition is not None
            self.shared.facts.append(self.shared.words.negated(machine.value(condition)[0]))

    def _given(self, machine: Machine) -> None:
        """Anything that a function may be called with."""
        for name, written in parameters(machine.source.functions[self.function]):
            ctype = machine.source.true(written)
            if ctype in WIDTHS:
                self._any(machine, name, ctype)
                if name == "den" and self.function in self.one.domains:
                    low, high = self.one.domains[self.function]
                    den = machine.state[name]
                    assert not isinstance(den, list)
                    self.shared.facts += [
                        self.shared.words.binary(">=", den, low, False),
                        self.shared.words.binary("<=", den, high, False),
                    ]
                continue
            for member, kind in machine.source.structs[ctype].items():
                if machine.source.true(kind) in WIDTHS and "*" not in kind:
                    self._any(machine, f"{name}.{member}", machine.source.true(kind))
                elif kind in machine.source.structs:
                    for inner, deep in machine.source.structs[kind].items():
                        self._any(machine, f"{name}.{member}.{inner}", machine.source.true(deep))

    def _lead(self, machine: Machine) -> None:
        """Everything from the function's beginning up to the innermost block, under the conditions that lead there."""
        self._given(machine)
        blocks = [p.block if machine.source is self.one.source else p.other for p in self.places]
        for place, block, inner in zip(self.places, blocks, blocks[1:], strict=False):
            for node in _statements(block)[: place.at]:
                machine.run(node)
            below: list[tree_sitter.Node] = [inner]
            while below[-1].parent is not None and below[-1].parent != block:
                below.append(below[-1].parent)
            for child, outer in reversed(list(itertools.pairwise(below))):
                if outer.type == "for_statement":
                    machine.enter(outer)
                condition = outer.child_by_field_name("condition")
                if condition is None or outer.type not in ("if_statement", "for_statement"):
                    continue
                holds = machine.value(condition)[0]
                aside = child.type == "else_clause"
                fact = self.shared.words.negated(holds) if aside else self.shared.words.truth(holds)
                self.shared.facts.append(fact)

    def _declared_before(self, machines: list[Machine]) -> None:
        """The block's own variables too may hold anything."""
        for machine, block in zip(machines, (self.place.block, self.place.other), strict=True):
            for node in _statements(block)[: self.place.at]:
                self._variables(machine, node)

    def _variables(self, machine: Machine, node: tree_sitter.Node) -> None:
        """What a declaration declares, with any value that its type can hold."""
        if node.type != "declaration":
            return
        known = set(machine.ctypes)
        if any(n.type == "pointer_declarator" for n in node.named_children) or "*" in text(node).split("=")[0]:
            machine.run(node)
            return
        written = node.child_by_field_name("type")
        assert written is not None
        bare = Machine(machine.source, self.shared, self.inline)
        for part in node.children_by_field_name("declarator"):
            inner = part.child_by_field_name("declarator") if part.type == "init_declarator" else part
            assert inner is not None
            bare.run(parse(f"{text(written)} {text(inner)};".encode()).named_children[0])
        machine.pointers.update(bare.pointers)
        for key, ctype in bare.ctypes.items():
            if key not in known:
                held = bare.state[key]
                if isinstance(held, list):
                    machine.ctypes[key] = ctype
                    machine.state[key] = [self.shared.remembered((key, i), ctype) for i in range(len(held))]
                else:
                    self._any(machine, key, ctype)

    def _any(self, machine: Machine, key: str, ctype: str) -> None:
        machine.ctypes[key] = ctype
        machine.state[key] = self.shared.remembered(("first", key), ctype)


def _never_read(one: Unit, other: Unit, ranges: Mapping[str, Mapping[str, tuple[int, int]]]) -> bool:
    """Whether all that differs is one entry of a table, which no input of any function makes it read."""
    tables = [k for k, t in one.source.tables.items() if other.source.tables.get(k) != t]
    same = all(plain(text(f)) == plain(text(other.source.functions[n])) for n, f in one.source.functions.items())
    if not same or len(tables) != 1:
        return False
    (table,) = tables
    pairs = zip(one.source.tables[table][1], other.source.tables[table][1], strict=True)
    entries = [i for i, (a, b) in enumerate(pairs) if a != b]
    for name, function in one.source.functions.items():
        for entry in entries if table in text(function) else ():
            claim = _Claim(one, other, name, [], ranges, True, "path")
            try:
                if not claim.unread(table, entry):
                    return False
            except (Unclear, KeyError, AssertionError):
                return False
    return bool(entries)


def _reciprocals_do(one: Unit, other: Unit) -> bool:
    """Whether all that differs is a table of reciprocals, and it still keeps the lemma for every divisor."""
    differing = [k for k, t in one.source.tables.items() if other.source.tables.get(k) != t]
    same = all(plain(text(f)) == plain(text(other.source.functions[n])) for n, f in one.source.functions.items())
    if not same or len(differing) != 1 or not differing[0].endswith("_reciprocals"):
        return False
    table = other.source.tables[differing[0]][1]
    if len(table) != CELLS or not all(0 <= g < 256 for g in table):
        return False
    least = 1 << 32
    for top in range(2 ** (TOP_BITS - 1 - MISSING["reciprocal"]), 2**TOP_BITS + 1):
        guess = table[(top >> (TOP_BITS - CELL_BITS)) - FIRST_CELL]
        if top * guess > REFLECTED or guess * (REFLECTED - top * guess) >= 2**32:
            return False
        inverse = (guess * (REFLECTED - top * guess)) >> INVERSE_SHIFT
        if inverse * (top + 1) > 2**32 or inverse > 2**19:
            return False
        least = min(least, inverse * top)
    return all(_digits_do(bits, (1 << 32) - least) for bits in (4, 8))


def _digits_do(bits: int, lost: int) -> bool:
    """Whether every remainder is below two divisors, and fits 32 bits, if an inverse lacks ``lost`` of 2^32 parts."""
    most = Fraction(1)
    for _ in range(16 // bits):
        if most * 2 ** {4: 27, 8: 23}[bits] * 2**bits > 2**32:
            return False
        most = 1 + most * 2**bits * Fraction(lost, 2**32) + Fraction(2**bits, 2**12)
        if most >= 2:
            return False
    return True
