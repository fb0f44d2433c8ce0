"""A ghost for each array that is only added to: the sum of its elements, which no interval of one element tells.

It begins at 0 where the array is set to 0, and grows by what is added to an element. So it is their sum at every point
behind, as long as neither wraps around, which is asked of every addition.
"""

from __future__ import annotations

from typing import Any

from pycparser import c_ast

from fuzzyspec.prove.annotated import TOTAL, number, place, type_of
from fuzzyspec.prove.rounds import declared, rounds


def totalled(function: c_ast.FuncDef, without: frozenset[str]) -> None:
    """Add the ghosts to a function of the analyser's C, but for those named in ``without``."""
    for array in [d for d in declared(function) if isinstance(d.type, c_ast.ArrayDecl)]:
        size = number(array.type.dim)
        # Narrower elements would be cut to their width.
        if size is None or type_of(array.type.type) != "uint32_t" or TOTAL + array.name in without:
            continue
        zeroing = _zeroing(function.body, array.name, size)
        if zeroing is not None and _only_added_to(function.body, array.name, zeroing[1]):
            _add(function.body, array.name, zeroing)


def _zeroing(body: c_ast.Compound, array: str, size: int) -> tuple[c_ast.Compound, Any] | None:
    """The first block of the body that sets every element to 0, and the assignment."""
    for block in body.block_items or []:
        match block:
            case c_ast.Compound(block_items=[c_ast.Decl() as counter, c_ast.While() as loop]):
                stored = _alone(loop.stmt.block_items[:-1])
                if rounds(counter, loop) == size and _sets_to_0(stored, array, counter.name):
                    return block, stored
            case _:
                pass
    return None


def _alone(items: list[Any]) -> Any:
    """The only statement of a block, and of those in it."""
    while len(items) == 1 and isinstance(items[0], c_ast.Compound):
        items = items[0].block_items or []
    return items[0] if len(items) == 1 else None


def _sets_to_0(node: Any, array: str, counter: str) -> bool:
    if not isinstance(node, c_ast.Assignment) or node.op != "=" or not _of(node.lvalue, array):
        return False
    at = node.lvalue.subscript
    return isinstance(at, c_ast.ID) and at.name == counter and number(node.rvalue) == 0


def _only_added_to(node: Any, array: str, zeroing: Any) -> bool:
    """Whether the array is written by nothing else but additions, and goes nowhere as a whole."""
    for name, child in node.children():
        if child is zeroing:
            continue
        if (
            isinstance(child, c_ast.ID)
            and child.name == array
            and not (isinstance(node, c_ast.ArrayRef) and name == "name")
        ):
            return False
        if isinstance(child, c_ast.UnaryOp) and child.op in ("&", "++", "--", "p++", "p--") and _of(child.expr, array):
            return False
        if isinstance(child, c_ast.Assignment) and _of(child.lvalue, array) and _added(child) is None:
            return False
        if not _only_added_to(child, array, zeroing):
            return False
    return True


def _of(node: Any, array: str) -> bool:
    return isinstance(node, c_ast.ArrayRef) and isinstance(node.name, c_ast.ID) and node.name.name == array


def _added(node: c_ast.Assignment) -> Any:
    """What an assignment adds to an element."""
    added = None
    if node.op == "+=":
        added = node.rvalue
    elif node.op == "=" and isinstance(node.rvalue, c_ast.BinaryOp) and node.rvalue.op == "+":
        added = node.rvalue.right if place(node.rvalue.left) == place(node.lvalue) else None
    return added if isinstance(added, c_ast.ID) else None


def _add(body: c_ast.Compound, array: str, zeroing: tuple[c_ast.Compound, Any]) -> None:
    name = TOTAL + array
    of = c_ast.IdentifierType(["uint32_t"])
    start = c_ast.Decl(name, [], [], [], [], c_ast.TypeDecl(name, [], None, of), c_ast.Constant("int", "0U"), None)
    at = next(i for i, item in enumerate(body.block_items) if item is zeroing[0])
    body.block_items.insert(at + 1, start)
    _grow(body, array, name)


def _grow(node: Any, array: str, name: str) -> None:
    """The ghost grows behind every addition; a branch that is no more than one becomes a block."""
    if isinstance(node, c_ast.If):
        node.iftrue, node.iffalse = (
            c_ast.Compound([part]) if isinstance(part, c_ast.Assignment) else part
            for part in (node.iftrue, node.iffalse)
        )
    if isinstance(node, c_ast.Compound):
        made: list[Any] = []
        for item in node.block_items or []:
            made.append(item)
            added = _added(item) if isinstance(item, c_ast.Assignment) and _of(item.lvalue, array) else None
            if added is not None:
                more = c_ast.BinaryOp("+", c_ast.ID(name), c_ast.ID(added.name))
                made.append(c_ast.Assignment("=", c_ast.ID(name), more))
        node.block_items = made
    for _, child in node.children():
        # Where else an assignment may stand, there would be no place for the ghost's.
        assert (
            isinstance(node, c_ast.Compound) or not isinstance(child, c_ast.Assignment) or not _of(child.lvalue, array)
        )
        _grow(child, array, name)
