"""The analyser's C as a tree: its annotations as calls, its types and constant tables, and what an expression is."""

from __future__ import annotations

import re
from typing import Any

from pycparser import c_ast, c_generator, c_parser

from fuzzyspec.prove.lemma import ANY, Wide

ANNOTATION = re.compile(r"/\*@(.*?)\*/\s*;?", re.DOTALL)
ASSERT = re.compile(r"\s*assert\s+(?:Eva:)?\s*(?:(\w+):)?(.*);\s*$", re.DOTALL)
STDINT = "".join(
    f"typedef {base} {name};\n"
    for name, base in {
        "uint8_t": "unsigned char",
        "int8_t": "signed char",
        "uint16_t": "unsigned short",
        "int16_t": "short",
        "uint32_t": "unsigned int",
        "int32_t": "int",
        "uint_fast8_t": "unsigned int",
        "uint_fast16_t": "unsigned int",
    }.items()
)
PRELUDE = STDINT.count("typedef")
SHOW = "Frama_C_show_each_"
CLAIM = "fuzzyc_claim_"
STEPS = ("p++", "p--", "++", "--")
LONGEST = 128
"""Entries of a table."""
HINT = "fuzzyc_hint_"
LABEL, OWN, KEPT = "range_", "given_", "kept_"
"""How the assertions are named that are ours: what a local keeps to, what the driver asks, and what a loop keeps."""
TOTAL = "fuzzyc_total_"
"""How the ghost of an array is named: the sum of its elements."""


def parse(text: str) -> tuple[c_ast.FileAST, list[tuple[str, str]]]:
    """The C without includes, each assertion a call of ``CLAIM`` and its number; the kinds and texts of these."""
    claims: list[tuple[str, str]] = []

    def claim(found: re.Match[str]) -> str:
        held = ASSERT.match(found[1])
        if held is None:
            return ""
        claims.append((held[1] or "assertion", " ".join(held[2].split())))
        return f"{CLAIM}{len(claims) - 1}();"

    body = ANNOTATION.sub(claim, text)
    body = re.sub(r"/\*.*?\*/|^#[^\n]*$", "", body, flags=re.DOTALL | re.MULTILINE)
    return c_parser.CParser().parse(STDINT + body), claims


def integers(node: c_ast.FileAST) -> dict[str, Wide]:
    """The types of the unit that are integers, with their values."""
    found: dict[str, Wide] = {}
    for bits in (8, 16, 32):
        found[f"uint{bits}_t"] = (0, 2**bits - 1)
        found[f"int{bits}_t"] = (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    found |= {"uint_fast8_t": ANY, "uint_fast16_t": ANY, "int": ANY, "unsigned int": ANY, "unsigned long": ANY}
    found |= {"long": ANY, "unsigned short": (0, 65535), "unsigned char": (0, 255), "short": (-32768, 32767)}
    for item in node.ext:
        if isinstance(item, c_ast.Typedef) and item.name not in found:
            of = type_of(item.type)
            if of is not None and of in found:
                found[item.name] = found[of]
    return found


def tables(node: c_ast.FileAST) -> dict[str, tuple[int, ...]]:
    """The constant arrays of the unit that are short enough to be reasoned about."""
    found: dict[str, tuple[int, ...]] = {}
    for item in node.ext:
        if not isinstance(item, c_ast.Decl) or not isinstance(item.type, c_ast.ArrayDecl):
            continue
        if "const" in item.type.type.quals and isinstance(item.init, c_ast.InitList):
            entries = [e.expr if isinstance(e, c_ast.Cast) else e for e in item.init.exprs]
            if len(entries) <= LONGEST and all(isinstance(e, c_ast.Constant) for e in entries):
                found[item.name] = tuple(int(e.value.rstrip("uUlL"), 0) for e in entries)
    return found


def type_of(node: Any) -> str | None:
    """The name of a type that has one."""
    if isinstance(node, c_ast.TypeDecl) and isinstance(node.type, c_ast.IdentifierType):
        return " ".join(node.type.names)
    return None


def loads(node: Any) -> list[Any]:
    """What an expression reads through a pointer or from an array or structure."""
    if isinstance(node, c_ast.ArrayRef | c_ast.StructRef) or (isinstance(node, c_ast.UnaryOp) and node.op == "*"):
        return [node]
    return [load for _, child in node.children() for load in loads(child)]


def written(node: Any) -> str:
    """An expression as C."""
    text: str = c_generator.CGenerator().visit(node)
    return text


def place(node: Any) -> str:
    """What an expression reads, whatever casts of indices it is written with: the analyser holds that none loses."""
    match node:
        case c_ast.Cast():
            return place(node.expr)
        case c_ast.BinaryOp():
            return f"({place(node.left)} {node.op} {place(node.right)})"
        case c_ast.ArrayRef():
            return f"{place(node.name)}[{place(node.subscript)}]"
        case c_ast.UnaryOp():
            return f"{node.op}({place(node.expr)})"
        case _:
            return written(node)


def number(node: Any) -> int | None:
    """The value of a small constant, or of a sum, difference or product of them, whatever type it has."""
    match node:
        case c_ast.Constant(type=of) if of not in ("char", "string"):
            found: int | None = int(node.value.rstrip("uUlL"), 0)
        case c_ast.Cast():
            found = number(node.expr)
        case c_ast.BinaryOp(op="+" | "-" | "*" as op):
            a, b = number(node.left), number(node.right)
            found = None if a is None or b is None else a + b if op == "+" else a - b if op == "-" else a * b
        case _:
            return None
    return found if found is not None and 0 <= found < 128 else None


def assigned(node: Any) -> set[str]:
    """The variables that a statement may change, other than its own; of an array, its name."""
    found: set[str] = set()
    for _, child in node.children():
        found |= assigned(child)
    if isinstance(node, c_ast.Assignment) and isinstance(node.lvalue, c_ast.ArrayRef):
        found.add(written(node.lvalue.name))
    if isinstance(node, c_ast.Assignment) and isinstance(node.lvalue, c_ast.ID):
        found.add(node.lvalue.name)
    if isinstance(node, c_ast.UnaryOp) and node.op in STEPS and isinstance(node.expr, c_ast.ID):
        found.add(node.expr.name)
    return found
