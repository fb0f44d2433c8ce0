"""What a block does, counted: operations by kind and width. No machine is known here.

A feature is a name, ``add.16``: what is done, and the bits that its operands and its result need (of the C type for
what lies in memory). A machine's weights may be by name, or by what stands before the point where widths cost it the
same.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import assert_never

from fuzzyspec.fixed.build import smallest_type
from fuzzyspec.fixed.division import kernel_of
from fuzzyspec.fixed.program import (
    Above,
    AllOf,
    AnyOf,
    Assign,
    AssignElement,
    Binary,
    Branch,
    CallFunction,
    Comment,
    Compare,
    Const,
    CType,
    Define,
    DefineArray,
    Each,
    Element,
    Expr,
    Greatest,
    Least,
    Local,
    Loop,
    MulHigh,
    NotTest,
    Quotient,
    ReadField,
    ReadPort,
    ReadState,
    Record,
    Select,
    SetOutput,
    SetState,
    SetStatus,
    Stmt,
    Test,
    Window,
)

Features = Mapping[str, float]

SHORT_CONSTANT = 255
"""What a Thumb instruction holds at once; a larger constant is loaded, or made in two steps."""


def add(into: dict[str, float], features: Features, times: float = 1.0) -> None:
    """Add features that occur so many times."""
    for name, count in features.items():
        into[name] = into.get(name, 0.0) + count * times


def bits_of(ctype: CType) -> int:
    """The bits of a C type."""
    return int(ctype.removeprefix("u").removeprefix("int"))


def of_statement(statement: Stmt) -> Counter[str]:
    """The features of one statement, without the blocks inside it: those are told by how often they are entered."""
    found: Counter[str] = Counter()
    match statement:
        case Define(local, value, _) | Assign(local, value):
            _expr(value, found)
            _stored(value, bits_of(local.ctype), found)
            if isinstance(value, Const | Local):
                found[f"set.{bits_of(local.ctype)}"] += 1
        case AssignElement(_, ctype, index, value):
            _expr(value, found)
            _stored(value, bits_of(ctype), found)
            _place("put", ctype, index, found)
        case Branch(test, _, other):
            _test(test, found)
            found["branch"] += 1
            if other:
                found["otherwise"] += 1
        case Loop():
            found["loop"] += 1
        case Each():
            found["list"] += 1
        case SetOutput(_, value):
            _expr(value, found)
            found[f"output.{_bits(value)}"] += 1
        case SetState(_, value):
            _expr(value, found)
            found[f"output.{_bits(value)}"] += 1
        case SetStatus():
            found["status"] += 1
        case CallFunction(arguments=arguments, results=results, held=held):
            found["call"] += 1
            for argument in arguments:
                _expr(argument, found)
                found["argument"] += 1
            for _, local in results:
                found[f"port.{bits_of(local.ctype)}"] += 1
            found["branch"] += len(held)
        case Window(start=start):
            _expr(start, found)
            found["window"] += 1
        case Comment() | Record() | DefineArray():
            pass
        case _:
            assert_never(statement)
    return +found


def _bits(*values: Expr) -> int:
    """The bits that hold all of the values."""
    lo, hi = min(v.lo for v in values), max(v.hi for v in values)
    return bits_of(smallest_type(lo, hi)) if lo >= 0 or hi < 2**31 else 32


def _stored(value: Expr, bits: int, found: Counter[str]) -> None:
    """C computes in 32 bits, so a narrower place needs a cast."""
    if bits < 32 and isinstance(value, Binary) and value.op not in (">>", "/", "&"):
        found["narrow"] += 1


def _place(what: str, ctype: CType, index: Expr, found: Counter[str]) -> None:
    """An element at a known place is a plain variable to a compiler."""
    if isinstance(index, Const):
        found[f"{what}_at.{bits_of(ctype)}"] += 1
        return
    _expr(index, found)
    found[f"{what}.{bits_of(ctype)}"] += 1
    if bits_of(ctype) > 8:
        found["scaled"] += 1


def _constant(expr: Expr, found: Counter[str]) -> None:
    if isinstance(expr, Const):
        if abs(expr.value) > SHORT_CONSTANT:
            found["constant"] += 1
    else:
        _expr(expr, found)


def _expr(expr: Expr, found: Counter[str]) -> None:
    match expr:
        case Const():
            _constant(expr, found)
        case Local():
            pass
        case Element(_, ctype, index, _, _, table):
            _place("table" if table else "get", ctype, index, found)
        case ReadPort(_, ctype) | ReadState(_, ctype):
            found[f"port.{bits_of(ctype)}"] += 1
        case ReadField(_, _, ctype):
            found[f"field.{bits_of(ctype)}"] += 1
        case Binary():
            _binary(expr, found)
        case Least(left, right) | Greatest(left, right):
            _compared(left, right, found)
            found[f"pick.{_bits(left, right)}"] += 1
        case Above(left, right):
            _compared(left, right, found)
            found[f"add.{_bits(left, right)}"] += 1
            found[f"pick.{_bits(left, right)}"] += 1
        case Select(test, then, other):
            _test(test, found)
            _constant(then, found)
            _constant(other, found)
            found[f"pick.{_bits(then, other)}"] += 1
        case MulHigh(left, right):
            _constant(left, found)
            _constant(right, found)
            found["mul_high"] += 1
        case Quotient(num, den):
            _constant(num, found)
            _constant(den, found)
            kernel = kernel_of(expr)
            found[f"quotient_{kernel.by}.{kernel.digit_bits}"] += 1
            found["quotient_steps"] += len(kernel.steps)
        case _:
            assert_never(expr)


def _binary(expr: Binary, found: Counter[str]) -> None:
    left, right = expr.left, expr.right
    bits = _bits(left, right, expr)
    match expr.op:
        case "<<" | ">>":
            assert isinstance(right, Const)
            _expr(left, found)
            _shift(right.value, bits, found)
            return
        case "*" if isinstance(right, Const) and right.value > 0 and right.value & (right.value - 1) == 0:
            _expr(left, found)
            _shift(right.value.bit_length() - 1, bits, found)
            return
        case "*":
            factors = _bits(left, right)
            kind = "multiply_wide" if factors < bits else "multiply"
            found[f"{kind}.{factors}"] += 1
        case "/":
            found["divide"] += 1
        case "+" | "-":
            found[f"add.{bits}"] += 1
        case "&" | "|" | "^":
            found[f"bits.{bits}"] += 1
        case _:
            assert_never(expr.op)
    _constant(left, found)
    _constant(right, found)


def _shift(count: int, bits: int, found: Counter[str]) -> None:
    """Whole bytes are moved by an 8-bit machine, the rest is shifted bit by bit."""
    found[f"shift.{bits}"] += 1
    found[f"shifted_bits.{bits}"] += min(count % 8, 2 + (8 - count % 8))


def _compared(left: Expr, right: Expr, found: Counter[str]) -> None:
    _constant(left, found)
    _constant(right, found)
    found[f"compare.{_bits(left, right)}"] += 1


def _test(test: Test, found: Counter[str]) -> None:
    """Of several operands the later ones count like the first: a compiler may compute them all."""
    match test:
        case Compare(_, left, right):
            _compared(left, right, found)
        case AllOf(operands) | AnyOf(operands):
            for operand in operands:
                _test(operand, found)
            found["branch"] += len(operands) - 1
        case NotTest(operand):
            _test(operand, found)
        case _:
            assert_never(test)
