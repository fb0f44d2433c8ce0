"""Firing: degrees become levels, one for each term of each output.

Cell rules are walked sparsely, over the slots of each input only (two in a strong partition), the partial strength
carried
from loop to loop. Sentence rules are straight-line code. A level is the largest strength of its term's rules, or
their sum.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import assert_never

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    AllOf,
    AnyOf,
    Assign,
    AssignElement,
    Branch,
    Comment,
    Const,
    CType,
    Define,
    Element,
    Expr,
    Local,
    Loop,
    Stmt,
    Table,
    Test,
)
from fuzzyspec.lower.arrays import zeroed
from fuzzyspec.lower.fuzzify import Degrees
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.controller import And, Antecedent, CellRules, Controller, Is, Not, Or, SentenceRule

HALF = Fraction(1, 2)
DEGREE_BITS = 15
SUM_LIMIT = 2**25
"""Sums of strengths stay below this, which leaves room for integer weights of up to 64."""
PARTIAL_BITS = 16
"""Fraction bits of a product on its way."""


@dataclass
class Firing:
    """Where the levels are and how exact.

    ``bits``: fraction bits of strengths and levels. ``strongest``: a local for each output that may not fire.
    ``cell_error``/``sentence_errors`` bound what firing itself adds to a strength, beyond its degrees' errors.
    """

    levels: list[str]
    bits: int
    top: int
    strongest: dict[int, Local] = field(default_factory=dict)
    acting: Local | None = None
    acting_strength: Local | None = None
    tables: list[Table] = field(default_factory=list)
    body: list[Stmt] = field(default_factory=list)
    cell_error: Fraction = Fraction(0)
    sentence_errors: dict[int, Fraction] = field(default_factory=dict)

    @property
    def one(self) -> int:
        return 1 << self.bits

    def level(self, output: int, term: Expr) -> Element:
        ctype: CType = "uint16" if self.bits == DEGREE_BITS and self.top <= 65535 else "uint32"
        return Element(self.levels[output], ctype, term, 0, self.top, False)


CellFiring = Callable[[Controller, CellRules, list[Degrees], "Firing", Scope], None]


def fire(controller: Controller, degrees: list[Degrees], scope: Scope, cells: CellFiring | None = None) -> Firing:
    """Statements that fill the level arrays of a controller; ``cells`` fires its cell rules (else the loops here)."""
    sums = controller.infer.aggregate == "sum"
    rules = _rule_count(controller, degrees)
    bits = DEGREE_BITS
    if sums:
        while bits < 24 and rules << (bits + 1) < SUM_LIMIT:
            bits += 1
    firing = Firing([], bits, (rules if sums else 1) << bits)
    for o, output in enumerate(controller.outputs):
        name = scope.name(f"{output.name}_level")
        firing.levels.append(name)
        size = len(output.terms) + (1 if _has_holes(controller, o) else 0)
        element = firing.level(o, Const(0))
        firing.body += zeroed(name, element.ctype, size, scope)
        if not controller.always_fires[o]:
            best = Local(scope.name(f"{output.name}_strongest"), "uint32", 0, firing.one)
            firing.strongest[o] = best
            firing.body.append(Define(best, Const(0), False))
    if controller.cells is not None:
        (cells or fire_loops)(controller, controller.cells, degrees, firing, scope)
    for number, rule in enumerate(controller.sentences):
        _sentence(controller, number, rule, degrees, firing, scope)
    return firing


def _rule_count(controller: Controller, degrees: list[Degrees]) -> int:
    cells = math.prod(d.slots for d in degrees) if controller.cells is not None else 0
    return max(1, cells + len(controller.sentences))


def _has_holes(controller: Controller, output: int) -> bool:
    return controller.cells is not None and -1 in controller.cells.consequents[output]


def reaches_half(controller: Controller, output: int) -> bool:
    """Whether some term of an output always has a level of 1/2: of its cell of larger degrees, each at least 1/2."""
    cells = controller.cells
    return (
        cells is not None
        and not controller.sentences
        and (controller.infer.and_, controller.infer.aggregate) == ("min", "max")
        and all(i.peaks is not None and len(i.peaks) > 1 for i in controller.inputs)
        and -1 not in cells.consequents[output]
    )


def used_terms(controller: Controller, output: int) -> frozenset[int]:
    """The terms of an output that some rule sets."""
    cells = () if controller.cells is None else controller.cells.consequents[output]
    named = {t for rule in controller.sentences for o, t in rule.consequents if o == output}
    return frozenset(named | set(cells) - {-1})


# --- cells -----------------------------------------------------------------------------------


def consequent_tables(
    controller: Controller, cells: CellRules, firing: Firing, scope: Scope
) -> list[tuple[int, Table]]:
    """For each output that cells set, the table of its term by cell; a cell that leaves it unset names no term."""
    consequents: list[tuple[int, Table]] = []
    for o, output in enumerate(controller.outputs):
        terms = cells.consequents[o]
        if all(t == -1 for t in terms):
            continue
        values = tuple(len(output.terms) if t == -1 else t for t in terms)
        consequents.append((o, Table(scope.name(f"{output.name}_rules"), "uint8", values)))
    firing.tables += [t for _, t in consequents]
    return consequents


def owner_table(controller: Controller, cells: CellRules, firing: Firing, scope: Scope) -> Table | None:
    """The behavior that owns each cell, and the locals of ``acting``; None without behaviors."""
    if not controller.behaviors:
        return None
    owners = Table(scope.name("owners"), "uint8", cells.owner)
    firing.tables.append(owners)
    firing.acting = Local(scope.name("acting"), "uint8", 0, max(cells.owner))
    firing.acting_strength = Local(scope.name("strongest"), "uint32", 0, firing.one)
    firing.body.append(Define(firing.acting, Const(0), False))
    firing.body.append(Define(firing.acting_strength, Const(0), False))
    return owners


def act(owners: Table, row: Expr, strength: Local, firing: Firing, scope: Scope) -> list[Stmt]:
    """A cell may own the strongest strength; on equal ones the lower code (the higher priority) acts."""
    acting, best = firing.acting, firing.acting_strength
    assert acting is not None and best is not None
    owner, lead = _owner(owners, row, scope)
    stronger: Test = AnyOf(
        (
            build.compare(">", strength, best),
            AllOf((build.compare("==", strength, best), build.compare("<", owner, acting))),
        )
    )
    if owner.lo == 0:
        stronger = AllOf((build.compare(">", owner, Const(0)), stronger))
    return [*lead, Branch(stronger, (Assign(acting, owner), Assign(best, strength)))]


def act_first(owners: Table, row: Expr, strength: Local, firing: Firing, scope: Scope) -> list[Stmt]:
    """The same for the first cell that is asked, of a strength above 0."""
    acting, best = firing.acting, firing.acting_strength
    assert acting is not None and best is not None
    owner, lead = _owner(owners, row, scope)
    steps: tuple[Stmt, ...] = (Assign(acting, owner), Assign(best, strength))
    return [*lead, Branch(build.compare(">", owner, Const(0)), steps)] if owner.lo == 0 else [*lead, *steps]


def act_equal(owners: Table, row: Expr, firing: Firing, scope: Scope) -> list[Stmt]:
    """The same for a cell that is as strong as the strongest, where every cell has an owner."""
    acting = firing.acting
    assert acting is not None
    owner, lead = _owner(owners, row, scope)
    return [*lead, Branch(build.compare("<", owner, acting), (Assign(acting, owner),))]


def _owner(owners: Table, row: Expr, scope: Scope) -> tuple[Local, list[Stmt]]:
    owner = Local(scope.name("owner"), "uint8", min(owners.values), max(owners.values))
    return owner, [Define(owner, Element(owners.name, "uint8", row, owner.lo, owner.hi, True), True)]


def fire_loops(controller: Controller, cells: CellRules, degrees: list[Degrees], firing: Firing, scope: Scope) -> None:
    """Walk the slots of every input in nested loops, the partial strength carried from loop to loop."""
    strides = [math.prod(cells.shape[i + 1 :]) for i in range(len(cells.shape))]
    base: Expr = Const(0)
    for d, stride in zip(degrees, strides, strict=True):
        base = build.add(base, build.mul(d.first, Const(stride)))
    consequents = consequent_tables(controller, cells, firing, scope)
    owners = owner_table(controller, cells, firing, scope)
    firing.body.append(Comment("rules: every cell of the active terms"))
    row: Expr = base
    if not isinstance(base, Const | Local):
        bound = build.local(scope.name("cell"), base)
        firing.body.append(Define(bound, base, True))
        row = bound
    firing.cell_error = _cell_rounding(controller, len(degrees), firing.bits)
    walk = _Walk(controller, degrees, strides, consequents, owners, firing, scope)
    firing.body += walk.loop(0, row, None)


def _cell_rounding(controller: Controller, inputs: int, bits: int) -> Fraction:
    if controller.infer.and_ == "min" or inputs == 1:
        return Fraction(0)
    return Fraction(inputs - 2, 2 ** (PARTIAL_BITS + 1)) + Fraction(1, 2 ** (bits + 1))


@dataclass
class _Walk:
    controller: Controller
    degrees: list[Degrees]
    strides: list[int]
    consequents: list[tuple[int, Table]]
    owners: Table | None
    firing: Firing
    scope: Scope

    def loop(self, i: int, row: Expr, strength: Local | None) -> list[Stmt]:
        if i == len(self.degrees):
            assert strength is not None
            return self.cell(row, strength)
        name = self.controller.inputs[i].name
        d, stride = self.degrees[i], self.strides[i]
        counter = Local(self.scope.name("ijklmnpqrtuv"[i] if i < 12 else "i"), "uint8", 0, d.slots - 1)
        degree = d.slot(counter)
        body: list[Stmt] = []
        if strength is None:
            first = Local(self.scope.name(f"{name}_s"), "uint16", 0, DEGREE_ONE)
            body.append(Define(first, degree, True))
            mine = first
            if len(self.degrees) == 1:
                widened = build.shift_left(first, self.firing.bits - DEGREE_BITS)
                if widened is not first:
                    mine = build.local(self.scope.name("strength"), widened)
                    body.append(Define(mine, widened, True))
        elif self.controller.infer.and_ == "min":
            own = Local(self.scope.name(f"{name}_d"), "uint16", 0, DEGREE_ONE)
            least = build.least(strength, own)
            mine = build.local(self.scope.name(f"{name}_s"), least)
            body += [Define(own, degree, True), Define(mine, least, True)]
            if i == len(self.degrees) - 1 and self.firing.bits != DEGREE_BITS:
                widened = build.shift_left(mine, self.firing.bits - DEGREE_BITS)
                mine = build.local(self.scope.name("strength"), widened)
                body.append(Define(mine, widened, True))
        else:
            # The first factor is Q15, later partial products Q16; the last product goes to the levels' scale.
            have = DEGREE_BITS if i == 1 else PARTIAL_BITS
            want = self.firing.bits if i == len(self.degrees) - 1 else PARTIAL_BITS
            value = build.rounded_shift(build.mul(strength, degree), have + DEGREE_BITS - want)
            mine = build.local(self.scope.name(f"{name}_s"), value)
            body.append(Define(mine, value, True))
        place: Expr = build.add(row, build.mul(counter, Const(stride)))
        if not isinstance(place, Local):
            bound = build.local(self.scope.name(f"{name}_cell"), place)
            body.append(Define(bound, place, True))
            place = bound
        inner = self.loop(i + 1, place, mine)
        # A strength of 0 changes nothing; where more than a cell hangs on it, it is not followed.
        body += [Branch(build.compare(">", mine, Const(0)), tuple(inner))] if i < len(self.degrees) - 1 else inner
        return [Loop(counter, d.slots, tuple(body))]

    def cell(self, row: Expr, strength: Local) -> list[Stmt]:
        body: list[Stmt] = []
        for o, table in self.consequents:
            output = self.controller.outputs[o]
            hi = max(table.values)
            term = Local(self.scope.name(f"{output.name}_term"), "uint8", min(table.values), hi)
            body.append(Define(term, Element(table.name, "uint8", row, term.lo, hi, True), True))
            holes = len(output.terms) if hi == len(output.terms) else None
            body += raise_level(self.controller, self.firing, o, term, strength, holes)
        if self.owners is not None:
            body += act(self.owners, row, strength, self.firing, self.scope)
        return body


def raise_level(
    controller: Controller, firing: Firing, output: int, term: Expr, strength: Local, hole: int | None = None
) -> list[Stmt]:
    """A rule's strength enters its term's level; ``hole`` is the index that stands for no term."""
    level = firing.level(output, term)
    body: list[Stmt] = []
    if controller.infer.aggregate == "max":
        body.append(
            Branch(
                build.compare(">", strength, level),
                (AssignElement(level.array, level.ctype, term, strength),),
            )
        )
    else:
        total = build.add_bounded(level, strength, firing.top)
        body.append(AssignElement(level.array, level.ctype, term, total))
    best = firing.strongest.get(output)
    if best is not None:
        stronger = build.compare(">", strength, best)
        test: Test = stronger
        if hole is not None:
            test = AllOf((build.compare("<", term, Const(hole)), stronger))
        body.append(Branch(test, (Assign(best, strength),)))
    return body


# --- sentences -------------------------------------------------------------------------------


def _sentence(
    controller: Controller, number: int, rule: SentenceRule, degrees: list[Degrees], firing: Firing, scope: Scope
) -> None:
    firing.body.append(Comment(f"rule {number + 1}"))
    walk = _Sentence(controller, degrees, scope, firing.body)
    strength, error = walk.strength(rule.antecedent)
    if rule.weight != 1:
        weight = math.floor(rule.weight * DEGREE_ONE + HALF)
        strength = walk.bind(build.rounded_shift(build.mul(strength, Const(weight)), DEGREE_BITS), "weighted")
        error = error + abs(Fraction(weight, DEGREE_ONE) - rule.weight) + Fraction(1, 2 * DEGREE_ONE)
    firing.sentence_errors[number] = error
    if firing.bits != DEGREE_BITS:
        strength = walk.bind(build.shift_left(strength, firing.bits - DEGREE_BITS), "strength")
    if not isinstance(strength, Local):
        bound = build.local(scope.name("strength"), strength)
        firing.body.append(Define(bound, strength, True))
        strength = bound
    for output, term in rule.consequents:
        firing.body += raise_level(controller, firing, output, Const(term), strength)


@dataclass
class _Sentence:
    """Builds one antecedent; the second result bounds the roundings on the way (not the degrees' own errors)."""

    controller: Controller
    degrees: list[Degrees]
    scope: Scope
    body: list[Stmt]

    def bind(self, value: Expr, name: str) -> Expr:
        if isinstance(value, Const | Local):
            return value
        bound = build.local(self.scope.name(name), value)
        self.body.append(Define(bound, value, True))
        return bound

    def strength(self, node: Antecedent) -> tuple[Expr, Fraction]:
        match node:
            case Is(i, terms):
                item = self.controller.inputs[i]
                parts = [
                    (self.bind(self.degrees[i].slot(Const(t)), f"{item.name}_is_{item.terms[t].name}"), Fraction(0))
                    for t in terms
                ]
                return self.join(parts, "or")
            case Not(operand):
                value, error = self.strength(operand)
                return self.bind(build.sub(Const(DEGREE_ONE), value), "not_so"), error
            case And(operands):
                return self.join([self.strength(o) for o in operands], "and")
            case Or(operands):
                return self.join([self.strength(o) for o in operands], "or")
            case _:
                assert_never(node)

    def join(self, parts: list[tuple[Expr, Fraction]], how: str) -> tuple[Expr, Fraction]:
        value, error = parts[0]
        half = Fraction(1, 2 * DEGREE_ONE)
        for other, more in parts[1:]:
            infer = self.controller.infer
            if how == "and" and infer.and_ == "min":
                value, error = self.bind(build.least(value, other), "both"), max(error, more)
            elif how == "or" and infer.or_ == "max":
                value, error = self.bind(build.greatest(value, other), "either"), max(error, more)
            else:
                both = self.bind(build.rounded_shift(build.mul(value, other), DEGREE_BITS), "product")
                error = error + more + half
                if how == "and":
                    value = both
                else:
                    total = self.bind(build.add(value, other), "total")
                    value = self.bind(build.sub_guarded(total, both, DEGREE_ONE), "either")
        return value, error
