"""Random programs over every node and statement, built by the constructors that derive intervals."""

from __future__ import annotations

import random

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    AllOf,
    AnyOf,
    Assign,
    AssignElement,
    Branch,
    Comment,
    Const,
    CType,
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
    SetOutput,
    SetStatus,
    StatusBit,
    Stmt,
    Table,
    Test,
    Window,
)

TYPES: tuple[CType, ...] = ("uint8", "int8", "uint16", "int16", "uint32", "int32")
_CONSTANTS = (
    0,
    1,
    2,
    3,
    5,
    7,
    100,
    127,
    128,
    255,
    256,
    1000,
    32767,
    32768,
    40000,
    65535,
    65536,
    99999,
    2**24,
    2**31 - 1,
)


class Maker:
    """Grows expressions; what leaves 32 bits is thrown away and tried again."""

    def __init__(self, seed: int) -> None:
        self.dice = random.Random(seed)
        self.atoms: list[Expr] = []
        self.body: list[Stmt] = []
        self.tables: list[Table] = []
        self.count = 0

    def name(self, stem: str) -> str:
        """A name that no other local has."""
        self.count += 1
        return f"{stem}_{self.count}"

    def constant(self) -> Const:
        """A constant near the edges of the types, of either sign."""
        value = self.dice.choice(_CONSTANTS)
        return Const(-value if self.dice.random() < 0.3 else value)

    def atom(self) -> Expr:
        """A local or a constant."""
        return self.constant() if self.dice.random() < 0.25 else self.dice.choice(self.atoms)

    def expression(self, depth: int) -> Expr:
        """A tree of at most that depth."""
        if depth == 0:
            return self.atom()
        for _ in range(50):
            try:
                node = self._node(depth)
            except build.RangeError:
                continue
            if build.fits((node.lo, node.hi)):
                return node
        return self.atom()

    def _node(self, depth: int) -> Expr:
        left, right = self.expression(depth - 1), self.expression(depth - 1)
        match self.dice.randrange(14):
            case 0 | 1:
                return build.add(left, right)
            case 2 | 3:
                return build.sub(left, right)
            case 4 | 5:
                return build.mul(left, right)
            case 6:
                return build.floor_div(left, right)
            case 7:
                return build.shift_right(left, self.dice.randrange(20))
            case 8:
                return build.shift_left(left, self.dice.randrange(12))
            case 9:
                return build.least(self.atom(), self.atom())
            case 10:
                return build.greatest(self.atom(), self.atom())
            case 11:
                return build.above(self.atom(), self.atom())
            case 12:
                return build.select(self.test(1), left, right)
            case _:
                if self.dice.random() < 0.5:
                    return build.mul_high(left, build.shift_right(right, 16))
                return build.quotient(left, right)

    def test(self, depth: int) -> Test:
        """A comparison, or several joined."""
        kind = self.dice.randrange(6) if depth else 0
        operands = tuple(self.test(depth - 1) for _ in range(2)) if kind > 2 else ()
        match kind:
            case 3:
                return AllOf(operands)
            case 4:
                return AnyOf(operands)
            case 5:
                return NotTest(operands[0])
            case _:
                while True:
                    try:
                        op = self.dice.choice(("<", "<=", ">", ">=", "==", "!="))
                        return build.compare(op, self.expression(1), self.atom())
                    except build.RangeError:
                        continue

    def define(self, value: Expr, stem: str = "v", constant: bool = True) -> Local:
        """A local of any type that holds the value."""
        fits = [t for t in TYPES if build.LIMITS[t][0] <= value.lo and value.hi <= build.LIMITS[t][1]]
        local = Local(self.name(stem), self.dice.choice(fits), value.lo, value.hi)
        self.body.append(Define(local, value, constant))
        return local

    def table_read(self) -> Expr:
        """An element of a new table, at an index in its bounds."""
        ctype = self.dice.choice(TYPES)
        low, high = build.LIMITS[ctype]
        values = tuple(self.dice.choice((low, high, self.dice.randint(low, high))) for _ in range(8))
        table = Table(self.name("table"), ctype, values)
        self.tables.append(table)
        at = self.define(self.atom_index(), "at")
        if self.dice.random() < 0.3:
            half = self.define(build.shift_right(at, 1), "half")
            view = Window(self.name("view"), ctype, table.name, half)
            self.body.append(view)
            return Element(view.name, ctype, Const(self.dice.randrange(5)), min(values), max(values), table=True)
        return Element(table.name, ctype, at, min(values), max(values), table=True)

    def atom_index(self) -> Expr:
        """0 .. 7, from a wide unsigned local."""
        wide = [a for a in self.atoms if a.lo == 0 and a.hi >= 2**16 - 1]
        source = self.dice.choice(wide)
        return build.shift_right(source, source.hi.bit_length() - 3)


