"""A raw from outside becomes a legal one."""

from __future__ import annotations

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Assign, Branch, Const, Define, Expr, Local, SetStatus, Stmt
from fuzzyspec.lower.scope import Scope
from fuzzyspec.model.variable import Variable


def saturated(
    variable: Variable, given: Expr, name: str, bit: str, scope: Scope, smooth: bool = False
) -> tuple[list[Stmt], Expr, list[Stmt]]:
    """A raw from outside, brought to the nearest legal one, and statements that set ``bit`` where that changed it.

    ``smooth`` takes a difference, and sets the bit later: of a branch's two values one is a constant, for which
    compilers double much of what follows, where that sorts what depends on it.
    """
    raw = variable.raw
    outside = given.lo < raw.lo or given.hi > raw.hi
    read = build.local(scope.name(f"{name}_raw" if outside and smooth else name), given)
    body: list[Stmt] = [Define(read, given, True)]
    if not outside:
        return body, read, []
    if given.lo >= raw.lo >= 0 and smooth:
        excess = build.above(read, Const(raw.hi))
        over = build.local(scope.name(f"{name}_over"), excess)
        value = build.sub_guarded(read, over, raw.hi)
        legal = Local(scope.name(name), read.ctype, raw.lo, raw.hi)
        body += [Define(over, excess, True), Define(legal, value, True)]
        return body, legal, [Branch(build.compare("!=", over, Const(0)), (SetStatus(bit),))]
    if smooth:
        bounded: Expr = build.greatest(read, Const(raw.lo))
        if given.hi > raw.hi:
            risen = build.local(scope.name(f"{name}_risen"), bounded, ctype=read.ctype)
            body.append(Define(risen, bounded, True))
            bounded = build.least(risen, Const(raw.hi))
        legal = Local(scope.name(name), read.ctype, raw.lo, raw.hi)
        body.append(Define(legal, bounded, True))
        return body, legal, [Branch(build.compare("!=", read, legal), (SetStatus(bit),))]
    body = [Define(read, given, False)]
    if given.lo < raw.lo:
        low = build.compare("<", read, Const(raw.lo))
        body.append(Branch(low, (Assign(read, Const(raw.lo)), SetStatus(bit))))
    if given.hi > raw.hi:
        high = build.compare(">", read, Const(raw.hi))
        body.append(Branch(high, (Assign(read, Const(raw.hi)), SetStatus(bit))))
    return body, Local(read.name, read.ctype, raw.lo, raw.hi), []
