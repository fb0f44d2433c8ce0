"""What a generated C file declares, read off its syntax tree."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

import tree_sitter

from tests.mutation.c_mutants import text
from tests.mutation.c_words import WIDTHS


class Unclear(Exception):
    """The C does something that is not followed here."""


@dataclass
class Source:
    """One preprocessed file: functions by name, tables, types' true names, members of structs."""

    functions: dict[str, tree_sitter.Node] = field(default_factory=dict)
    tables: dict[str, tuple[str, list[int]]] = field(default_factory=dict)
    types: dict[str, str] = field(default_factory=dict)
    structs: dict[str, dict[str, str]] = field(default_factory=dict)

    @classmethod
    def of(cls, root: tree_sitter.Node) -> Source:
        """What a translation unit declares."""
        found = cls()
        for node in root.children:
            if node.type == "type_definition":
                found._type(node)
            elif node.type == "function_definition":
                found.functions[declared(node)] = node
            elif node.type == "declaration":
                for table in node.children_by_field_name("declarator"):
                    values = table.child_by_field_name("value")
                    if values is not None and values.type == "initializer_list":
                        numbers = [number(text(n)) for n in values.named_children if n.type == "number_literal"]
                        found.tables[declared(table)] = (found.true(text(child(node, "type"))), numbers)
        return found

    def _type(self, node: tree_sitter.Node) -> None:
        name, kind = declared(node), child(node, "type")
        body = kind.child_by_field_name("body")
        if kind.type == "struct_specifier" and body is not None:
            members = [m for m in body.named_children if m.type == "field_declaration"]
            self.structs[name] = {declared(m): text(child(m, "type")) for m in members}
        elif name not in WIDTHS:
            self.types[name] = text(kind)

    def true(self, ctype: str) -> str:
        """A type by the name that ``WIDTHS`` knows, or a struct's."""
        while ctype in self.types:
            ctype = self.types[ctype]
        if ctype not in WIDTHS and ctype not in self.structs:
            raise Unclear(f"the type {ctype}")
        return ctype


def child(node: tree_sitter.Node, name: str) -> tree_sitter.Node:
    """A part by its name in the grammar."""
    found = node.child_by_field_name(name)
    if found is None:
        raise Unclear(f"{node.type} without {name}: {text(node)[:80]}")
    return found


def declared(node: tree_sitter.Node | None) -> str:
    """The name that a declaration is of."""
    while node is not None and node.type not in ("identifier", "field_identifier", "type_identifier"):
        node = node.child_by_field_name("declarator")
    return "" if node is None else text(node)


def number(written: str) -> int:
    """What a literal stands for."""
    return int(written.rstrip("UuLl"), 0)


def parameters(function: tree_sitter.Node) -> list[tuple[str, str]]:
    """Names and types of what a function takes."""
    declarator = child(function, "declarator")
    while declarator.type != "function_declarator":
        declarator = child(declarator, "declarator")
    listed = child(declarator, "parameters").named_children
    return [(declared(p), text(child(p, "type"))) for p in listed if p.type == "parameter_declaration"]


def nodes(node: tree_sitter.Node) -> Iterator[tree_sitter.Node]:
    """A node and all below it."""
    yield node
    for part in node.children:
        yield from nodes(part)


def plain(written: str) -> str:
    """Text without the differences that mean nothing."""
    return re.sub(r"\s+", " ", written)
