"""From the analyser's C, with its alarms as annotations, to what is to be proved of each."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from itertools import count
from typing import Any

from pycparser import c_ast, c_generator, c_parser

from fuzzyspec.prove.lemma import ANY, Expr, Facts, Num, Obligation, Op, Var, Version, Wide

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


class Unread(Exception):
    """An expression of more than integers."""


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


def obligations(text: str, shown: Mapping[int, Wide]) -> list[Facts]:
    """What is to be proved of each function of the analyser's C, and what is known there."""
    unit, claims = parse(text)
    types, constant = integers(unit), tables(unit)
    functions = (item for item in unit.ext if isinstance(item, c_ast.FuncDef))
    return [Reader(item, types, claims, shown, constant).facts for item in functions]


class Reader:
    """Walks one function; every assignment makes a new value."""

    def __init__(
        self,
        function: c_ast.FuncDef,
        types: Mapping[str, Wide],
        claims: list[tuple[str, str]],
        shown: Mapping[int, Wide],
        tables: Mapping[str, tuple[int, ...]],
    ) -> None:
        self.facts = Facts()
        self._types, self._claims, self._shown = types, claims, shown
        self._name = function.decl.name
        self._now: dict[str, str] = {}
        self._scalars: dict[str, Wide] = {}
        self._path: tuple[Expr, ...] = ()
        self._numbers = count()
        for parameter in function.decl.type.args.params if function.decl.type.args else ():
            of = type_of(parameter.type)
            if of is not None and of in types:
                self._scalars[parameter.name] = types[of]
                self._new(parameter.name, None)
        self._tables = tables
        self._loaded: dict[str, str] = {}
        """What was read last from each place, as it is written, until the statement that reads it has ended."""
        self._stored = ("", "")
        """The element that was set last, as it is written, and its value; until the next statement but claims."""
        self._walk(function.body)

    # --- values ---------------------------------------------------------------------------------

    def _fresh(self, name: str, within: Wide, definition: Expr | None) -> str:
        version = Version(f"{name}#{next(self._numbers)}", within, definition, self._path)
        self.facts.versions[version.name] = version
        return version.name

    def _new(self, name: str, definition: Expr | None) -> None:
        self._now[name] = self._fresh(name, self._scalars[name], definition)

    def _narrow(self, name: str, within: Wide) -> None:
        """What the analyser saw of the value that a variable has just got."""
        at = self._now.get(name)
        if at is not None:
            known = self.facts.versions[at]
            lo, hi = max(known.range[0], within[0]), min(known.range[1], within[1])
            if lo <= hi:
                self.facts.versions[at] = replace(known, range=(lo, hi))

    # --- statements -----------------------------------------------------------------------------

    def _walk(self, node: Any) -> None:
        if not isinstance(node, c_ast.FuncCall):
            self._stored = ("", "")
        self._statement(node)
        if not isinstance(node, c_ast.FuncCall):
            self._loaded = {}

    def _statement(self, node: Any) -> None:
        match node:
            case c_ast.Compound():
                for item in node.block_items or ():
                    self._walk(item)
            case c_ast.Decl():
                of = type_of(node.type)
                if of is not None and of in self._types:
                    self._scalars[node.name] = self._types[of]
                    self._new(node.name, self._value(node.init) if node.init is not None else None)
            case c_ast.Assignment() if isinstance(node.lvalue, c_ast.ID) and node.lvalue.name in self._scalars:
                value = node.rvalue
                if node.op != "=":
                    value = c_ast.BinaryOp(node.op[:-1], node.lvalue, node.rvalue)
                self._new(node.lvalue.name, self._value(value))
            case c_ast.Assignment() if isinstance(node.lvalue, c_ast.ArrayRef):
                self._stored = place(node.lvalue), self._fresh("element", ANY, self._value(node.rvalue))
            case c_ast.UnaryOp(op=op) if op in STEPS and isinstance(node.expr, c_ast.ID):
                step = Op(op[-1], (self._value(node.expr), Num(1)))
                self._new(node.expr.name, step)
            case c_ast.If():
                self._branch(node)
            case c_ast.While():
                self._loop(node)
            case c_ast.FuncCall() if isinstance(node.name, c_ast.ID):
                self._call(node)
            case _:
                pass

    def _call(self, node: c_ast.FuncCall) -> None:
        name = node.name.name
        if name.startswith(SHOW):
            number, seen = int(name.removeprefix(SHOW)), node.args.exprs[0]
            while isinstance(seen, c_ast.Cast):
                seen = seen.expr
            if isinstance(seen, c_ast.ID):
                self._narrow(seen.name, self._shown.get(number, ANY))
            else:
                self._loaded[place(seen)] = self._fresh("load", self._shown.get(number, ANY), None)
        elif name.startswith(CLAIM):
            kind, text = self._claims[int(name.removeprefix(CLAIM))]
            if kind.startswith(KEPT):
                # Proved before the loop and at the end of its body, by claims of the same words.
                kept = self._claim(text)
                self._path = self._path if kept is None else (*self._path, kept)
                return
            self.facts.obligations.append(Obligation(self._name, kind, text, self._claim(text), self._path))

    def _branch(self, node: c_ast.If) -> None:
        condition = self._value(node.cond)
        self._loaded = {}
        path, before = self._path, dict(self._now)
        self._path = (*path, condition)
        self._walk(node.iftrue)
        then = self._now
        self._now, self._path = dict(before), (*path, Op("!", (condition,)))
        self._walk(node.iffalse)
        other = self._now
        self._now, self._path = dict(before), path
        for name in before:
            if then[name] != other[name]:
                self._new(name, Op("?", (condition, Var(then[name]), Var(other[name]))))

    def _loop(self, node: c_ast.While) -> None:
        before, path = dict(self._now), self._path
        for name in sorted(assigned(node.stmt)):
            if name in self._now:
                self._new(name, None)
        head = dict(self._now)
        condition = self._value(node.cond)
        self._path = (*path, condition)
        self._walk(node.stmt)
        self._path = path
        self._now = dict(head.items())
        for name in sorted(assigned(node.stmt)):
            if name in before:
                self._new(name, None)

    # --- expressions ----------------------------------------------------------------------------

    def _claim(self, text: str) -> Expr | None:
        if "\\" in text:
            return None
        try:
            return self._chain(text)
        except (c_parser.ParseError, Unread):
            return None

    def _chain(self, text: str) -> Expr:
        """``0 <= a < b`` is two comparisons; C's grammar reads it from the left."""
        unit = c_parser.CParser().parse(f"{STDINT}int f(void) {{ return {text}; }}")
        tree = unit.ext[-1].body.block_items[0].expr
        parts: list[Expr] = []
        while (
            isinstance(tree, c_ast.BinaryOp)
            and tree.op in ("<", "<=", ">", ">=")
            and isinstance(tree.left, c_ast.BinaryOp)
            and tree.left.op in ("<", "<=", ">", ">=")
        ):
            parts.append(Op(tree.op, (self._value(tree.left.right), self._value(tree.right))))
            tree = tree.left
        parts.append(self._value(tree))
        claim = parts[0]
        for part in parts[1:]:
            claim = Op("&&", (claim, part))
        return claim

    def _value(self, node: Any) -> Expr:
        match node:
            case c_ast.Constant(type="char" | "string"):
                raise Unread
            case c_ast.Constant():
                return Num(int(node.value.rstrip("uUlL"), 0))
            case c_ast.ID() if node.name in self._now:
                return Var(self._now[node.name])
            case c_ast.BinaryOp():
                return Op(node.op, (self._value(node.left), self._value(node.right)))
            case c_ast.UnaryOp(op="-" | "!" | "+"):
                inner = self._value(node.expr)
                return inner if node.op == "+" else Op("neg" if node.op == "-" else "!", (inner,))
            case c_ast.TernaryOp():
                return Op("?", (self._value(node.cond), self._value(node.iftrue), self._value(node.iffalse)))
            case c_ast.Cast():
                return self._cast(type_of(node.to_type.type), self._value(node.expr))
            case c_ast.ArrayRef() if self._stored[0] == place(node):
                return Var(self._stored[1])
            case c_ast.ArrayRef(name=c_ast.ID()) if node.name.name in self._tables:
                return self._looked_up(self._tables[node.name.name], self._value(node.subscript))
            case c_ast.ArrayRef() | c_ast.StructRef() | c_ast.UnaryOp(op="*"):
                if place(node) not in self._loaded:
                    self._loaded[place(node)] = self._fresh("load", ANY, None)
                return Var(self._loaded[place(node)])
            case _:
                return Var(self._fresh("unread", ANY, None))

    def _looked_up(self, table: tuple[int, ...], index: Expr) -> Expr:
        """An entry of a constant table, by its index."""
        entry: Expr = Num(table[-1])
        for at in range(len(table) - 2, -1, -1):
            entry = Op("?", (Op("<=", (index, Num(at))), Num(table[at]), entry))
        return entry

    def _cast(self, to: str | None, value: Expr) -> Expr:
        found = self._types.get(to or "")
        if found is None:
            return Var(self._fresh("cast", ANY, None))
        if found == ANY:
            return value
        lo, hi = found
        return Op(f"{'sign' if lo < 0 else 'wrap'}{(hi - lo).bit_length()}", (value,))


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


def assigned(node: Any) -> set[str]:
    """The variables that a statement may change, other than its own."""
    found: set[str] = set()
    for _, child in node.children():
        found |= assigned(child)
    if isinstance(node, c_ast.Assignment) and isinstance(node.lvalue, c_ast.ID):
        found.add(node.lvalue.name)
    if isinstance(node, c_ast.UnaryOp) and node.op in STEPS and isinstance(node.expr, c_ast.ID):
        found.add(node.expr.name)
    return found
