"""The integer program: what is run by numpy and printed as C.

Every expression node carries the closed interval ``[lo, hi]`` that its value lies in for every input; the
constructors in
``fixed.build`` derive it, so an intermediate that could leave 32 bits cannot be built. Arithmetic nodes are
computed in ``uint32_t`` when neither an operand nor the result can be negative, else in ``int32_t``, or in a narrower
type that holds operands and result.
Nothing shifts or divides a negative.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from fuzzyspec.model.controller import Behavior
from fuzzyspec.model.variable import Variable

CType = Literal["uint8", "int8", "uint16", "int16", "uint32", "int32"]
Division = Literal["loop", "rounds", "unrolled", "newton", "reciprocal", "hardware"]
"""How the quotient kernel divides: bit by bit (in a loop, in rounds of four, or written out), or digit by digit (with a
reciprocal by Newton's method from a straight line or from a table, or with the machine's own division)."""
BinaryOp = Literal["+", "-", "*", "/", ">>", "<<", "&", "|", "^"]
CompareOp = Literal["<", "<=", ">", ">=", "==", "!="]

# --- expressions -----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Const:
    value: int

    @property
    def lo(self) -> int:
        return self.value

    @property
    def hi(self) -> int:
        return self.value


@dataclass(frozen=True, slots=True)
class Local:
    """A scalar local or a loop counter."""

    name: str
    ctype: CType
    lo: int
    hi: int


@dataclass(frozen=True, slots=True)
class Element:
    """An element of a local array or of a static const table."""

    array: str
    ctype: CType
    index: Expr
    lo: int
    hi: int
    table: bool


@dataclass(frozen=True, slots=True)
class ReadPort:
    """An input of the function, unsaturated: the interval is its C type's."""

    name: str
    ctype: CType
    lo: int
    hi: int


@dataclass(frozen=True, slots=True)
class ReadField:
    """A field of the current element of a list, unsaturated; only inside that list's ``Each``."""

    list: str
    field: str
    ctype: CType
    lo: int
    hi: int


@dataclass(frozen=True, slots=True)
class ReadState:
    """What a previous call stored; the interval is the legal raws (``init`` and ``SetState`` keep it)."""

    name: str
    ctype: CType
    lo: int
    hi: int


@dataclass(frozen=True, slots=True)
class Binary:
    """``/`` is floor division of non-negatives by a positive; ``>>`` and ``<<`` take non-negatives and a constant
    count."""

    op: BinaryOp
    left: Expr
    right: Expr
    lo: int
    hi: int


@dataclass(frozen=True, slots=True)
class Least:
    """min; both operands are atoms (Const or Local), so C may name them twice."""

    left: Expr
    right: Expr
    lo: int
    hi: int


@dataclass(frozen=True, slots=True)
class Greatest:
    """max; operands as in Least."""

    left: Expr
    right: Expr
    lo: int
    hi: int


@dataclass(frozen=True, slots=True)
class Above:
    """``left > right ? left - right : 0``; operands as in Least."""

    left: Expr
    right: Expr
    lo: int
    hi: int


@dataclass(frozen=True, slots=True)
class Select:
    """``test ? then : other``."""

    test: Test
    then: Expr
    other: Expr
    lo: int
    hi: int


@dataclass(frozen=True, slots=True)
class MulHigh:
    """``floor(left * right / 2**16)`` of a uint32 and a value of at most 2**16, without a 64-bit product.

    A kernel: C calls the static function ``<prefix>_mul_high(uint32_t, uint32_t)``.
    """

    left: Expr
    right: Expr
    lo: int
    hi: int


@dataclass(frozen=True, slots=True)
class Quotient:
    """``floor(num * 2**16 / den)`` for ``num < den < 2**31``, and 65536 where ``num >= den`` (so also for den = 0).

    A kernel: C calls a static function ``<prefix>_quotient(uint32_t, uint32_t)``, which one is told by ``by`` and the
    divisor's interval (``fixed.division``). The value is the same.
    """

    num: Expr
    den: Expr
    by: Division = "loop"
    lo: int = 0
    hi: int = 65536


Expr = (
    Const
    | Local
    | Element
    | ReadPort
    | ReadField
    | ReadState
    | Binary
    | Least
    | Greatest
    | Above
    | Select
    | MulHigh
    | Quotient
)


@dataclass(frozen=True, slots=True)
class Compare:
    """Both sides are compared as ``uint32_t`` when neither can be negative, else as ``int32_t``."""

    op: CompareOp
    left: Expr
    right: Expr


@dataclass(frozen=True, slots=True)
class AllOf:
    operands: tuple[Test, ...]


@dataclass(frozen=True, slots=True)
class AnyOf:
    operands: tuple[Test, ...]


@dataclass(frozen=True, slots=True)
class NotTest:
    operand: Test


Test = Compare | AllOf | AnyOf | NotTest

# --- statements ------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Comment:
    """A line for the reader of the C, before the statements that it speaks of."""

    text: str


