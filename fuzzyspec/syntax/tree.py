"""The syntax tree: what was written, with spans, before any name is looked up.

Numbers are exact: a literal ``0.1`` is ``Fraction(1, 10)``.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from fuzzyspec.diagnostics.diagnostic import Span


@dataclass(frozen=True, slots=True)
class Name:
    text: str
    span: Span


@dataclass(frozen=True, slots=True)
class UnitExpr:
    """A unit as written: factors ``(symbol, exponent)`` in order; ``m/s`` is ``(m, 1) (s, -1)``."""

    factors: tuple[tuple[str, int], ...]
    span: Span


# --- expressions -----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Number:
    """A quantity. ``unit`` is None for a bare number."""

    value: Fraction
    unit: UnitExpr | None
    span: Span


@dataclass(frozen=True, slots=True)
class Ref:
    """A dotted name: ``T``, ``o.gap``, ``drive.v``."""

    parts: tuple[Name, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Unary:
    op: Literal["-"]
    operand: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Binary:
    op: Literal["+", "-", "*", "/"]
    left: Expr
    right: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Compare:
    """A chain: ``-30 deg <= x < 30 deg`` has three operands and two ops."""

    operands: tuple[Expr, ...]
    ops: tuple[Literal["<", "<=", ">", ">=", "==", "!="], ...]
    span: Span


@dataclass(frozen=True, slots=True)
class InRange:
    """``x in [lo, hi] unit``: both ends belong."""

    value: Expr
    lo: Expr
    hi: Expr
    unit: UnitExpr | None
    span: Span


@dataclass(frozen=True, slots=True)
class Logic:
    op: Literal["and", "or", "not"]
    operands: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Conditional:
    """``then if test else other``."""

    test: Expr
    then: Expr
    other: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Otherwise:
    """``expr otherwise fallback``: settles 0/0."""

    value: Expr
    fallback: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Argument:
    """An argument of a call; ``name`` is None when positional."""

    name: Name | None
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Call:
    """``max(a, b)``, ``danger(eta_t: x, eta_d: y)`` or, with ``field``, ``danger(..).ddc``."""

    callee: Name
    arguments: tuple[Argument, ...]
    field: Name | None
    span: Span


@dataclass(frozen=True, slots=True)
class Fold:
    """``max(body for item in list if test, otherwise fallback)``; kind is the callee's name."""

    kind: Name
    body: Expr
    item: Name
    over: Name
    test: Expr | None
    fallback: Expr | None
    span: Span


Expr = Number | Ref | Unary | Binary | Compare | InRange | Logic | Conditional | Otherwise | Call | Fold


# --- variables and terms ---------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Range:
    lo: Expr
    hi: Expr
    unit: UnitExpr | None
    span: Span


@dataclass(frozen=True, slots=True)
class RawClause:
    """``raw int16 step 0.01`` or ``raw uint16 0..4095``; counts may run backwards."""

    ctype: Name
    step: Expr | None
    counts: tuple[Expr, Expr] | None
    span: Span


@dataclass(frozen=True, slots=True)
class PlacedTerm:
    """A term of a partition; ``peak`` is None where the partition is even."""

    name: Name
    peak: Expr | None


@dataclass(frozen=True, slots=True)
class Partition:
    """``partition A B C [full]`` or ``partition A at 0, B at 2, C at 10 [full]``."""

    terms: tuple[PlacedTerm, ...]
    full: bool
    span: Span


