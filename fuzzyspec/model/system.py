"""A checked system: crisp arithmetic, lists and controllers calling controllers.

Every expression's value is in coherent units (``Unit.to_coherent``), exact rationals throughout; the only conversions
are at ``ReadInput``/``ReadField``/``CallOutput`` and at the places that take a value (arguments, outputs). Every node
that decides carries a ``key``, unique within its system, under which both meanings report the decision.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.model.budget import Budget
from fuzzyspec.model.controller import Controller
from fuzzyspec.model.variable import Variable


@dataclass(frozen=True, slots=True)
class Const:
    value: Fraction


@dataclass(frozen=True, slots=True)
class ReadInput:
    """A system input."""

    name: str


@dataclass(frozen=True, slots=True)
class ReadField:
    """A field of the current element; only inside that list's loop or fold."""

    list: str
    field: str


@dataclass(frozen=True, slots=True)
class ReadLet:
    """A ``let``; ``list`` names the loop's list for ``let o.x``, else None."""

    name: str
    list: str | None


@dataclass(frozen=True, slots=True)
class CallOutput:
    """Output ``output`` of the call whose id is ``call``."""

    call: str
    output: str


@dataclass(frozen=True, slots=True)
class Add:
    left: Expr
    right: Expr


@dataclass(frozen=True, slots=True)
class Sub:
    left: Expr
    right: Expr


@dataclass(frozen=True, slots=True)
class Mul:
    left: Expr
    right: Expr


@dataclass(frozen=True, slots=True)
class Neg:
    operand: Expr


@dataclass(frozen=True, slots=True)
class Div:
    """Quotient.

    ``into`` is the ranged place it goes straight into (coherent units; the result saturates there), or None where the
    divisor's range does not hold 0. ``x/0`` is the end of ``into`` on x's side, the sign taken as the divisor comes to
    0 from inside its range; 0/0 is ``otherwise`` (a decision under ``key``: True where it was 0/0).
    """

    left: Expr
    right: Expr
    into: tuple[Fraction, Fraction] | None
    otherwise: Expr | None
    key: str
    span: Span


@dataclass(frozen=True, slots=True)
class Least:
    """min of two or more."""

    operands: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Greatest:
    """max of two or more."""

    operands: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Clamp:
    operand: Expr
    lo: Fraction
    hi: Fraction


@dataclass(frozen=True, slots=True)
class Abs:
    operand: Expr


@dataclass(frozen=True, slots=True)
class If:
    test: Test
    then: Expr
    other: Expr


@dataclass(frozen=True, slots=True)
class Fold:
    """Over the elements of ``list`` that pass ``test``.

    max and min take ``otherwise`` when none passes; sum and count of none are 0. ``body`` is None for count.
    """

    kind: Literal["max", "min", "sum", "count"]
    list: str
    body: Expr | None
    test: Test | None
    otherwise: Expr | None


Expr = (
    Const
    | ReadInput
    | ReadField
    | ReadLet
    | CallOutput
    | Add
    | Sub
    | Mul
    | Neg
    | Div
    | Least
    | Greatest
    | Clamp
    | Abs
    | If
    | Fold
)


CompareOp = Literal["<", "<=", ">", ">=", "==", "!="]


@dataclass(frozen=True, slots=True)
class Compare:
    """A decision, recorded under ``key``. ``x in [a, b]`` and chains are ``Both`` of these."""

    op: CompareOp
    left: Expr
    right: Expr
    key: str
    span: Span


@dataclass(frozen=True, slots=True)
class Both:
    operands: tuple[Test, ...]


@dataclass(frozen=True, slots=True)
class Either:
    operands: tuple[Test, ...]


@dataclass(frozen=True, slots=True)
class Neither:
    """not."""

    operand: Test


Test = Compare | Both | Either | Neither


@dataclass(frozen=True, slots=True)
class Let:
    name: str
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Call:
    """A controller called once a step (or once an element).

    ``id`` is unique in the system; it is the name of the ``let`` it is bound to, else ``<controller>_<n>``.
    ``arguments`` follow the controller's input order, each saturated to that input's range and rounded to its raw. The
    decisions of the call are recorded under ``<id>.fires.<output>`` and ``<id>.acting``.
    """

    id: str
    controller: Controller
    arguments: tuple[Expr, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class ForEach:
    """One pass over a list, in order; ``let`` names are ``o.<name>``."""

    list: str
    body: tuple[Let | Call, ...]
    span: Span


Statement = Let | Call | ForEach


@dataclass(frozen=True, slots=True)
class ListInput:
    """At most ``capacity`` records; ``fields`` in declared order."""

    name: str
    capacity: int
    fields: tuple[Variable, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class SystemOutput:
    """A number that leaves the step.

    ``bare`` is (call id, output) where the value is a controller's output handed on: it keeps that raw. ``saturates``
    is True where the range was declared and the value's own interval is not inside it (a status bit then tells).
    """

    variable: Variable
    value: Expr
    bare: tuple[str, str] | None
    saturates: bool

    @property
    def name(self) -> str:
        return self.variable.name


@dataclass(frozen=True, slots=True)
class ActingOutput:
    """``output acting = drive.acting``: a uint8 code, 0 where nothing fires."""

    name: str
    call: str
    span: Span


@dataclass(frozen=True, slots=True)
class System:
    """Statements are in dependency order. ``inputs`` are in declared order, scalars and lists mixed."""

    name: str
    inputs: tuple[Variable | ListInput, ...]
    statements: tuple[Statement, ...]
    outputs: tuple[SystemOutput | ActingOutput, ...]
    span: Span
    budgets: tuple[Budget, ...] = ()
    """What a step may cost."""

    @property
    def calls(self) -> tuple[Call, ...]:
        """Every call, in order, those inside loops included."""
        found: list[Call] = []
        for s in self.statements:
            if isinstance(s, Call):
                found.append(s)
            elif isinstance(s, ForEach):
                found.extend(b for b in s.body if isinstance(b, Call))
        return tuple(found)

    @property
    def holds(self) -> bool:
        return any(c.controller.holds for c in self.calls)


@dataclass(frozen=True, slots=True)
class Module:
    """A checked file. ``controllers`` come before the systems that call them, both in declared order."""

    name: str
    controllers: tuple[Controller, ...]
    systems: tuple[System, ...]

    def budgets(self, function: str) -> tuple[Budget, ...]:
        """What a call of a controller or system may cost; nothing is said of other functions."""
        found = {c.name: c.budgets for c in self.controllers} | {s.name: s.budgets for s in self.systems}
        return found.get(function, ())
