"""Choices that the intervals decide: C must not compare what can only come out one way."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import assert_never

from fuzzyspec.fixed.program import (
    Above,
    AllOf,
    AnyOf,
    Binary,
    Compare,
    CompareOp,
    Const,
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


def decided(test: Test) -> bool | None:
    """The outcome for every input, or None where it depends on the input."""
    match test:
        case Compare():
            return _compare(test)
        case AllOf():
            outcomes = [decided(t) for t in test.operands]
            if False in outcomes or not _can_hold(test.operands):
                return False
            return None if None in outcomes else True
        case AnyOf():
            outcomes = [decided(t) for t in test.operands]
            if True in outcomes or not _can_hold(tuple(NotTest(t) for t in test.operands)):
                return True
            return None if None in outcomes else False
        case NotTest():
            outcome = decided(test.operand)
            return None if outcome is None else not outcome
        case _:
            assert_never(test)


def _can_hold(tests: tuple[Test, ...]) -> bool:
    """Whether comparisons with constants leave a value at which all hold: ``x < 2`` and ``x > 3`` do not."""
    left_over: dict[Expr, tuple[int, int]] = {}
    for value, op, bound in sorted(_bounds(tests), key=_unequal_last):
        lo, hi = left_over.get(value, (value.lo, value.hi))
        match op:
            case "<" | "<=":
                hi = min(hi, bound - (op == "<"))
            case ">" | ">=":
                lo = max(lo, bound + (op == ">"))
            case "==":
                lo, hi = max(lo, bound), min(hi, bound)
            case "!=":
                lo, hi = lo + (lo == bound), hi - (hi == bound)
            case _:
                assert_never(op)
        left_over[value] = lo, hi
    return all(lo <= hi for lo, hi in left_over.values())


def _bounds(tests: tuple[Test, ...]) -> Iterator[tuple[Expr, CompareOp, int]]:
    """The comparisons with constants among tests that hold together, the constant on the right."""
    for test in tests:
        match test:
            case Compare(op, value, Const(bound)):
                yield value, op, bound
            case Compare(op, Const(bound), value):
                yield value, _MIRRORED[op], bound
            case AllOf(operands):
                yield from _bounds(operands)
            case NotTest(Compare(op, left, right)):
                yield from _bounds((Compare(_OPPOSITE[op], left, right),))
            case NotTest(AnyOf(operands)):
                yield from _bounds(tuple(NotTest(t) for t in operands))
            case _:
                pass


def _unequal_last(bound: tuple[Expr, CompareOp, int]) -> bool:
    """``!=`` takes away only ends, so the ends come first."""
    return bound[1] == "!="


_OPPOSITE: dict[CompareOp, CompareOp] = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
_MIRRORED: dict[CompareOp, CompareOp] = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}


def _compare(test: Compare) -> bool | None:
    left, right = test.left, test.right
    if left == right:
        return test.op in ("<=", ">=", "==")
    less = True if left.hi < right.lo else False if left.lo >= right.hi else None
    less_equal = True if left.hi <= right.lo else False if left.lo > right.hi else None
    if left.hi < right.lo or left.lo > right.hi:
        equal: bool | None = False
    else:
        equal = True if left.lo == left.hi == right.lo == right.hi else None
    match test.op:
        case "<":
            return less
        case "<=":
            return less_equal
        case ">":
            return None if less_equal is None else not less_equal
        case ">=":
            return None if less is None else not less
        case "==":
            return equal
        case "!=":
            return None if equal is None else not equal
        case _:
            assert_never(test.op)


def settle(expr: Expr) -> Expr:
    """The expression as C says it best; its value and its own interval stay.

    Choices that are decided go, ``x + y * -3`` becomes ``x - y * 3``, and constants stand on the right of min and max.
    """
    match expr:
        case Const() | Local() | ReadPort() | ReadField() | ReadState():
            return expr
        case Element():
            return replace(expr, index=settle(expr.index))
        case Binary():
            return _subtracted(replace(expr, left=settle(expr.left), right=settle(expr.right)))
        case MulHigh():
            return replace(expr, left=settle(expr.left), right=settle(expr.right))
        case Quotient():
            return replace(expr, num=settle(expr.num), den=settle(expr.den))
        case Least():
            outcome = decided(Compare("<", expr.left, expr.right))
            return _constant_last(expr) if outcome is None else expr.left if outcome else expr.right
        case Greatest():
            outcome = decided(Compare(">", expr.left, expr.right))
            return _constant_last(expr) if outcome is None else expr.left if outcome else expr.right
        case Above():
            outcome = decided(Compare(">", expr.left, expr.right))
            if outcome is None:
                return expr
            return Binary("-", expr.left, expr.right, max(expr.lo, 0), expr.hi) if outcome else Const(0)
        case Select():
            test = settle_test(expr.test)
            outcome = decided(test)
            then, other = settle(expr.then), settle(expr.other)
            if outcome is not None:
                return then if outcome else other
            return then if then == other else replace(expr, test=test, then=then, other=other)
        case _:
            assert_never(expr)


def _constant_last(expr: Least | Greatest) -> Expr:
    return replace(expr, left=expr.right, right=expr.left) if isinstance(expr.left, Const) else expr


def _subtracted(expr: Binary) -> Expr:
    match expr:
        case Binary("+", left, Binary("*", factor, Const(by), lo, hi)) if by < 0 and lo > -(2**31):
            product = factor if by == -1 else Binary("*", factor, Const(-by), -hi, -lo)
            return replace(expr, op="-", left=left, right=product)
        case _:
            return expr


def settle_test(test: Test) -> Test:
    """The test without parts that are decided; a test that is decided as a whole stays as it is."""
    match test:
        case Compare():
            return replace(test, left=settle(test.left), right=settle(test.right))
        case AllOf() | AnyOf():
            operands = tuple(settle_test(t) for t in test.operands)
            if decided(replace(test, operands=operands)) is not None:
                return replace(test, operands=operands)
            kept = tuple(t for t in operands if decided(t) is None)
            return kept[0] if len(kept) == 1 else replace(test, operands=kept)
        case NotTest():
            return NotTest(settle_test(test.operand))
        case _:
            assert_never(test)
