"""Rebuild a program's expressions and statements bottom-up: the one recursion that passes over a program share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import assert_never

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

Change = Callable[[Expr], Expr]


def rewritten(expr: Expr, change: Change) -> Expr:
    """``change`` of the expression whose operands are rewritten already."""
    match expr:
        case Const() | Local() | ReadPort() | ReadField() | ReadState():
            return change(expr)
        case Element():
            return change(replace(expr, index=rewritten(expr.index, change)))
        case Binary() | Least() | Greatest() | Above() | MulHigh():
            return change(
                replace(expr, left=rewritten(expr.left, change), right=rewritten(expr.right, change)),
            )
        case Quotient():
            return change(replace(expr, num=rewritten(expr.num, change), den=rewritten(expr.den, change)))
        case Select():
            then, other = rewritten(expr.then, change), rewritten(expr.other, change)
            return change(replace(expr, test=rewritten_test(expr.test, change), then=then, other=other))
        case _:
            assert_never(expr)


def rewritten_test(test: Test, change: Change) -> Test:
    """The test with its expressions rewritten."""
    match test:
        case Compare():
            return replace(test, left=rewritten(test.left, change), right=rewritten(test.right, change))
        case AllOf() | AnyOf():
            return replace(test, operands=tuple(rewritten_test(t, change) for t in test.operands))
        case NotTest():
            return NotTest(rewritten_test(test.operand, change))
        case _:
            assert_never(test)


def rewritten_body(body: tuple[Stmt, ...], change: Change, retype: Callable[[Local], Local]) -> tuple[Stmt, ...]:
    """The statements with every expression rewritten and every local that they set or declare retyped."""
    return tuple(_statement(s, change, retype) for s in body)


def _statement(statement: Stmt, change: Change, retype: Callable[[Local], Local]) -> Stmt:
    match statement:
        case Comment() | DefineArray() | SetStatus():
            return statement
        case Define() | Assign():
            return replace(statement, local=retype(statement.local), value=rewritten(statement.value, change))
        case Window():
            return replace(statement, start=rewritten(statement.start, change))
        case AssignElement():
            index, value = rewritten(statement.index, change), rewritten(statement.value, change)
            return replace(statement, index=index, value=value)
        case Loop() | Each():
            inner = rewritten_body(statement.body, change, retype)
            return replace(statement, counter=retype(statement.counter), body=inner)
        case Branch():
            return Branch(
                rewritten_test(statement.test, change),
                rewritten_body(statement.then, change, retype),
                rewritten_body(statement.other, change, retype),
            )
        case SetOutput() | SetState():
            return replace(statement, value=rewritten(statement.value, change))
        case CallFunction():
            return replace(
                statement,
                arguments=tuple(rewritten(a, change) for a in statement.arguments),
                results=tuple((name, retype(local)) for name, local in statement.results),
            )
        case Record(key, Compare() | AllOf() | AnyOf() | NotTest() as test):
            return Record(key, rewritten_test(test, change))
        case Record(key, value):
            return Record(key, rewritten(value, change))
        case _:
            assert_never(statement)


def declared(body: tuple[Stmt, ...]) -> dict[str, tuple[int, int]]:
    """The interval that every scalar local stays in, over all statements that declare or set it."""
    found: dict[str, tuple[int, int]] = {}

    def note(local: Local) -> Local:
        lo, hi = found.get(local.name, (local.lo, local.hi))
        found[local.name] = min(lo, local.lo), max(hi, local.hi)
        return local

    rewritten_body(body, lambda e: e, note)
    return found
