"""Decisions on computed values: where the two meanings of a spec may part, each with a name for people."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, assert_never

from fuzzyspec.diagnostics.diagnostic import Source, Span
from fuzzyspec.model.controller import Controller
from fuzzyspec.model.system import (
    Abs,
    ActingOutput,
    Add,
    Both,
    Call,
    CallOutput,
    Clamp,
    Compare,
    Const,
    Div,
    Either,
    Expr,
    Fold,
    ForEach,
    Greatest,
    If,
    Least,
    Let,
    Mul,
    Neg,
    Neither,
    ReadField,
    ReadInput,
    ReadLet,
    Sub,
    System,
    Test,
)

Kind = Literal["comparison", "0/0", "fires", "acting"]


@dataclass(frozen=True, slots=True)
class Decision:
    """``what`` says it in words or in the spec's own; ``span`` is None where no place in the text decides."""

    key: str
    kind: Kind
    what: str
    span: Span | None


def of_controller(controller: Controller, always_fires: tuple[bool, ...]) -> tuple[Decision, ...]:
    """Which outputs fire, where that is not settled beforehand, and which behavior acts."""
    found = [
        Decision(f"fires.{o.name}", "fires", f"whether a rule for {o.name} reaches {controller.fires_at}", None)
        for o, always in zip(controller.outputs, always_fires, strict=True)
        if not always
    ]
    if controller.behaviors:
        found.append(Decision("acting", "acting", "which behavior owns the strongest cell", None))
    return tuple(found)


def of_system(system: System, source: Source | None) -> tuple[Decision, ...]:
    """Every decision of a step, those of the controllers it calls included, in the order of the statements."""
    found: list[Decision] = []
    for statement in system.statements:
        inner: tuple[Let | Call, ...] = statement.body if isinstance(statement, ForEach) else (statement,)
        for part in inner:
            match part:
                case Let(_, value):
                    found += _expr(value, source)
                case Call(call_id, controller, arguments):
                    for argument in arguments:
                        found += _expr(argument, source)
                    found += [
                        Decision(f"{call_id}.{d.key}", d.kind, f"{d.what} ({controller.name})", None)
                        for d in of_controller(controller, controller.always_fires)
                    ]
                case _:
                    assert_never(part)
    for output in system.outputs:
        if not isinstance(output, ActingOutput):
            found += _expr(output.value, source)
    return tuple({d.key: d for d in found}.values())


def raw_against_literal(compare: Compare) -> bool:
    """Both meanings decide alike between a raw input and a constant: it becomes an integer threshold."""
    left, right = compare.left, compare.right
    return (isinstance(left, ReadInput | ReadField) and isinstance(right, Const)) or (
        isinstance(right, ReadInput | ReadField) and isinstance(left, Const)
    )


def _expr(expr: Expr, source: Source | None) -> Iterator[Decision]:
    match expr:
        case Const() | ReadInput() | ReadField() | ReadLet() | CallOutput():
            return
        case Add(left, right) | Sub(left, right) | Mul(left, right):
            yield from _expr(left, source)
            yield from _expr(right, source)
        case Neg(operand) | Clamp(operand) | Abs(operand):
            yield from _expr(operand, source)
        case Least(operands) | Greatest(operands):
            for operand in operands:
                yield from _expr(operand, source)
        case Div():
            yield from _expr(expr.left, source)
            yield from _expr(expr.right, source)
            if expr.otherwise is not None:
                yield from _expr(expr.otherwise, source)
                yield Decision(expr.key, "0/0", _text(expr.span, source, expr.key), expr.span)
        case If(test, then, other):
            yield from _test(test, source)
            yield from _expr(then, source)
            yield from _expr(other, source)
        case Fold():
            if expr.test is not None:
                yield from _test(expr.test, source)
            if expr.body is not None:
                yield from _expr(expr.body, source)
            if expr.otherwise is not None:
                yield from _expr(expr.otherwise, source)
        case _:
            assert_never(expr)


def _test(test: Test, source: Source | None) -> Iterator[Decision]:
    match test:
        case Compare():
            yield from _expr(test.left, source)
            yield from _expr(test.right, source)
            if not raw_against_literal(test):
                yield Decision(test.key, "comparison", _text(test.span, source, test.key), test.span)
        case Both(operands) | Either(operands):
            for operand in operands:
                yield from _test(operand, source)
        case Neither(operand):
            yield from _test(operand, source)
        case _:
            assert_never(test)


def _text(span: Span, source: Source | None, key: str) -> str:
    """The spec's own words on one line."""
    if source is None:
        return key
    words = " ".join(source.text[span.start : span.end].split())
    return words if len(words) <= 60 else words[:57] + "..."
