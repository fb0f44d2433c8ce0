"""The one printer of C expressions: precedence-aware and typed.

Arithmetic is done in ``uint32_t`` or ``int32_t``, never left to the promotion of narrower types, because ``int`` may
have 16 bits. Where the program asks for it, it is done in the narrowest type that holds operands and result
(``ctypes.arithmetic``); then C promotes the operands to ``int``, which cannot overflow as the result fits, and the
result is cast back before it meets another type. Both operands of an operator are of one signedness (MISRA C:2012
rule 10.4), what is not of the type that a place wants is cast (rules 10.3, 10.6), and never is an operation's result
cast to a wider type than it was computed in (rule 10.8). A ``U`` literal has 16 or 32 bits, as it needs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import assert_never

from fuzzyspec.emit.ctypes import arithmetic, holds, of_width, signed, spelled, width
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
    """An expression in C: what it says, how it binds and the type of its value.

    ``promoted``: C computes it in ``int`` or ``unsigned``, which may be wider; ``unsigned``: in the latter everywhere.
    """

    text: str
    level: Level
    ctype: CType
    literal: bool = False
    promoted: bool = False
    unsigned: bool = False


@dataclass(frozen=True)
class Spelling:
    """How the names of a program are written in one C function.

    ``ports``, ``state`` and ``fields`` give whole lvalues (``in->eta_t``, ``state->duty``, ``obstacle->distance``).
    ``read`` leads the macros that read tables (``NAV_READ``). ``narrow`` asks for the narrowest arithmetic.
    """

    locals: Mapping[str, str]
    tables: Mapping[str, str]
    ports: Mapping[str, str]
    state: Mapping[str, str]
    fields: Mapping[tuple[str, str], str]
    read: str
    mul_high: str
    quotients: Mapping[Kernel, str]
    narrow: bool


def literal(value: int, is_signed: bool) -> Text:
    """An integer constant with the type that C gives it where ``int`` has 16 bits."""
    if not is_signed:
        if value < 0:
            raise AssertionError("a negative constant where the intervals allow none")
        return Text(f"{value}U", Level.ATOM, "uint16" if value <= 65535 else "uint32", literal=True, unsigned=True)
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
    if signed(value.ctype) == signed(ctype):
        if value.literal and value.promoted:
            return (value if width(ctype) == 32 else cast(value, ctype)).text
        return (_settled(value) if width(value.ctype) <= width(ctype) else cast(value, ctype)).text
    return cast(value if width(ctype) <= width(value.ctype) else _settled(value), ctype).text


def _settled(value: Text) -> Text:
    """The value in its own type."""
    return cast(value, value.ctype) if value.promoted else value


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
    """The expression with the signedness of ``ctype``; it may be narrower, and is not wider in narrow arithmetic."""
    if isinstance(expr, Const):
        return literal(expr.value, signed(ctype))
    value = _value(expr, names)
    bits = width(value.ctype)
    if names.narrow and bits > width(ctype):
        return cast(value, ctype)
    if signed(value.ctype) == signed(ctype):
        return value
    if signed(ctype):
        return cast(_settled(value), ctype)
    # By way of the unsigned type of its width: of a wider cast gcc warns where it knows the value.
    return cast(_settled(value), of_width(False, bits))


def _factor(expr: Expr, ctype: CType, names: Spelling) -> Text:
    """A factor of a product of 32 bits: in narrow arithmetic of 16 where it has no more, for then one short
    multiplication does."""
    if names.narrow and not isinstance(expr, Const):
        half = of_width(signed(ctype), 16)
        return _operand(expr, half if holds(half, expr.lo, expr.hi) else ctype, names)
    return _operand(expr, ctype, names)


def _interval(expr: Expr) -> tuple[int, int]:
    return expr.lo, expr.hi


def _binary(expr: Binary, names: Spelling) -> Text:
    level = _OPERATORS[expr.op]
    if expr.op in ("<<", ">>"):
        return _shift(expr, level, names)
    if expr.op == "/" and (expr.left.lo < 0 or expr.right.lo < 1):
        raise AssertionError("only non-negative values are divided, by positive ones")
    narrow = names.narrow and not _is_complement(expr)
    ctype = arithmetic(narrow, *(_interval(e) for e in (expr.left, expr.right, expr)))
    if width(ctype) == 8 and not signed(ctype) and any(map(_is_cut, (expr.left, expr.right))):
        ctype = "uint16"
    operand = _factor if expr.op == "*" and width(ctype) == 32 else _operand
    left, right = _together(operand(expr.left, ctype, names), operand(expr.right, ctype, names), ctype)
    chained = left.level == level and expr.op in ("+", "-", "*") and (level == Level.ADD or _is_product(expr.left))
    text = f"{left.text if chained else _wrapped(left)} {expr.op} {_wrapped(right)}"
    return Text(text, level, ctype, promoted=width(ctype) < 32, unsigned=left.unsigned or right.unsigned)


def _shift(expr: Binary, level: Level, names: Spelling) -> Text:
    if expr.left.lo < 0 or not isinstance(expr.right, Const) or not 0 <= expr.right.value < 32:
        raise AssertionError("only non-negative values are shifted, by constants below 32")
    # MISRA C:2012 rule 12.2: the count stays below the width, so the type holds 2**count too.
    ctype = arithmetic(names.narrow, _interval(expr.left), _interval(expr), (0, 1 << expr.right.value))
    left = _operand(expr.left, ctype, names)
    if width(left.ctype) < width(ctype):
        left = cast(_settled(left), ctype)
    text = f"{_wrapped(left)} {expr.op} {expr.right.value}U"
    return Text(text, level, ctype, promoted=width(ctype) < 32, unsigned=left.unsigned)


def _together(left: Text, right: Text, ctype: CType) -> tuple[Text, Text]:
    """Two operands such that C computes in the type, or in ``int`` or ``unsigned`` what fits the type."""
    left, right = _ready(left, right, ctype), _ready(right, left, ctype)
    if width(left.ctype) < width(ctype) and width(right.ctype) < width(ctype):
        if left.literal and not right.literal:
            right = cast(right, ctype)
        else:
            left = cast(left, ctype)
    return left, right


def _ready(value: Text, other: Text, ctype: CType) -> Text:
    """The operand, cast to its type unless it may stay promoted: what C computed in ``int`` must not meet
    ``unsigned``, of which clang and gcc warn."""
    return value if value.ctype == ctype and (value.unsigned or not other.unsigned) else _settled(value)


def _is_product(expr: Expr) -> bool:
    return isinstance(expr, Binary) and expr.op == "*"


def _wrapped(value: Text) -> str:
    """As an operand: every operator below a cast stands in parentheses (MISRA C:2012 rule 12.1)."""
    return f"({value.text})" if value.level < Level.UNARY or value.text.startswith("-") else value.text


def _either(test: Test, then: Expr, other: Expr, whole: Expr, names: Spelling) -> Text:
    """A choice of non-negative value is unsigned, though the arm that is not taken could be negative: gcc doubts the
    sign where the whole is cast instead of its arms."""
    ctype: CType = "uint32" if whole.lo >= 0 else arithmetic(names.narrow, _interval(then), _interval(other))
    left, right = _settled(_operand(then, ctype, names)), _settled(_operand(other, ctype, names))
    bits = max(8 if arm.literal else width(arm.ctype) for arm in (left, right))
    while not holds(of_width(signed(ctype), bits), whole.lo, whole.hi) and bits < 32:
        bits *= 2
    text = f"{_wrapped(_test(test, names))} ? {_wrapped(left)} : {_wrapped(right)}"
    # Of two constants gcc makes a comparison, which is an int.
    fixed = left.literal and right.literal
    found = of_width(signed(ctype), bits)
    return Text(text, Level.CONDITIONAL, found, literal=fixed, promoted=fixed, unsigned=fixed and not signed(ctype))


def _call(function: str, left: Expr, right: Expr, names: Spelling) -> Text:
    arguments = ", ".join(stored(e, "uint32", names) for e in (left, right))
    return Text(f"{function}({arguments})", Level.ATOM, "uint32")


def _element(expr: Element, names: Spelling) -> Text:
    place = subscript(expr.index, names)
    if expr.table:
        # A table, or a window into one.
        array = names.tables[expr.array] if expr.array in names.tables else names.locals[expr.array]
        return Text(f"{reader_name(names.read, expr.ctype)}({array}, {place})", Level.ATOM, expr.ctype)
    return Text(f"{names.locals[expr.array]}[{place}]", Level.ATOM, expr.ctype)


def subscript(expr: Expr, names: Spelling) -> str:
    """An expression between brackets."""
    if expr.lo < 0:
        raise AssertionError("an index is not negative")
    return _operand(expr, "uint32", names).text


def element(array: str, place: Expr, names: Spelling) -> str:
    """An element of a local array as an lvalue."""
    return f"{names.locals[array]}[{subscript(place, names)}]"


def _test(test: Test, names: Spelling) -> Text:
    match test:
        case Compare():
            narrow = names.narrow and not any(_is_complement(side) for side in (test.left, test.right))
            ctype = arithmetic(narrow, _interval(test.left), _interval(test.right))
            # From 16 bits to 8 a cast would cost the reader more than it saves.
            wanted = of_width(signed(ctype), max(16, width(ctype)))
            left, right = (_operand(side, wanted, names) for side in (test.left, test.right))
            left, right = (
                _ready(side, other, side.ctype if other.literal else other.ctype)
                for side, other in ((left, right), (right, left))
            )
            operator_right = right.text if right.literal and right.level == Level.UNARY else _wrapped(right)
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


def _is_complement(expr: Expr) -> bool:
    """What gcc takes for ``~x``, and warns of where it is compared, unless in 32 bits."""
    return isinstance(expr, Binary) and expr.op == "-" and expr.left in (Const(255), Const(65535))


def _is_cut(expr: Expr) -> bool:
    """What avr-gcc, where it is cast to 8 bits, takes for an ``int``, and warns of its meeting ``unsigned``."""
    return isinstance(expr, Binary) and expr.op == ">>" and max(expr.left.hi, 1 << expr.right.hi) > 255


def _joined(operator: str, level: Level, operands: tuple[Test, ...], names: Spelling) -> Text:
    return Text(f" {operator} ".join(_wrapped(_test(t, names)) for t in operands), level, "uint8")
