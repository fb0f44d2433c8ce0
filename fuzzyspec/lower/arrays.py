"""Local arrays that start at 0."""

from __future__ import annotations

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import AssignElement, Const, CType, DefineArray, Local, Loop, Stmt
from fuzzyspec.lower.scope import Scope


def zeroed(name: str, ctype: CType, size: int, scope: Scope) -> list[Stmt]:
    """Define an array and clear it by a loop: compilers turn a zero initialiser into a call of memset."""
    counter = Local(scope.name("k"), build.smallest_type(0, size - 1), 0, size - 1)
    return [DefineArray(name, ctype, size), Loop(counter, size, (AssignElement(name, ctype, counter, Const(0)),))]
