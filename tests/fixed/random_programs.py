"""Random programs in which everything depends on everything: nested branches and loops, arrays, lists, calls, state."""

from __future__ import annotations

import random
from fractions import Fraction

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    AllOf,
    AnyOf,
    Assign,
    AssignElement,
    Branch,
    CallFunction,
    Comment,
    Const,
    Define,
    DefineArray,
    Each,
    Element,
    Expr,
    Function,
    ListPort,
    Local,
    Loop,
    NotTest,
    Port,
    Program,
    ReadField,
    ReadPort,
    ReadState,
    Record,
    SetOutput,
    SetState,
    SetStatus,
    StatePort,
    StatusBit,
    Stmt,
    Table,
    Test,
    Window,
)
from fuzzyspec.model.units import ONE
from fuzzyspec.model.variable import Raw, Variable

BYTE = 255
SCALARS = ("a", "b", "c")
FIELDS = ("size", "side")
CAPACITY = 3
VARIABLES = tuple(Local(f"v{i}", "uint8", 0, BYTE) for i in range(5))
_KEPT = Variable("kept", Fraction(0), Fraction(BYTE), ONE, Raw("uint8", Fraction(1), Fraction(0), 0, BYTE), Span(0, 0))


def byte(name: str) -> Port:
    """A port of any byte."""
    return Port(name, "uint8", 0, BYTE, _KEPT)


class Writer:
    """Writes one function's body; every local and element is a byte, and results are taken modulo 256."""

    def __init__(self, dice: random.Random, *, calls: bool) -> None:
        self.dice = dice
        self.calls = calls
        self.depth = 0
        self.count = 0
        self.in_list = False
        self.counters: list[Local] = []

    def atom(self) -> Const | Local:
        """A variable, a loop's counter or a number."""
        choices = [*VARIABLES, *self.counters, Const(self.dice.randrange(256))]
        return self.dice.choice(choices)

    def leaf(self) -> Expr:
        """An atom, or something read."""
        kind = self.dice.randrange(8)
        if kind == 0:
            return Element("cells", "uint8", self.index(), 0, BYTE, False)
        if kind == 1:
            return Element("squares", "uint8", self.index(), 0, BYTE, True)
        if kind == 7:
            return Element("view", "uint8", build.shift_right(self.index(), 1), 0, BYTE, True)
        if kind == 2:
            return ReadState("kept", "uint8", 0, BYTE)
        if kind == 3 and self.in_list:
            return ReadField("items", self.dice.choice(FIELDS), "uint8", 0, BYTE)
        if kind == 4:
            return ReadPort(self.dice.choice(SCALARS), "uint8", 0, BYTE)
        return self.atom()

    def index(self) -> Expr:
        """0 .. 7, out of a variable."""
        return build.shift_right(self.dice.choice(VARIABLES), 5)

    def byte(self) -> Expr:
        """Any expression modulo 256."""
        a, b = self.leaf(), self.leaf()
        match self.dice.randrange(9):
            case 0:
                value = build.add(a, b)
            case 1:
                value = build.sub(build.add(a, Const(256)), b)
            case 2:
                value = build.mul(a, b)
            case 3:
                value = build.least(self.atom(), self.atom())
            case 4:
                value = build.above(self.atom(), self.atom())
            case 5:
                value = build.select(self.test(), a, b)
            case 6:
                value = build.greatest(self.atom(), self.atom())
            case 7:
                value = build.mul_high(build.shift_left(a, 12), b)
            case _:
                value = build.shift_right(build.quotient(a, b), 8)
        if value.hi <= BYTE:
            return value
        return build.sub_guarded(value, build.shift_left(build.shift_right(value, 8), 8), BYTE)

    def test(self) -> Test:
        """A comparison, or several joined."""
        first = build.compare(self.dice.choice(("<", "<=", ">", ">=", "==", "!=")), self.leaf(), self.atom())
        match self.dice.randrange(5):
            case 0:
                return AllOf((first, build.compare("<", self.leaf(), self.atom())))
            case 1:
                return AnyOf((first, build.compare("==", self.leaf(), self.atom())))
            case 2:
                return NotTest(first)
            case _:
                return first

    def block(self, size: int) -> tuple[Stmt, ...]:
        """Some statements."""
        self.depth += 1
        found = tuple(self.statement() for _ in range(self.dice.randint(1, size)))
        self.depth -= 1
        return found

    def key(self) -> str:
        """A decision's key of its own."""
        self.count += 1
        return f"d{self.count}"

    def statement(self) -> Stmt:
        """Any statement; blocks end at a depth of 4."""
        kind = self.dice.randrange(13 if self.depth < 4 else 8)
        match kind:
            case 0 | 1:
                return Assign(self.dice.choice(VARIABLES), self.byte())
            case 2:
                return AssignElement("cells", "uint8", self.index(), self.byte())
            case 3:
                return SetStatus(self.dice.choice(("ODD", "EVEN")))
            case 4:
                return SetOutput(self.dice.choice(("y", "z")), self.byte())
            case 5:
                return SetState("kept", self.byte())
            case 6:
                return Record(self.key(), self.test())
            case 7:
                return Record(self.key(), self.byte())
            case 8 | 9:
                return Branch(self.test(), self.block(3), self.block(2) if self.dice.random() < 0.6 else ())
            case 10:
                counter = Local(f"i{self.depth}", "uint8", 0, 2)
                if counter in self.counters:
                    return Comment("the counter is taken")
                self.counters.append(counter)
                body = self.block(3)
                self.counters.remove(counter)
                return Loop(counter, 3, body)
            case 11 if self.calls and not self.in_list:
                self.in_list = True
                body = self.block(4)
                self.in_list = False
                return Each("items", Local("n", "uint8", 0, CAPACITY - 1), body)
            case 12 if self.calls:
                self.count += 1
                arguments = tuple(self.byte() for _ in SCALARS)
                # A call declares what it returns, so its results are locals of its own.
                y, z = (Local(f"{o}{self.count}", "uint8", 0, BYTE) for o in "yz")
                call = CallFunction(
                    f"call{self.count}", "inner", arguments, (("y", y), ("z", z)), "inner", (("ODD", "EVEN"),)
                )
                kept = (Assign(v, o) for v, o in zip(self.dice.sample(VARIABLES, 2), (y, z), strict=True))
                return Branch(self.test(), (call, *kept))
            case _:
                return Assign(self.dice.choice(VARIABLES), self.byte())