def scalar_program(seed: int, count: int = 60, depth: int = 3) -> Program:
    """A port of each type, tables, an array in a loop, branches, and ``count`` random expressions as outputs."""
    maker = Maker(seed)
    inputs = tuple(Port(f"p{i}", t, *build.LIMITS[t], None) for i, t in enumerate(TYPES))
    for port in inputs:
        maker.atoms.append(maker.define(ReadPort(port.name, port.ctype, port.lo, port.hi), "in"))
    for _ in range(4):
        maker.atoms.append(maker.define(maker.table_read(), "entry"))
    array = maker.name("array")
    counter = Local(maker.name("i"), "uint8", 0, 7)
    index = maker.define(maker.atom_index(), "slot")
    maker.body += [
        Comment("an array, filled by a loop"),
        DefineArray(array, "uint32", 8),
        Loop(
            counter,
            8,
            (
                AssignElement(array, "uint32", counter, build.mul(counter, counter)),
                Branch(maker.test(2), (AssignElement(array, "uint32", index, Const(2**32 - 1)),)),
            ),
        ),
    ]
    maker.atoms.append(maker.define(Element(array, "uint32", index, 0, 2**32 - 1, table=False), "kept"))
    outputs: list[Port] = []
    for number in range(count):
        value = maker.expression(depth)
        lo, hi = value.lo, value.hi
        changed = maker.expression(1)
        low, high = min(lo, changed.lo), max(hi, changed.hi)
        if low < 0 and high >= 2**31:
            low, high, changed = lo, hi, value
        held = Local(maker.name("v"), build.smallest_type(low, high), low, high)
        maker.body.append(Define(held, value, False))
        maker.body.append(Branch(maker.test(2), (Assign(held, changed),), (SetStatus("ELSE"),)))
        outputs.append(Port(f"q{number}", held.ctype, low, high, None))
        maker.body.append(SetOutput(outputs[-1].name, held))
        if maker.dice.random() < 0.3:
            maker.atoms.append(maker.define(maker.expression(2)))
    status = (StatusBit("ELSE", "some branch was not taken"),)
    tables = tuple(maker.tables)
    function = Function("mixed", "controller", inputs, tuple(outputs), (), (), status, tables, (), tuple(maker.body))
    return Program("rnd", (function,))


def list_program(capacity: int) -> Program:
    """A system that sums and picks over a list; the count may exceed the capacity."""
    fields = (Port("weight", "int16", -100, 100, None), Port("level", "uint8", 0, 255, None))
    total = Local("total", "int32", -(2**24), 2**24)
    top = Local("top", "uint8", 0, 255)
    counter = Local("k", "uint8", 0, max(capacity - 1, 0))
    weight, level = Local("weight", "int16", -(2**15), 2**15 - 1), Local("level", "uint8", 0, 255)
    body: tuple[Stmt, ...] = (
        Define(total, Const(0), False),
        Define(top, Const(0), False),
        Each(
            "items",
            counter,
            (
                Define(weight, ReadField("items", "weight", "int16", -(2**15), 2**15 - 1), True),
                Define(level, ReadField("items", "level", "uint8", 0, 255), True),
                Branch(build.compare(">", level, Const(3)), (Assign(top, level),)),
                Assign(total, build.add(Local("total", "int32", -(2**23), 2**23), build.add(weight, counter))),
            ),
        ),
        SetOutput("total", total),
        SetOutput("top", top),
    )
    outputs = (Port("total", "int32", -(2**24), 2**24, None), Port("top", "uint8", 0, 255, None))
    status = (StatusBit("OVERRUN_ITEMS", "more items than fit"),)
    inputs = (ListPort("items", capacity, fields),)
    return Program("lists", (Function("lists", "system", inputs, outputs, (), (), status, (), (), body),))
