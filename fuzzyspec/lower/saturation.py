"""A raw from outside becomes a legal one."""

from __future__ import annotations

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Branch, Const, Define, Expr, Local, SetStatus, Stmt
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.variable import Variable


def saturated(
    variable: Variable, given: Expr, name: str, bit: str, scope: Scope
) -> tuple[list[Stmt], Expr, list[Stmt]]:
    """A raw from outside, brought to the nearest legal one, and statements that set ``bit`` where that changed it."""
    raw = variable.raw
    read = build.local(scope.name(f"{name}_raw" if given.lo < raw.lo or given.hi > raw.hi else name), given)
    body: list[Stmt] = [Define(read, given, True)]
    if given.lo >= raw.lo and given.hi <= raw.hi:
        return body, read, []
    if given.lo >= raw.lo >= 0:
        # A difference, not a minimum: of a minimum's two values one is a constant, for which compilers double all that
        # follows.
        excess = build.above(read, Const(raw.hi))
        over = build.local(scope.name(f"{name}_over"), excess)
        value = build.sub_guarded(read, over, raw.hi)
        legal = Local(scope.name(name), read.ctype, raw.lo, raw.hi)
        body += [Define(over, excess, True), Define(legal, value, True)]
        return body, legal, [Branch(build.compare("!=", over, Const(0)), (SetStatus(bit),))]
    bounded: Expr = build.greatest(read, Const(raw.lo))
    if given.hi > raw.hi:
        risen = build.local(scope.name(f"{name}_risen"), bounded, ctype=read.ctype)
        body.append(Define(risen, bounded, True))
        bounded = build.least(risen, Const(raw.hi))
    legal = Local(scope.name(name), read.ctype, raw.lo, raw.hi)
    body.append(Define(legal, bounded, True))
    return body, legal, [Branch(build.compare("!=", read, legal), (SetStatus(bit),))]
