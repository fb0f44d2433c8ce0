"""Mutants of the generated C: one place of its syntax tree changed, the rest of the file as it reads.

What is changed: constants, table entries, operators, comparisons, indices, clamps and other conditions (left out, or
taken always), operands of a subtraction (swapped), statements and ``else`` branches (deleted), the types of casts and
of locals. Directives and comments are left alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import tree_sitter
import tree_sitter_c

PARSER = tree_sitter.Parser(tree_sitter.Language(tree_sitter_c.language()))

OPERATORS = {
    "+": ("-",),
    "-": ("+",),
    "*": ("+",),
    "/": ("*",),
    "%": ("/",),
    "<<": (">>",),
    ">>": ("<<",),
    "&": ("|",),
    "|": ("&", "^"),
    "^": ("|",),
    "&&": ("||",),
    "||": ("&&",),
}
COMPARISONS = {
    "<": ("<=", ">="),
    "<=": ("<", ">"),
    ">": (">=", "<="),
    ">=": (">", "<"),
    "==": ("!=",),
    "!=": ("==",),
}
TYPES = {
    "uint8_t": ("uint16_t", "int8_t"),
    "uint16_t": ("uint8_t", "int16_t"),
    "uint32_t": ("uint16_t",),
    "int8_t": ("uint8_t",),
    "int16_t": ("int8_t", "uint16_t"),
    "int32_t": ("int16_t", "uint32_t"),
}


@dataclass(frozen=True)
class Mutant:
    """``start`` and ``end``: the bytes that ``new`` replaces. ``function``: where they are, "" outside of any."""

    kind: str
    function: str
    line: int
    start: int
    end: int
    old: str
    new: str

    def of(self, source: bytes) -> bytes:
        """The mutated file."""
        return source[: self.start] + self.new.encode() + source[self.end :]

    def __str__(self) -> str:
        return f"{self.function or 'table'}:{self.line}: {self.kind}: {_short(self.old)} -> {_short(self.new)}"


def _short(text: str) -> str:
    words = " ".join(text.split())
    return (words if len(words) <= 60 else f"{words[:57]}...") or "nothing"


def parse(source: bytes) -> tree_sitter.Node:
    """The root of the syntax tree."""
    return PARSER.parse(source).root_node


def text(node: tree_sitter.Node) -> str:
    """What a node spans."""
    assert node.text is not None
    return node.text.decode()


def mutants(source: bytes) -> list[Mutant]:
    """Every mutant of a C file, in the order of the text; each changes it."""
    return sorted(set(_walk(parse(source), "")), key=lambda m: (m.start, m.end, m.new))


def _walk(node: tree_sitter.Node, function: str) -> Iterator[Mutant]:
    if node.type.startswith("preproc_"):
        return
    if node.type == "function_definition":
        function = _name(node)
    for kind, part, new in _changes(node):
        if text(part) != new:
            yield Mutant(kind, function, part.start_point.row + 1, part.start_byte, part.end_byte, text(part), new)
    for child in node.children:
        yield from _walk(child, function)


def _name(node: tree_sitter.Node) -> str:
    declarator: tree_sitter.Node | None = node
    while declarator is not None and declarator.type != "identifier":
        declarator = declarator.child_by_field_name("declarator")
    return "" if declarator is None else text(declarator)


def _changes(node: tree_sitter.Node) -> Iterator[tuple[str, tree_sitter.Node, str]]:
    """What may be changed at a node itself: the kind, the part that is replaced, and by what."""
    match node.type:
        case "number_literal":
            yield from _number(node)
        case "binary_expression":
            yield from _binary(node)
        case "subscript_expression":
            index = _field(node, "index")
            if index.type != "number_literal":
                yield from (("index", index, f"({text(index)}) {sign} 1U") for sign in "+-")
        case "conditional_expression":
            yield from (("clamp", node, f"({text(_field(node, k))})") for k in ("consequence", "alternative"))
        case "if_statement":
            yield from _if(node)
        case "expression_statement":
            yield "deleted statement", node, ";"
        case "update_expression":
            yield "operator", node, text(node).replace("++", "--")
        case "primitive_type" | "type_identifier":
            kind = _typed(node)
            yield from ((kind, node, other) for other in TYPES.get(text(node), ()) if kind)


def _field(node: tree_sitter.Node, name: str) -> tree_sitter.Node:
    child = node.child_by_field_name(name)
    assert child is not None, (node.type, name)
    return child


def _number(node: tree_sitter.Node) -> Iterator[tuple[str, tree_sitter.Node, str]]:
    written = text(node)
    digits = written.rstrip("UuLl")
    value, suffix = int(digits, 0), written[len(digits) :]
    parent = node.parent
    assert parent is not None
    if parent.type == "array_declarator":
        return
    table = parent.type == "initializer_list"
    kind = "table" if table else "index" if parent.type == "subscript_expression" else "constant"
    for other in (value + 1, value - 1):
        if other >= 0:
            yield kind, node, f"{other}{suffix}"
    if table and node.next_named_sibling is not None and node.next_named_sibling.type == "number_literal":
        # One entry in the place of another.
        yield kind, node, text(node.next_named_sibling)


def _binary(node: tree_sitter.Node) -> Iterator[tuple[str, tree_sitter.Node, str]]:
    left, operator, right = _field(node, "left"), _field(node, "operator"), _field(node, "right")
    yield from (("operator", operator, other) for other in OPERATORS.get(text(operator), ()))
    yield from (("comparison", operator, other) for other in COMPARISONS.get(text(operator), ()))
    if text(operator) == "-":
        whole = f"({text(left)})" if left.type == "binary_expression" else text(left)
        yield "swapped operands", node, f"{text(right)} - {whole}"
    if text(operator) in ("&&", "||"):
        yield from (("clamp", node, text(kept)) for kept in (left, right))


def _if(node: tree_sitter.Node) -> Iterator[tuple[str, tree_sitter.Node, str]]:
    then, otherwise = _field(node, "consequence"), node.child_by_field_name("alternative")
    yield "clamp", _field(node, "condition"), "(0)"
    yield "clamp", _field(node, "condition"), "(1)"
    if otherwise is None:
        return
    yield "dropped else", otherwise, ""
    inner = otherwise.named_children[-1]
    if inner.type == "compound_statement":
        yield "clamp", then, text(inner)


def _typed(node: tree_sitter.Node) -> str:
    """The kind of a type's mutants: of a cast's, or of a local's; "" for parameters, tables and results."""
    parent = node.parent
    if parent is not None and parent.type == "type_descriptor":
        return "cast"
    if parent is None or parent.type != "declaration" or parent.parent is None:
        return ""
    return "" if parent.parent.type == "translation_unit" else "type of a local"
