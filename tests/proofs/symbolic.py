"""The generated C's kernels, read as C and run on numbers that are only known by inequalities.

Every value is a number of unlimited size, and every operation owes a proof that C's ``uint32_t`` holds its result:
where all proofs are found nothing wraps around, and C computes the very number. What is proved is proved by an SMT
solver for all inputs of the domain. Numbers are reals for the solver; that they are whole is told by the
inequalities of floors, and wherever a strict inequality of whole numbers is one of 1.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import z3
from pycparser import c_ast, c_parser

SECONDS = 300
UINT32 = 2**32 - 1
TYPES = {"uint8_t": 2**8 - 1, "uint16_t": 2**16 - 1, "uint32_t": UINT32, "uint_fast8_t": 2**8 - 1}
PRELUDE = "".join(f"typedef unsigned int {name};\n" for name in TYPES)

Value = Any
"""A Python integer, or a real term of the solver."""


class Unproved(AssertionError):
    """A claim that does not follow from what is known, or not in time."""


@dataclass
class Known:
    """What is known of all numbers so far, and names for new ones."""

    facts: list[Any] = field(default_factory=list)
    bits: dict[int, tuple[Any, Any]] = field(default_factory=dict)
    floors: dict[tuple[int, int], tuple[Any, Any]] = field(default_factory=dict)
    names: int = 0
    proofs: int = 0

    def number(self, *facts: Callable[[Any], Any]) -> Any:
        """A number of which no more is known than the facts."""
        self.names += 1
        found = z3.Real(f"n{self.names}")
        self.facts += [fact(found) for fact in facts]
        return found

    def floor(self, over: Value, by: int) -> Any:
        """``floor(over / by)`` of a whole number."""
        if isinstance(over, int):
            return over // by
        key = (z3.simplify(over).get_id(), by)
        if key not in self.floors:
            found = self.number(lambda f: by * f <= over, lambda f: by * f >= over - by + 1, lambda f: f >= 0)
            self.floors[key] = (z3.simplify(over), found)
        return self.floors[key][1]

    def bit(self, test: Any) -> Any:
        """1 where the test holds, else 0; the same number for the same test."""
        if test.get_id() not in self.bits:
            self.bits[test.get_id()] = (test, self.number(lambda b: b == z3.If(test, z3.RealVal(1), z3.RealVal(0))))
        return self.bits[test.get_id()][1]

    def prove(self, claim: Any, what: str) -> None:
        """Raises Unproved."""
        if claim is True:
            return
        solver = z3.Solver()
        solver.set("timeout", SECONDS * 1000)
        solver.add(*self.facts, z3.Not(claim))
        self.proofs += 1
        if solver.check() != z3.unsat:
            raise Unproved(f"{what}: {claim}")

    def consistent(self) -> None:
        """Raises AssertionError where what is known contradicts itself, so that anything would follow."""
        solver = z3.Solver()
        solver.set("timeout", SECONDS * 1000)
        solver.add(*self.facts)
        assert solver.check() == z3.sat, "no input is known to be possible"


def kernels(text: str) -> dict[str, c_ast.FuncDef]:
    """The static functions of numbers in generated C, by name."""
    found = re.findall(r"^static uint32_t \w+\([^)]*\)\n\{\n.*?^\}\n", text, re.MULTILINE | re.DOTALL)
    parsed = c_parser.CParser().parse(PRELUDE + "".join(found))
    return {f.decl.name: f for f in parsed.ext if isinstance(f, c_ast.FuncDef)}


class Execution:
    """One run of a kernel. ``after`` is called behind every statement with this and the statement."""

    def __init__(self, known: Known, after: Callable[[Execution, c_ast.Node], None] | None = None) -> None:
        self.known = known
        self.env: dict[str, Value] = {}
        self.types: dict[str, int] = {}
        self.result: Value = None
        self.bit: Any = None
        """1 where the last branch that was not settled was taken, else 0."""
        self.given: dict[str, Value] = {}
        """Constants that are not computed but taken as they are given."""
        self._after = after

    def call(self, function: c_ast.FuncDef, *arguments: Value) -> Value:
        """What the function returns."""
        for parameter, value in zip(function.decl.type.args.params, arguments, strict=True):
            self._declare(parameter, value)
        self._block(function.body)
        return self.result

    def prove(self, claim: Any, what: str) -> None:
        self.known.prove(claim, what)

    # --- statements --------------------------------------------------------------------------

    def _block(self, block: c_ast.Node | None) -> None:
        items = (block.block_items or []) if isinstance(block, c_ast.Compound) else [block]
        for item in items:
            if item is not None:
                self._statement(item)
                if self._after is not None:
                    self._after(self, item)

    def _statement(self, node: c_ast.Node) -> None:
        match node:
            case c_ast.Decl():
                value = self.given.get(node.name)
                self._declare(node, self.value(node.init) if value is None else value)
            case c_ast.Assignment(op="="):
                value = self.given.get(node.lvalue.name)
                self._set(node.lvalue.name, self.value(node.rvalue) if value is None else value)
            case c_ast.If():
                self._branch(node)
            case c_ast.For():
                self._loop(node)
            case c_ast.Return():
                self.result = self.value(node.expr)
            case _:
                raise NotImplementedError(type(node).__name__)

    def _declare(self, node: c_ast.Decl, value: Value) -> None:
        self.types[node.name] = TYPES[" ".join(node.type.type.names)]
        self._set(node.name, value)

    def _set(self, name: str, value: Value) -> None:
        self.prove(_le(value, self.types[name]), f"{name} holds its value")
        self.env[name] = value

    def _branch(self, node: c_ast.If) -> None:
        test = self._settled(self.test(node.cond))
        if isinstance(test, bool):
            self._block(node.iftrue if test else node.iffalse)
            return
        before = dict(self.env)
        facts = list(self.known.facts)
        sides: list[tuple[dict[str, Value], list[Any]]] = []
        for taken, body in ((test, node.iftrue), (z3.Not(test), node.iffalse)):
            self.env = dict(before)
            self.known.facts = [*facts, taken]
            self._block(body)
            sides.append((self.env, self.known.facts[len(facts) + 1 :]))
        (yes, if_yes), (no, if_no) = sides
        self.known.facts = [
            *facts,
            *(z3.Implies(test, f) for f in if_yes),
            *(z3.Implies(z3.Not(test), f) for f in if_no),
        ]
        self.bit = self.known.bit(test)
        self.env = {k: self._either(test, yes[k], no[k]) for k in before}

    def _loop(self, node: c_ast.For) -> None:
        """A counter that is known throughout."""
        (counter,) = node.init.decls
        self._statement(counter)
        while self.test(node.cond) is True:
            self._block(node.stmt)
            match node.next:
                case c_ast.UnaryOp(op="++" | "p++"):
                    self.env[counter.name] += 1
                case c_ast.UnaryOp(op="--" | "p--"):
                    self.env[counter.name] -= 1
                case _:
                    self._statement(node.next)
        assert self.test(node.cond) is False

    # --- expressions -------------------------------------------------------------------------

    def test(self, node: c_ast.Node) -> Any:
        left, right = self.value(node.left), self.value(node.right)
        if not (isinstance(left, int) and isinstance(right, int)):
            # Whole numbers: nothing lies between.
            self.known.facts.append(z3.Or(left <= right - 1, left == right, left >= right + 1))
        match node.op:
            case "<":
                return left < right
            case ">=":
                return left >= right
            case ">":
                return left > right
            case "==":
                return left == right
            case "!=":
                return left != right
        raise NotImplementedError(node.op)

    def value(self, node: c_ast.Node) -> Value:
        match node:
            case c_ast.Constant():
                return int(node.value.rstrip("uUlL"), 0)
            case c_ast.ID():
                return self.env[node.name]
            case c_ast.Cast():
                value = self.value(node.expr)
                self.prove(_le(value, TYPES[node.to_type.type.type.names[0]]), "a cast loses nothing")
                return value
            case c_ast.TernaryOp():
                return self._chosen(node)
            case c_ast.BinaryOp():
                found = self._binary(node.op, self.value(node.left), self.value(node.right))
                self.prove(_le(found, UINT32), f"`{node.op}` does not wrap around")
                return found
        raise NotImplementedError(type(node).__name__)

    def _chosen(self, node: c_ast.TernaryOp) -> Value:
        test = self._settled(self.test(node.cond))
        if isinstance(test, bool):
            return self.value(node.iftrue if test else node.iffalse)
        facts = list(self.known.facts)
        found = []
        for taken, side in ((test, node.iftrue), (z3.Not(test), node.iffalse)):
            self.known.facts.append(taken)
            found.append((self.value(side), self.known.facts[len(facts) + 1 :]))
            self.known.facts = list(facts)
        (yes, if_yes), (no, if_no) = found
        self.known.facts += [z3.Implies(test, f) for f in if_yes] + [z3.Implies(z3.Not(test), f) for f in if_no]
        return self._either(test, yes, no)

    def _either(self, test: Any, yes: Value, no: Value) -> Value:
        """``test ? yes : no``; values that differ by a constant as a sum, so that sums of bits stay sums."""
        difference = z3.simplify(_real(yes) - _real(no))
        if not z3.is_rational_value(difference):
            return z3.If(test, _real(yes), _real(no))
        if difference.as_long() == 0:
            return no
        bit = self.known.bit(test)
        return no + difference.as_long() * bit

    def _settled(self, test: Any) -> Any:
        """The test's outcome where it is known."""
        if isinstance(test, bool):
            return test
        for outcome in (True, False):
            solver = z3.Solver()
            solver.set("timeout", 1000)
            solver.add(*self.known.facts, test != outcome)
            if solver.check() == z3.unsat:
                return outcome
        return test

    def _binary(self, op: str, left: Value, right: Value) -> Value:
        match op:
            case "+":
                return left + right
            case "-":
                self.prove(_le(right, left), "a difference is not negative")
                return left - right
            case "*":
                return left * right
            case "<<":
                return left * 2**right
            case ">>":
                return self.known.floor(left, 2**right)
            case "&":
                assert isinstance(right, int) and right & (right + 1) == 0
                return left - (right + 1) * self.known.floor(left, right + 1)
            case "|":
                return self._joined(left, right)
            case "/":
                return self._divided(left, right)
        raise NotImplementedError(op)

    def _joined(self, left: Value, right: Value) -> Value:
        """``left | right`` where all of the one lies above the other's highest bit: their sum."""
        if isinstance(left, int) and isinstance(right, int):
            return left | right
        unit = next((2**bits for bits in range(32, 0, -1) if _multiple(left, 2**bits)), 1)
        self.prove(_le(right, unit - 1), "operands of `|` share no bit")
        return left + right

    def _divided(self, left: Value, right: Value) -> Value:
        self.prove(right >= 1, "no division by 0")
        return self.known.number(lambda q: q >= 0, lambda q: q * right <= left, lambda q: q * right >= left - right + 1)


def _le(value: Value, most: Value) -> Any:
    return value <= most


def _real(value: Value) -> Any:
    return z3.RealVal(value) if isinstance(value, int) else value


def _multiple(value: Value, unit: int) -> bool:
    """Whether a whole number is seen to be a multiple of ``unit``."""
    if isinstance(value, int):
        return value % unit == 0
    if z3.is_rational_value(value):
        return bool(value.as_long() % unit == 0)
    parts = value.children()
    if z3.is_add(value):
        return all(_multiple(p, unit) for p in parts)
    if z3.is_mul(value):
        return any(_multiple(p, unit) for p in parts if z3.is_rational_value(p))
    return unit == 1