def _function(name: str, dice: random.Random, *, outer: bool) -> Function:
    writer = Writer(dice, calls=outer)
    start: list[Stmt] = [Define(v, writer_start, False) for v, writer_start in zip(VARIABLES, _starts(), strict=True)]
    start.append(DefineArray("cells", "uint8", 8))
    start.append(Window("view", "uint8", "squares", build.shift_right(VARIABLES[0], 6)))
    inputs: tuple[Port | ListPort, ...] = tuple(byte(n) for n in SCALARS)
    if outer:
        inputs = (*inputs, ListPort("items", CAPACITY, tuple(byte(f) for f in FIELDS)))
    bits = [StatusBit(b, "set at random") for b in ("ODD", "EVEN")]
    return Function(
        name,
        "system" if outer else "controller",
        inputs,
        (byte("y"), byte("z")),
        (StatePort("kept", "uint8", 17, 0, BYTE, _KEPT),),
        (("inner", "inner"),) if outer else (),
        (*bits, StatusBit("OVERRUN_ITEMS", "too many items")) if outer else tuple(bits),
        (Table("squares", "uint8", tuple(k * k for k in range(8))),),
        (),
        (*start, *writer.block(12), *(SetOutput(o, v) for o, v in zip("yz", VARIABLES, strict=False))),
    )


def _starts() -> list[Expr]:
    ports: list[Expr] = [ReadPort(n, "uint8", 0, BYTE) for n in SCALARS]
    return [*ports, Const(0), Const(200)]


def program(seed: int) -> Program:
    """A function ``outer`` over three numbers and a list, that calls ``inner``; both keep a byte."""
    dice = random.Random(seed)
    return Program("p", (_function("inner", dice, outer=False), _function("outer", dice, outer=True)))