@dataclass(frozen=True, slots=True)
class Singletons:
    """``singletons Z VS S`` evenly from the low to the high end, or with ``at``."""

    terms: tuple[PlacedTerm, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class TermDecl:
    """``term NAME = shape(args)``; ``points((x, y), ..)`` keeps its pairs flattened x, y, x, y.."""

    name: Name
    shape: Name
    arguments: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class OtherwiseClause:
    """``otherwise VALUE`` or ``otherwise hold initial VALUE`` of an output."""

    value: Expr
    hold: bool
    span: Span


Member = Partition | Singletons | TermDecl | OtherwiseClause


@dataclass(frozen=True, slots=True)
class VariableDecl:
    """One or several inputs or outputs of a controller that share a declaration."""

    kind: Literal["input", "output"]
    names: tuple[Name, ...]
    range: Range
    raw: RawClause | None
    members: tuple[Member, ...]
    span: Span


# --- rules -----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Is:
    """``input is [not] TERM`` or ``input in {A, B}`` (several terms)."""

    variable: Name
    terms: tuple[Name, ...]
    negated: bool
    span: Span


@dataclass(frozen=True, slots=True)
class Antecedent:
    """and, or, not over antecedents."""

    op: Literal["and", "or", "not"]
    operands: tuple[Condition, ...]
    span: Span


Condition = Is | Antecedent


@dataclass(frozen=True, slots=True)
class Consequent:
    output: Name
    term: Name
    span: Span


@dataclass(frozen=True, slots=True)
class Rule:
    condition: Condition
    consequents: tuple[Consequent, ...]
    weight: Expr | None
    span: Span


@dataclass(frozen=True, slots=True)
class BehaviorDecl:
    name: Name
    priority: Expr
    rules: tuple[Rule, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class RulesBlock:
    rules: tuple[Rule, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class TableRow:
    """Row labels (one per input but the last; none in a one-input table) and its entries.

    An entry names a term for each of the table's outputs: ``VF/Z`` is two names.
    """

    labels: tuple[Name, ...]
    entries: tuple[tuple[Name, ...], ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Table:
    """``table outputs by inputs { columns; rows }``.

    With one input, ``table u by e { N: S  Z: M }`` has no header: ``columns`` is empty and each row
    has one label (of the only input) and one entry. With more, the last input runs across:
    ``columns`` names its terms.
    """

    outputs: tuple[Name, ...]
    inputs: tuple[Name, ...]
    columns: tuple[Name, ...]
    rows: tuple[TableRow, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Setting:
    """``and = min`` inside ``infer``."""

    name: Name
    value: Name
    span: Span


@dataclass(frozen=True, slots=True)
class InferBlock:
    settings: tuple[Setting, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class FiresAt:
    value: Expr
    span: Span


# --- what a call may cost --------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Limit:
    """``flash <= 1 KiB on cortex-m0plus``; ``target`` is None where no machine is named."""

    quantity: Name
    op: Name
    value: Expr
    target: Name | None
    span: Span


@dataclass(frozen=True, slots=True)
class BudgetBlock:
    limits: tuple[Limit, ...]
    span: Span


ControllerItem = VariableDecl | Table | BehaviorDecl | RulesBlock | InferBlock | FiresAt | BudgetBlock


@dataclass(frozen=True, slots=True)
class ControllerDecl:
    name: Name
    items: tuple[ControllerItem, ...]
    span: Span


# --- systems ---------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Param:
    name: Name
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class SystemInput:
    name: Name
    range: Range
    raw: RawClause | None
    span: Span


@dataclass(frozen=True, slots=True)
class ListInput:
    name: Name
    capacity: Expr
    fields: tuple[SystemInput, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Let:
    """``let x = ..`` or, in a loop, ``let o.x = ..`` (``target`` has one or two parts)."""

    target: Ref
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class ForEach:
    item: Name
    over: Name
    body: tuple[Let, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class SystemOutput:
    """``output v [in [lo, hi] unit] [raw ..] = expr``."""

    name: Name
    range: Range | None
    raw: RawClause | None
    value: Expr
    span: Span


SystemItem = Param | SystemInput | ListInput | Let | ForEach | SystemOutput | BudgetBlock


@dataclass(frozen=True, slots=True)
class SystemDecl:
    name: Name
    items: tuple[SystemItem, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class UnitDecl:
    """``unit tick = 0.012 rad``."""

    name: Name
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Module:
    """A file: ``module NAME`` and its declarations; ``name`` is None where the line is missing."""

    name: Name | None
    items: tuple[ControllerDecl | SystemDecl | UnitDecl | Param, ...]
    span: Span
