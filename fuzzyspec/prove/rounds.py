"""Loops of few rounds over local arrays, written out: what holds of one element is then not said of all of them.

Only the analyser's C is changed, and only where the text shows how often a loop goes round.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from typing import Any

from pycparser import c_ast

from fuzzyspec.prove.annotated import assigned, number, type_of

MOST = 16
"""Rounds that are written out."""


def written_out(function: c_ast.FuncDef, copied: Callable[[Any, Any], None]) -> None:
    """Write out the loops of a function's outermost blocks that read local arrays. ``copied`` is told of each copy."""
    arrays = {d.name for d in declared(function) if isinstance(d.type, c_ast.ArrayDecl)}
    _block(function.body, arrays, copied)


def declared(node: Any) -> Iterator[c_ast.Decl]:
    """The declarations of variables in a function."""
    for _, child in node.children():
        if isinstance(child, c_ast.Decl) and not isinstance(child.type, c_ast.FuncDecl):
            yield child
        yield from declared(child)


def _block(block: c_ast.Compound, arrays: set[str], copied: Callable[[Any, Any], None]) -> None:
    made: list[Any] = []
    for item in block.block_items or []:
        if isinstance(item, c_ast.Compound):
            _block(item, arrays, copied)
        elif isinstance(item, c_ast.If):
            for part in (item.iftrue, item.iffalse):
                if isinstance(part, c_ast.Compound):
                    _block(part, arrays, copied)
        before = made[-1] if made else None
        count = rounds(before, item)
        if count is not None and count <= MOST and arrays & _read(item.stmt):
            made += _copies(before, item, count, copied)
        else:
            made.append(item)
    block.block_items = made


def rounds(before: Any, loop: Any) -> int | None:
    """How often a loop goes round: ``c = 0; while (c < N) { .. c ++; }``, where nothing else changes ``c``."""
    match before, loop:
        case (
            c_ast.Decl(name=name, init=init),
            c_ast.While(
                cond=c_ast.BinaryOp(op="<", left=left, right=right), stmt=c_ast.Compound(block_items=[*rest, step])
            ),
        ):
            here = _is(left, name) and _steps(step, name) and init is not None and number(init) == 0
            plain = not any(name in assigned(c_ast.Compound([r])) or _leaves(r) for r in rest)
            return number(right) if here and plain else None
        case _:
            return None


def _steps(node: Any, name: str) -> bool:
    """Whether a statement adds 1 to a variable, whatever type it does so in."""
    match node:
        case c_ast.UnaryOp(op="p++" | "++"):
            return _is(node.expr, name)
        case c_ast.Assignment(op="=", lvalue=target, rvalue=value):
            added = _bare(value)
            plus = isinstance(added, c_ast.BinaryOp) and added.op == "+" and number(added.right) == 1
            return plus and _is(target, name) and _is(added.left, name)
        case _:
            return False


def _is(node: Any, name: str) -> bool:
    found = _bare(node)
    return isinstance(found, c_ast.ID) and found.name == name


def _bare(node: Any) -> Any:
    return _bare(node.expr) if isinstance(node, c_ast.Cast) else node


def _leaves(node: Any) -> bool:
    """Whether it is a loop or jumps, or something in it is or does."""
    if isinstance(node, c_ast.While | c_ast.Break | c_ast.Continue | c_ast.Goto | c_ast.Return):
        return True
    return any(_leaves(child) for _, child in node.children())


def _read(node: Any) -> set[str]:
    """The names of arrays whose elements are read."""
    found: set[str] = set()
    for name, child in node.children():
        if isinstance(child, c_ast.ArrayRef) and isinstance(child.name, c_ast.ID):
            stored = isinstance(node, c_ast.Assignment) and name == "lvalue" and node.op == "="
            found |= set() if stored else {child.name.name}
        found |= _read(child)
    return found


def _copies(
    counter: c_ast.Decl, loop: c_ast.While, count: int, copied: Callable[[Any, Any], None]
) -> Iterator[c_ast.Compound]:
    for at in range(count):
        memo: dict[int, Any] = {}
        body = copy.deepcopy(c_ast.Compound(loop.stmt.block_items[:-1]), memo)
        for node in _nodes(loop.stmt):
            if id(node) in memo:
                copied(node, memo[id(node)])
        of = c_ast.Typename(None, [], None, c_ast.TypeDecl(None, [], None, c_ast.IdentifierType([_named(counter)])))
        _put(body, counter.name, c_ast.Cast(of, c_ast.Constant("int", f"{at}U")))
        yield body


def _named(counter: c_ast.Decl) -> str:
    name = type_of(counter.type)
    assert name is not None
    return name


def _nodes(node: Any) -> Iterator[Any]:
    for _, child in node.children():
        yield child
        yield from _nodes(child)


def _put(node: Any, name: str, value: Any) -> None:
    """``value`` for a variable, and subscripts that it makes constant as numbers."""
    for slot in node.__slots__:
        held = getattr(node, slot) if slot not in ("coord", "__weakref__") else None
        parts = held if isinstance(held, list) else [held]
        for at, part in enumerate(parts):
            if isinstance(part, c_ast.ID) and part.name == name:
                parts[at] = copy.deepcopy(value)
            elif isinstance(part, c_ast.Node):
                _put(part, name, value)
        if parts and not isinstance(held, list) and parts[0] is not held:
            setattr(node, slot, parts[0])
    if isinstance(node, c_ast.ArrayRef):
        index = number(node.subscript)
        if index is not None:
            node.subscript = c_ast.Constant("int", f"{index}U")