@dataclass(frozen=True, slots=True)
class Define:
    """Declare and set a local. ``constant`` ones are never set again (``const`` in C)."""

    local: Local
    value: Expr
    constant: bool


@dataclass(frozen=True, slots=True)
class DefineArray:
    """A local array of ``size`` elements, each to be set before it is read (zeroed in the numpy model)."""

    name: str
    ctype: CType
    size: int


@dataclass(frozen=True, slots=True)
class Window:
    """``name[i]`` is ``table[start + i]`` of a static const table: in C a pointer, so that neighbours of one place are
    read with constant indices. Read by an ``Element`` of that name with ``table`` set."""

    name: str
    ctype: CType
    table: str
    start: Expr


@dataclass(frozen=True, slots=True)
class Assign:
    local: Local
    value: Expr


@dataclass(frozen=True, slots=True)
class AssignElement:
    array: str
    ctype: CType
    index: Expr
    value: Expr
    most: tuple[int, ...] = ()  # of each element, where they differ and the caller has a proof of it


@dataclass(frozen=True, slots=True)
class Loop:
    """``for (counter = 0; counter < count; ++counter)``; the counter is declared by the loop."""

    counter: Local
    count: int
    body: tuple[Stmt, ...]


@dataclass(frozen=True, slots=True)
class Each:
    """One pass over a list of the caller's: the first ``min(count, capacity)`` records.

    The list's overrun bit is set before the pass where the count exceeds the capacity.
    """

    list: str
    counter: Local
    body: tuple[Stmt, ...]


@dataclass(frozen=True, slots=True)
class Branch:
    test: Test
    then: tuple[Stmt, ...]
    other: tuple[Stmt, ...] = ()


@dataclass(frozen=True, slots=True)
class SetOutput:
    name: str
    value: Expr


@dataclass(frozen=True, slots=True)
class SetState:
    name: str
    value: Expr


@dataclass(frozen=True, slots=True)
class SetStatus:
    """Set a bit of the status that the function returns."""

    bit: str


@dataclass(frozen=True, slots=True)
class CallFunction:
    """Call another function of the module; its decisions are recorded under ``<id>.<key>``.

    ``arguments`` follow the callee's inputs and are legal raws; ``results`` are (callee output name, local that it
    is read
    into), declared by this statement. ``state`` names the callee's part of the caller's state, or None. ``held`` maps a
    status bit of the callee to the caller's bit that repeats it.
    """

    id: str
    callee: str
    arguments: tuple[Expr, ...]
    results: tuple[tuple[str, Local], ...]
    state: str | None
    held: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Record:
    """A decision under its key, for whoever compares the two meanings. Not printed in C.

    A test is recorded as 0 or 1, an expression as its value; inside ``Each`` there is one record an element.
    """

    key: str
    value: Expr | Test


Stmt = (
    Comment
    | Define
    | DefineArray
    | Window
    | Assign
    | AssignElement
    | Loop
    | Each
    | Branch
    | SetOutput
    | SetState
    | SetStatus
    | CallFunction
    | Record
)

# --- functions -------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Table:
    """A static const table."""

    name: str
    ctype: CType
    values: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Port:
    """A raw that enters or leaves: ``lo .. hi`` are its legal raws. ``variable`` is None for ``acting``."""

    name: str
    ctype: CType
    lo: int
    hi: int
    variable: Variable | None


@dataclass(frozen=True, slots=True)
class ListPort:
    name: str
    capacity: int
    fields: tuple[Port, ...]


@dataclass(frozen=True, slots=True)
class StatePort:
    """A number that survives the call; ``variable`` is the output that is held."""

    name: str
    ctype: CType
    initial: int
    lo: int
    hi: int
    variable: Variable


@dataclass(frozen=True, slots=True)
class StatusBit:
    """``name`` is upper case without prefix (``SATURATED_TARGET_BEARING``); ``meaning`` one line."""

    name: str
    meaning: str


@dataclass(frozen=True, slots=True)
class Function:
    """One C function.

    ``name`` is the model's name of the controller or system. ``status`` lists the bits in order (bit i is ``1 << i``).
    ``nested`` lists (state name, callee) of the called functions that hold a state. ``behaviors`` gives the codes of
    ``acting`` of a controller.
    """

    name: str
    kind: Literal["controller", "system"]
    inputs: tuple[Port | ListPort, ...]
    outputs: tuple[Port, ...]
    state: tuple[StatePort, ...]
    nested: tuple[tuple[str, str], ...]
    status: tuple[StatusBit, ...]
    tables: tuple[Table, ...]
    behaviors: tuple[Behavior, ...]
    body: tuple[Stmt, ...]


@dataclass(frozen=True, slots=True)
class Program:
    """A module's functions, callees before callers; ``name`` is the prefix of every symbol.

    ``narrow``: the C computes in as few bits as hold operands and result, instead of always in 32. The value is the
    same.
    """

    name: str
    functions: tuple[Function, ...]
    narrow: bool = False

    def function(self, name: str) -> Function:
        return next(f for f in self.functions if f.name == name)
