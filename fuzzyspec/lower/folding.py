"""Folds over a list: accumulators before the loop, a step inside it, the result after it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import AllOf, Assign, Branch, Const, Define, Expr, Local, Stmt, Test
from fuzzyspec.lower.scaled import Scaled, cause_of, constant
from fuzzyspec.model.system import Const as ModelConst
from fuzzyspec.model.system import Fold

if TYPE_CHECKING:
    from fuzzyspec.lower.system import Lowering


@dataclass(frozen=True)
class Folded:
    """``finish`` gives the value, once the loop is done."""

    finish: Callable[[], Scaled]


def fold(lowering: Lowering, node: Fold, capacity: int, before: list[Stmt]) -> Folded:
    """Append the step of one fold to the loop's body; its accumulators go to ``before``."""
    name = node.kind
    if node.kind in ("sum", "count"):
        return _total(lowering, node, capacity, before)
    assert node.body is not None and node.otherwise is not None
    test = lowering.test(node.test, name) if node.test is not None else None
    body = lowering.value(node.body, name)
    greatest = node.kind == "max"
    arithmetic = lowering.arithmetic
    (whole,) = arithmetic.common([body], name)
    step = whole.step if isinstance(whole.expr, Const) else abs(whole.step)
    value = arithmetic.bind(whole.expr, f"{name}_of")
    fallback = _constant(node)
    if fallback is not None:
        start = fallback / step
        reached = start <= value.lo if greatest else start >= value.hi
        if start.denominator == 1 and reached and abs(start) < 2**30:
            # The fallback is the neutral start: no element can be beaten by it.
            best = _accumulator(lowering, name, value, int(start))
            before.append(Define(best, Const(int(start)), False))
            lowering.body += _guarded(test, [Branch(_better(greatest, value, best), (Assign(best, value),))])
            result = Scaled(best, step, Fraction(0), whole.error, whole.cause)
            return Folded(lambda: result)
    best = _accumulator(lowering, name, value, value.lo if greatest else value.hi)
    found = Local(lowering.scope.name(f"{name}_any"), "uint8", 0, 1)
    first = Const(value.lo if greatest else value.hi)
    before += [Define(best, first, False), Define(found, Const(0), False)]
    lowering.body += _guarded(
        test, [Assign(found, Const(1)), Branch(_better(greatest, value, best), (Assign(best, value),))]
    )
    passed = Scaled(best, step, Fraction(0), whole.error, whole.cause)

    def finish() -> Scaled:
        assert node.otherwise is not None
        a = lowering.arithmetic
        same = a.common([passed, lowering.value(node.otherwise, name)], name)
        chosen = build.select(build.compare("!=", found, Const(0)), same[0].expr, same[1].expr)
        return Scaled(a.bind(chosen, name), same[0].step, same[0].offset, max(s.error for s in same), cause_of(*same))

    return Folded(finish)


def _constant(node: Fold) -> Fraction | None:
    return node.otherwise.value if isinstance(node.otherwise, ModelConst) else None


def _better(greatest: bool, value: Expr, best: Local) -> Test:
    return build.compare(">" if greatest else "<", value, best)


def _accumulator(lowering: Lowering, name: str, value: Expr, start: int) -> Local:
    lo, hi = min(value.lo, start), max(value.hi, start)
    return Local(lowering.scope.name(f"{name}_best"), "int32" if lo < 0 else "uint32", lo, hi)


def _guarded(test: Test | None, steps: list[Stmt]) -> list[Stmt]:
    if test is None:
        return steps
    if len(steps) == 1 and isinstance(steps[0], Branch) and not steps[0].other:
        return [Branch(AllOf((test, steps[0].test)), steps[0].then)]
    return [Branch(test, tuple(steps))]


def _total(lowering: Lowering, node: Fold, capacity: int, before: list[Stmt]) -> Folded:
    name = node.kind
    test = lowering.test(node.test, name) if node.test is not None else None
    body = lowering.value(node.body, name) if node.body is not None else None
    arithmetic = lowering.arithmetic
    scaled = body if body is not None else constant(Fraction(1))
    (whole,) = arithmetic.common([scaled], name)
    if whole.expr.lo != whole.expr.hi:
        bits = (max(abs(whole.expr.lo), abs(whole.expr.hi)) * capacity).bit_length()
        if bits > 30:
            whole = arithmetic.rounded(whole, abs(whole.step) * 2 ** (bits - 30), Fraction(0), name)
    value = arithmetic.bind(whole.expr, f"{name}_of")
    lo, hi = min(0, value.lo * capacity), max(0, value.hi * capacity)
    total = Local(lowering.scope.name(f"{name}_total"), "int32" if lo < 0 else "uint32", lo, hi)
    before.append(Define(total, Const(0), False))
    # At most `capacity` elements are added, so the sum stays in the accumulator's interval.
    lowering.body += _guarded(test, [Assign(total, build.add_bounded(total, value, hi, lo))])
    result = Scaled(total, whole.step, Fraction(0), whole.error * capacity, whole.cause)
    return Folded(lambda: result)
