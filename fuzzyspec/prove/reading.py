"""From the analyser's C, with its alarms as annotations, to what is to be proved of each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import count
from typing import Any

from pycparser import c_ast, c_parser

from fuzzyspec.prove.annotated import (
    CLAIM,
    KEPT,
    SHOW,
    STDINT,
    STEPS,
    TOTAL,
    assigned,
    integers,
    number,
    parse,
    place,
    tables,
    type_of,
    written,
)
from fuzzyspec.prove.lemma import ANY, Expr, Facts, Num, Obligation, Op, Var, Version, Wide


class Unread(Exception):
    """An expression of more than integers."""


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
        self._arrays: dict[str, int] = {}
        """The arrays of the function's own that hold integers, with their sizes: elements are values by their index."""
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
            case c_ast.Decl(type=c_ast.ArrayDecl(type=element, dim=dim)):
                size, of = number(dim), type_of(element)
                if size is not None and of is not None and of in self._types:
                    self._arrays[node.name] = size
                    for at in range(size):
                        self._scalars[f"{node.name}[{at}]"] = self._types[of]
                    self._forget({node.name})
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
                self._store(node)
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
            at, seen = int(name.removeprefix(SHOW)), node.args.exprs[0]
            while isinstance(seen, c_ast.Cast):
                seen = seen.expr
            if isinstance(seen, c_ast.ID):
                self._narrow(seen.name, self._shown.get(at, ANY))
            elif (element := self._element(seen)) is not None:
                self._value(seen)
                self._narrow(element, self._shown.get(at, ANY))
            else:
                self._loaded[place(seen)] = self._fresh("load", self._shown.get(at, ANY), None)
        elif name.startswith(CLAIM):
            kind, text = self._claims[int(name.removeprefix(CLAIM))]
            if kind.startswith(KEPT):
                # Proved before the loop and at the end of its body, by claims of the same words.
                kept = self._claim(text)
                self._path = self._path if kept is None else (*self._path, kept)
                return
            self.facts.obligations.append(Obligation(self._name, kind, text, self._claim(text), self._path))

    # --- elements of arrays ---------------------------------------------------------------------

    def _element(self, node: Any) -> str | None:
        """How an element is named that is a value of its own, or None."""
        if isinstance(node, c_ast.ArrayRef) and isinstance(node.name, c_ast.ID) and node.name.name in self._arrays:
            at = number(node.subscript)
            if at is not None and at < self._arrays[node.name.name]:
                return f"{node.name.name}[{at}]"
        return None

    def _store(self, node: c_ast.Assignment) -> None:
        target: Any = node.lvalue
        value = node.rvalue if node.op == "=" else c_ast.BinaryOp(node.op[:-1], target, node.rvalue)
        element = self._element(target)
        stored = self._value(value)
        if element is not None:
            self._looked_into(element)
            self._new(element, stored)
            return
        self._forget({written(target.name)})
        self._stored = place(target), self._fresh("element", ANY, stored)

    def _forget(self, changed: set[str]) -> None:
        """Of variables that may have changed nothing is known any more, nor of the elements of arrays."""
        for name in sorted(self._now):
            array, bracket, _ = name.partition("[")
            if array in changed and bracket:
                del self._now[name]
            elif name in changed:
                self._new(name, None)

    def _looked_into(self, element: str) -> Expr:
        """An element's value; where nothing is known of any element of the array, the ghost tells their sum."""
        if element not in self._now:
            array = element.partition("[")[0]
            others = [n for n in (f"{array}[{at}]" for at in range(self._arrays[array])) if n != element]
            rest: Expr | None = None
            if TOTAL + array in self._now and not any(n in self._now for n in others):
                rest = Var(self._now[TOTAL + array])
                for name in others:
                    self._new(name, None)
                    rest = Op("-", (rest, Var(self._now[name])))
            self._new(element, rest)
        return Var(self._now[element])

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
            if name not in then or name not in other:
                del self._now[name]
            elif then[name] != other[name]:
                self._new(name, Op("?", (condition, Var(then[name]), Var(other[name]))))

    def _loop(self, node: c_ast.While) -> None:
        path, changed = self._path, assigned(node.stmt)
        self._forget(changed)
        head = dict(self._now)
        condition = self._value(node.cond)
        self._path = (*path, condition)
        self._walk(node.stmt)
        self._path = path
        self._now = head
        self._forget(changed)

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
            case c_ast.ArrayRef() if (element := self._element(node)) is not None:
                return self._looked_into(element)
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
