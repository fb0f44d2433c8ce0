"""The one printer of C expressions: precedence-aware and typed.

Arithmetic is done in ``uint32_t`` or ``int32_t`` (``ctypes.word``), never left to the promotion of narrower types,
because ``int`` may have 16 bits. Both operands of an operator are of one signedness (MISRA C:2012 rule 10.4), and what
is not of the type that a place wants is cast (rules 10.3, 10.6). A ``U`` literal has 16 or 32 bits, as it needs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import assert_never

from fuzzyspec.emit.ctypes import holds, of_width, signed, spelled, width, word
from fuzzyspec.fixed.division import Kernel, kernel_of
from fuzzyspec.fixed.program import (
    Above,
    AllOf,
    AnyOf,
    Binary,
    Compare,
    CompareOp,
    Const,
    CType,
    Element,
    Expr,
    Greatest,
    Least,
    Local,
    MulHigh,
    NotTest,
    Quotient,
    ReadField,
    ReadPort,
    ReadState,
    Select,
    Test,
)


class Level(IntEnum):
    """How tightly C binds."""

    CONDITIONAL = 1
    OR = 2
    AND = 3
    BITS = 4
    COMPARE = 5
    SHIFT = 6
    ADD = 7
    MULTIPLY = 8
    UNARY = 9
    ATOM = 10


_OPERATORS: dict[str, Level] = {
    "+": Level.ADD,
    "-": Level.ADD,
    "*": Level.MULTIPLY,
    "/": Level.MULTIPLY,
    "<<": Level.SHIFT,
    ">>": Level.SHIFT,
    "&": Level.BITS,
    "|": Level.BITS,
    "^": Level.BITS,
}

_OPPOSITE: dict[CompareOp, CompareOp] = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}


@dataclass(frozen=True, slots=True)
class Text:
    """An expression in C: what it says, how it binds and the type of its value."""

    text: str
    level: Level
    ctype: CType
    literal: bool = False


@dataclass(frozen=True)
class Spelling:
    """How the names of a program are written in one C function.

    ``ports``, ``state`` and ``fields`` give whole lvalues (``in->eta_t``, ``state->duty``, ``obstacle->distance``).
    ``read`` leads the macros that read tables (``NAV_READ``).
    """

    locals: Mapping[str, str]
    tables: Mapping[str, str]
    ports: Mapping[str, str]
    state: Mapping[str, str]
    fields: Mapping[tuple[str, str], str]
    read: str
    mul_high: str
    quotients: Mapping[Kernel, str]


def literal(value: int, is_signed: bool) -> Text:
    """An integer constant with the type that C gives it where ``int`` has 16 bits."""
    if not is_signed:
        if value < 0:
            raise AssertionError("a negative constant where the intervals allow none")
        return Text(f"{value}U", Level.ATOM, "uint16" if value <= 65535 else "uint32", literal=True)
    ctype: CType = "int16" if -32767 <= value <= 32767 else "int32"
    if value == -(2**31):
        return Text("INT32_MIN", Level.ATOM, ctype, literal=True)
    return Text(str(value), Level.ATOM if value >= 0 else Level.UNARY, ctype, literal=True)


def reader_name(read: str, ctype: CType) -> str:
    """The macro that reads a table of this type: ``NAV_READ_U16``."""
    return f"{read}_{'S' if signed(ctype) else 'U'}{width(ctype)}"


def cast(value: Text, ctype: CType) -> Text:
    """The value converted to a type."""
    inner = f"({value.text})" if value.level < Level.UNARY or value.text.startswith("-") else value.text
    return Text(f"({spelled(ctype)}){inner}", Level.UNARY, ctype)


def stored(expr: Expr, ctype: CType, names: Spelling) -> str:
    """The (settled) expression where a value of ``ctype`` is wanted: an initialiser, an assignment."""
    if isinstance(expr, Const):
        return literal(expr.value, signed(ctype)).text
    return converted(_value(expr, names), ctype)


def converted(value: Text, ctype: CType) -> str:
    """Cast unless the type widens the value's own."""
    if signed(value.ctype) == signed(ctype) and width(value.ctype) <= width(ctype):
        return value.text
    return cast(value, ctype).text


def condition(test: Test, names: Spelling) -> str:
    """The test as a controlling expression; it is not one that the intervals decide."""
    return _test(test, names).text


def _value(expr: Expr, names: Spelling) -> Text:
    match expr:
        case Const():
            return literal(expr.value, expr.value < 0)
        case Local():
            return Text(names.locals[expr.name], Level.ATOM, expr.ctype)
        case Element():
            return _element(expr, names)
        case ReadPort():
            return Text(names.ports[expr.name], Level.ATOM, expr.ctype)
        case ReadField():
            return Text(names.fields[expr.list, expr.field], Level.ATOM, expr.ctype)
        case ReadState():
            return Text(names.state[expr.name], Level.ATOM, expr.ctype)
        case Binary():
            return _binary(expr, names)
        case Least():
            return _either(Compare("<", expr.left, expr.right), expr.left, expr.right, expr, names)
        case Greatest():
            return _either(Compare(">", expr.left, expr.right), expr.left, expr.right, expr, names)
        case Above():
            difference = Binary("-", expr.left, expr.right, min(expr.left.lo, expr.right.lo, 0), expr.hi)
            if expr.left.lo >= 0 and expr.right.lo >= 0:
                difference = Binary("-", expr.left, expr.right, 0, expr.hi)
            return _either(Compare(">", expr.left, expr.right), difference, Const(0), expr, names)
        case Select():
            return _either(expr.test, expr.then, expr.other, expr, names)
        case MulHigh():
            return _call(names.mul_high, expr.left, expr.right, names)
        case Quotient():
            return _call(names.quotients[kernel_of(expr)], expr.num, expr.den, names)
        case _:
            assert_never(expr)


