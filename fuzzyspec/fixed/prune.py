"""Drop what C would not use: records, branches that never run, and the locals that only those read.

Values stay what they are: a statement goes only if nothing that leaves the function depends on it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import assert_never

from fuzzyspec.fixed.decide import decided, settle, settle_test
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

Node = Expr | Test


def prune(body: tuple[Stmt, ...]) -> tuple[Stmt, ...]:
    """The statements that C prints. Names are taken as one scope, so this keeps too much rather than too little."""
    kept = _settle(body)
    while True:
        used = {name for node in expressions(kept) for name in _names(node)}
        fewer = _live(kept, frozenset(used))
        if fewer == kept:
            return _without_idle_comments(kept)
        kept = fewer


def children(node: Node) -> tuple[Node, ...]:
    """The direct operands of an expression or a test."""
    match node:
        case Const() | Local() | ReadPort() | ReadField() | ReadState():
            return ()
        case Element():
            return (node.index,)
        case Binary() | Least() | Greatest() | Above() | MulHigh() | Compare():
            return (node.left, node.right)
        case Quotient():
            return (node.num, node.den)
        case Select():
            return (node.test, node.then, node.other)
        case AllOf() | AnyOf():
            return node.operands
        case NotTest():
            return (node.operand,)
        case _:
            assert_never(node)


def nodes(node: Node) -> Iterator[Node]:
    """The node and everything below it, each before its operands, these from left to right."""
    left = [node]
    while left:
        found = left.pop()
        yield found
        left += reversed(children(found))


def statements(body: tuple[Stmt, ...]) -> Iterator[Stmt]:
    """Every statement, those of inner blocks included."""
    for statement in body:
        yield statement
        match statement:
            case Loop() | Each():
                yield from statements(statement.body)
            case Branch():
                yield from statements(statement.then)
                yield from statements(statement.other)
            case _:
                pass


def expressions(body: tuple[Stmt, ...]) -> Iterator[Node]:
    """The topmost expressions and tests of every statement."""
    for statement in statements(body):
        match statement:
            case Define() | Assign() | SetOutput() | SetState() | Record():
                yield statement.value
            case Window():
                yield statement.start
            case AssignElement():
                yield statement.index
                yield statement.value
            case Branch():
                yield statement.test
            case CallFunction():
                yield from statement.arguments
            case Comment() | DefineArray() | Loop() | Each() | SetStatus():
                pass
            case _:
                assert_never(statement)


def _names(node: Node) -> Iterator[str]:
    for inner in nodes(node):
        if isinstance(inner, Local):
            yield inner.name
        elif isinstance(inner, Element):
            yield inner.array


def _settle(body: tuple[Stmt, ...]) -> tuple[Stmt, ...]:
    """Without records, and with decided choices replaced by the arm that is taken."""
    out: list[Stmt] = []
    for statement in body:
        match statement:
            case Record():
                pass
            case Branch():
                test = settle_test(statement.test)
                outcome = decided(test)
                then, other = _settle(statement.then), _settle(statement.other)
                if outcome is not None:
                    out.extend(then if outcome else other)
                elif _idle(then) and not _idle(other):
                    out.append(Branch(NotTest(test), other))
                else:
                    out.append(Branch(test, then, other))
            case Loop() | Each():
                out.append(replace(statement, body=_settle(statement.body)))
            case Define() | Assign() | SetOutput() | SetState():
                out.append(replace(statement, value=settle(statement.value)))
            case Window():
                out.append(replace(statement, start=settle(statement.start)))
            case AssignElement():
                out.append(replace(statement, index=settle(statement.index), value=settle(statement.value)))
            case CallFunction():
                out.append(replace(statement, arguments=tuple(settle(a) for a in statement.arguments)))
            case _:
                out.append(statement)
    return tuple(out)


def _live(body: tuple[Stmt, ...], used: frozenset[str]) -> tuple[Stmt, ...]:
    out: list[Stmt] = []
    for statement in body:
        match statement:
            case Assign(local, Local(name)) if name == local.name:
                # A sum that nothing is added to is no statement: compilers warn of it.
                pass
            case Define() | Assign():
                if statement.local.name in used:
                    out.append(statement)
            case DefineArray() | Window():
                if statement.name in used:
                    out.append(statement)
            case AssignElement():
                if statement.array in used:
                    out.append(statement)
            case Branch():
                then, other = _live(statement.then, used), _live(statement.other, used)
                if not (_idle(then) and _idle(other)):
                    out.append(Branch(statement.test, then, () if _idle(other) else other))
            case Loop():
                inner = _live(statement.body, used)
                if not _idle(inner):
                    out.append(replace(statement, body=inner))
            case Each():
                # An idle pass still tells of an overrun.
                out.append(replace(statement, body=_live(statement.body, used)))
            case CallFunction():
                results = tuple((name, local) for name, local in statement.results if local.name in used)
                if results or statement.state is not None or statement.held:
                    out.append(replace(statement, results=results))
            case _:
                out.append(statement)
    return tuple(out)


def _idle(body: tuple[Stmt, ...]) -> bool:
    return all(isinstance(s, Comment) for s in body)


def _without_idle_comments(body: tuple[Stmt, ...]) -> tuple[Stmt, ...]:
    """A comment speaks of the statements up to the next one; without any it goes."""
    out: list[Stmt] = []
    for index, statement in enumerate(body):
        following = body[index + 1] if index + 1 < len(body) else None
        match statement:
            case Comment():
                if following is not None and not isinstance(following, Comment):
                    out.append(statement)
            case Branch():
                out.append(
                    Branch(
                        statement.test, _without_idle_comments(statement.then), _without_idle_comments(statement.other)
                    )
                )
            case Loop() | Each():
                out.append(replace(statement, body=_without_idle_comments(statement.body)))
            case _:
                out.append(statement)
    return tuple(out)