def _operand(expr: Expr, ctype: CType, names: Spelling) -> Text:
    """The expression with the signedness of ``ctype``; it may be narrower."""
    if isinstance(expr, Const):
        return literal(expr.value, signed(ctype))
    value = _value(expr, names)
    if signed(value.ctype) == signed(ctype):
        return value
    if signed(ctype):
        return cast(value, ctype)
    # By way of the unsigned type of its width: of a wider cast gcc warns where it knows the value.
    return cast(value, of_width(False, width(value.ctype)))


def _interval(expr: Expr) -> tuple[int, int]:
    return expr.lo, expr.hi


def _binary(expr: Binary, names: Spelling) -> Text:
    level = _OPERATORS[expr.op]
    if expr.op in ("<<", ">>"):
        if expr.left.lo < 0 or not isinstance(expr.right, Const) or not 0 <= expr.right.value < 32:
            raise AssertionError("only non-negative values are shifted, by constants below 32")
        word(_interval(expr.left), _interval(expr))
        left = _widened(_operand(expr.left, "uint32", names), "uint32")
        return Text(f"{_wrapped(left)} {expr.op} {expr.right.value}U", level, "uint32")
    if expr.op == "/" and (expr.left.lo < 0 or expr.right.lo < 1):
        raise AssertionError("only non-negative values are divided, by positive ones")
    ctype = word(_interval(expr.left), _interval(expr.right), _interval(expr))
    left, right = _operand(expr.left, ctype, names), _operand(expr.right, ctype, names)
    if width(left.ctype) < 32 and width(right.ctype) < 32:
        if left.literal and not right.literal:
            right = cast(right, ctype)
        else:
            left = cast(left, ctype)
    chained = left.level == level and expr.op in ("+", "-", "*") and (level == Level.ADD or _is_product(expr.left))
    return Text(f"{left.text if chained else _wrapped(left)} {expr.op} {_wrapped(right)}", level, ctype)


def _is_product(expr: Expr) -> bool:
    return isinstance(expr, Binary) and expr.op == "*"


def _widened(value: Text, ctype: CType) -> Text:
    return value if width(value.ctype) == 32 else cast(value, ctype)


def _wrapped(value: Text) -> str:
    """As an operand: every operator below a cast stands in parentheses (MISRA C:2012 rule 12.1)."""
    return f"({value.text})" if value.level < Level.UNARY or value.text.startswith("-") else value.text


def _either(test: Test, then: Expr, other: Expr, whole: Expr, names: Spelling) -> Text:
    """A choice of non-negative value is unsigned, though the arm that is not taken could be negative: gcc doubts the
    sign where the whole is cast instead of its arms."""
    ctype: CType = "uint32" if whole.lo >= 0 else word(_interval(then), _interval(other))
    left, right = _operand(then, ctype, names), _operand(other, ctype, names)
    bits = max(8 if arm.literal else width(arm.ctype) for arm in (left, right))
    while not holds(of_width(signed(ctype), bits), whole.lo, whole.hi) and bits < 32:
        bits *= 2
    text = f"{_wrapped(_test(test, names))} ? {_wrapped(left)} : {_wrapped(right)}"
    return Text(text, Level.CONDITIONAL, of_width(signed(ctype), bits))


def _call(function: str, left: Expr, right: Expr, names: Spelling) -> Text:
    word(_interval(left), _interval(right), (0, 0))
    arguments = ", ".join(stored(e, "uint32", names) for e in (left, right))
    return Text(f"{function}({arguments})", Level.ATOM, "uint32")


def _element(expr: Element, names: Spelling) -> Text:
    if expr.index.lo < 0:
        raise AssertionError("an index is not negative")
    index = _operand(expr.index, "uint32", names).text
    if expr.table:
        return Text(
            f"{reader_name(names.read, expr.ctype)}({names.tables[expr.array]}, {index})", Level.ATOM, expr.ctype
        )
    return Text(f"{names.locals[expr.array]}[{index}]", Level.ATOM, expr.ctype)


def element(array: str, index: Expr, names: Spelling) -> str:
    """An element of a local array as an lvalue."""
    return f"{names.locals[array]}[{_operand(index, 'uint32', names).text}]"


def _test(test: Test, names: Spelling) -> Text:
    match test:
        case Compare():
            ctype = word(_interval(test.left), _interval(test.right))
            left, right = _operand(test.left, ctype, names), _operand(test.right, ctype, names)
            operator_right = right.text if right.literal else _wrapped(right)
            return Text(f"{_wrapped(left)} {test.op} {operator_right}", Level.COMPARE, "uint8")
        case AllOf():
            return _joined("&&", Level.AND, test.operands, names)
        case AnyOf():
            return _joined("||", Level.OR, test.operands, names)
        case NotTest(Compare() as compare):
            return _test(Compare(_OPPOSITE[compare.op], compare.left, compare.right), names)
        case NotTest():
            return Text(f"!{_wrapped(_test(test.operand, names))}", Level.UNARY, "uint8")
        case _:
            assert_never(test)


def _joined(operator: str, level: Level, operands: tuple[Test, ...], names: Spelling) -> Text:
    return Text(f" {operator} ".join(_wrapped(_test(t, names)) for t in operands), level, "uint8")
