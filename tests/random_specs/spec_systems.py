"""Systems of random specs: typed expressions over inputs, lists, folds and calls, with their intervals."""

from __future__ import annotations

import itertools
import random
from dataclasses import dataclass, field
from fractions import Fraction

from tests.random_specs.spec_controllers import Written
from tests.random_specs.spec_numbers import TYPES, UNITS, Numbers, Ranged, coherent, legal, number

ZERO = Fraction(0)
LARGEST = Fraction(10**6)
"""Values beyond this are clamped: what is left stays in proportion."""
QUOTIENTS = {("m", "s"): "m/s", ("m", "m/s"): "s"}
PRODUCTS = {("m/s", "s"): "m"}
PI_OVER_180 = Fraction(245850922, 78256779) / 180


@dataclass(frozen=True)
class Value:
    """Text of an expression, its dimension, and its interval in coherent units."""

    text: str
    dim: str
    lo: Fraction
    hi: Fraction


@dataclass
class Scope:
    """What may be named at a place; ``element`` is the loop variable there, with the fields of its list."""

    values: list[Value] = field(default_factory=list)
    element: list[Value] = field(default_factory=list)
    lists: dict[str, list[Value]] = field(default_factory=dict)
    """Fields and lets of each list, named after ``o``."""
    capacity: dict[str, int] = field(default_factory=dict)


class Systems:
    """Draws systems."""

    def __init__(self, dice: random.Random) -> None:
        self.dice = dice
        self.numbers = Numbers(dice)
        self.scope = Scope()
        self.folding = True

    def system(self, name: str, controllers: list[Written]) -> str:
        """One system that calls all of these."""
        r = self.dice
        self.scope = Scope()
        lines = [f"system {name} {{", "  param gain = 1.7", "  param pace = 0.43 m/s"]
        gain = Value("gain", "1", Fraction(17, 10), Fraction(17, 10))
        third = Value("third", "1", Fraction(1, 3), Fraction(1, 3))
        self.scope.values = [gain, third, Value("pace", "m/s", Fraction(43, 100), Fraction(43, 100))]
        lines += self.inputs()
        lines += self.lists(controllers)
        acting: list[str] = []
        for i, c in enumerate(controllers):
            call = f"c{i}"
            arguments = [f"{n}: {self.placed(over)}" for n, over in c.inputs.items()]
            r.shuffle(arguments)
            lines.append(f"  let {call} = {c.name}({', '.join(arguments)}{r.choice(('', '', ','))})")
            self.scope.values += [self.read(f"{call}.{o}", over) for o, over in c.outputs.items()]
            if c.behaviors:
                acting.append(call)
            if r.random() < 0.4:
                value = self.any()
                lines.append(f"  let k{i} = {value.text}")
                self.scope.values.append(Value(f"k{i}", value.dim, value.lo, value.hi))
        last = len(controllers) - 1
        if controllers:
            name, over = next(iter(controllers[-1].outputs.items()))
            raws = ["", ""] + [f" raw {t}" for t in TYPES if legal(over.lo, over.hi, t)]
            lines.append(f"  output y{r.choice(raws)} = c{last}.{name}")
        lines += [f"  output who{i} = {call}.acting" for i, call in enumerate(acting) if r.random() < 0.7]
        for i in range(r.choice((1, 1, 2))):
            over = self.numbers.ranged()
            lines.append(f"  output z{i} in {over} = {self.placed(over)}")
        free = self.any()
        if free.hi - free.lo > max(abs(free.lo), abs(free.hi)) / 500:
            lines.append(f"  output free{r.choice(('', ' raw int16'))} = {free.text}")
        return "\n".join([*lines, "}"])

    def inputs(self) -> list[str]:
        """Scalar inputs, one from 0 among them (a divisor that can be 0)."""
        lines: list[str] = []
        for i in range(self.dice.randint(1, 3)):
            over = self.numbers.ranged(from_zero=i == 0)
            lines.append(f"  input u{i} in {over}")
            self.scope.values.append(self.read(f"u{i}", over))
        return lines

    def read(self, name: str, over: Ranged) -> Value:
        """Something of a declared range."""
        return Value(name, over.dim, *over.coherent)

    # --- lists ------------------------------------------------------------------------------------

    def lists(self, controllers: list[Written]) -> list[str]:
        """Lists with their loops, then folds over them."""
        lines: list[str] = []
        for name in self.dice.choice(((), ("items",), ("items",), ("items", "marks"))):
            capacity = self.dice.choice((1, 2, 3, 16, 255))
            fields = {f"f{k}": self.numbers.ranged() for k in range(self.dice.randint(1, 3))}
            declared = ", ".join(f"{f} in {over}" for f, over in fields.items())
            lines.append(f"  input {name}[{capacity}] {{ {declared}{self.dice.choice(('', '', ','))} }}")
            self.scope.lists[name] = [self.read(f"o.{f}", over) for f, over in fields.items()]
            self.scope.capacity[name] = capacity
        for name in self.scope.lists:
            for turn in range(self.dice.choice((0, 0, 1, 1, 2))):
                lines += self.loop(name, turn, controllers)
            for turn in range(self.dice.choice((1, 1, 2))):
                fold = self.fold(name)
                lines.append(f"  let seen_{name}{turn} = {fold.text}")
                self.scope.values.append(Value(f"seen_{name}{turn}", fold.dim, fold.lo, fold.hi))
            if self.dice.random() < 0.3:
                self.scope.values.append(Value(f"{name}.count", "1", ZERO, Fraction(self.scope.capacity[name])))
        return lines

    def loop(self, name: str, turn: int, controllers: list[Written]) -> list[str]:
        """``for each`` with lets, and a call where a controller holds nothing."""
        self.scope.element = list(self.scope.lists[name])
        body: list[str] = []
        for k in range(self.dice.choice((1, 1, 1, 2, 2, 2, 0))):
            value = self.any()
            body.append(f"    let o.g{turn}{k} = {value.text}")
            self.scope.element.append(Value(f"o.g{turn}{k}", value.dim, value.lo, value.hi))
        free = [c for c in controllers if not c.holds]
        if free and self.dice.random() < 0.4:
            called = self.dice.choice(free)
            output, over = self.dice.choice(list(called.outputs.items()))
            arguments = ", ".join(f"{n}: {self.placed(o)}" for n, o in called.inputs.items())
            body.append(f"    let o.c{turn} = {called.name}({arguments}).{output}")
            self.scope.element.append(self.read(f"o.c{turn}", over))
        self.scope.lists[name], self.scope.element = self.scope.element, []
        return [f"  for each o in {name} {{", *body, "  }"]

    def fold(self, name: str) -> Value:
        """max, min, sum or count over a list, with or without a test."""
        capacity = self.scope.capacity[name]
        kind = self.dice.choice(("max", "min", "sum", "count"))
        outer, self.scope.element = self.scope.element, list(self.scope.lists[name])
        self.folding, nested = False, self.folding
        # What is folded speaks of the element most of the time, else it would be the same for all.
        body = self.dice.choice(self.scope.element) if self.dice.random() < 0.5 else self.any()
        test = f" if {self.test(1)}" if self.dice.random() < 0.6 else ""
        self.folding, self.scope.element = nested, outer
        if kind == "count":
            return Value(f"count(o for o in {name}{test})", "1", ZERO, Fraction(capacity))
        head = f"{kind}({body.text} for o in {name}{test}"
        if kind == "sum":
            return self.tamed(Value(f"{head})", body.dim, min(ZERO, capacity * body.lo), max(ZERO, capacity * body.hi)))
        other = self.of(body.dim, 1) if self.dice.random() < 0.3 else self.constant(body.dim)
        return Value(f"{head}, otherwise {other.text})", body.dim, min(body.lo, other.lo), max(body.hi, other.hi))

    # --- expressions --------------------------------------------------------------------------------

    def any(self) -> Value:
        """An expression of some dimension that there is something of."""
        return self.of(self.dice.choice([*self.scope.values, *self.scope.element]).dim, 2)

    def known(self, dim: str) -> list[Value]:
        """What can be named, the element's own first."""
        return [v for v in (*self.scope.element, *self.scope.element, *self.scope.values) if v.dim == dim]

    def constant(self, dim: str) -> Value:
        """A literal."""
        unit = self.dice.choice(UNITS[dim])
        value = self.numbers.decimal(-9, 60)
        if self.dice.random() < 0.2:
            value = ZERO
        text = number(abs(value)) + (f" {unit}" if unit else "")
        if value < 0:
            unit_value = -coherent(-value, unit)
            return Value(f"(-{text})", dim, unit_value, unit_value) if unit != "degC" else self.constant(dim)
        at = coherent(value, unit)
        return Value(text, dim, at, at)

    def leaf(self, dim: str) -> Value:
        """Something named, else a literal."""
        known = self.known(dim)
        return self.dice.choice(known) if known and self.dice.random() < 0.85 else self.constant(dim)

    def of(self, dim: str, depth: int) -> Value:
        """An expression of a dimension."""
        if depth == 0 or self.dice.random() < 0.15:
            return self.leaf(dim)
        return self.tamed(self.compound(dim, depth - 1))

    def tamed(self, value: Value) -> Value:
        """The value, clamped where it could be out of proportion."""
        if max(abs(value.lo), abs(value.hi)) <= LARGEST:
            return value
        return self.clamped(value)

    def clamped(self, value: Value) -> Value:
        """Within literals of the coherent unit."""
        unit = {"1": "", "K": "K"}.get(value.dim, value.dim)
        lo, hi = sorted((self.numbers.decimal(-40, 20), self.numbers.decimal(21, 90)))
        text = f"clamp({value.text}, {_literal(lo, unit)}, {_literal(hi, unit)})"
        return Value(text, value.dim, min(max(value.lo, lo), hi), min(max(value.hi, lo), hi))

    def compound(self, dim: str, depth: int) -> Value:
        """An operation whose result has the dimension."""
        r = self.dice
        a = self.of(dim, depth)
        match r.randrange(15):
            case 0 | 1:
                b = self.of(dim, depth)
                return Value(f"({a.text} + {b.text})", dim, a.lo + b.lo, a.hi + b.hi)
            case 2 | 3:
                b = self.of(dim, depth)
                return Value(f"({a.text} - {b.text})", dim, a.lo - b.hi, a.hi - b.lo)
            case 4:
                factor = self.numbers.decimal(0, 4) or Fraction(1, 3)
                return Value(f"{a.text} * {_factor(factor)}", dim, a.lo * factor, a.hi * factor)
            case 5:
                return self.product(a, self.of("1", depth), dim)
            case 6:
                divisor = r.choice((Fraction(7), Fraction(10), Fraction(1, 3), Fraction(25, 10)))
                return Value(f"{a.text} / {_factor(divisor)}", dim, a.lo / divisor, a.hi / divisor)
            case 7:
                # A bare 0 fits any unit.
                b = Value("0", dim, ZERO, ZERO) if r.random() < 0.2 else self.of(dim, depth)
                return Value(f"max({a.text}, {b.text})", dim, max(a.lo, b.lo), max(a.hi, b.hi))
            case 8:
                b = self.of(dim, depth)
                return Value(f"min({a.text}, {b.text})", dim, min(a.lo, b.lo), min(a.hi, b.hi))
            case 9:
                ends = abs(a.lo), abs(a.hi)
                low = ZERO if a.lo <= 0 <= a.hi else min(ends)
                return Value(f"abs({a.text})", dim, low, max(ends))
            case 10:
                b = self.of(dim, depth)
                text = f"({a.text} if {self.test(depth)} else {b.text})"
                return Value(text, dim, min(a.lo, b.lo), max(a.hi, b.hi))
            case 11:
                return self.quotient(a, dim)
            case 12 if self.folding and self.scope.lists and not self.scope.element:
                folds = [self.fold(r.choice(list(self.scope.lists))) for _ in range(4)]
                return next((f for f in folds if f.dim == dim), a)
            case 13:
                return self.turned(dim, depth) or Value(f"(-{a.text})", dim, -a.hi, -a.lo)
            case _:
                return self.across(dim, depth) or self.clamped(a)

    def product(self, a: Value, b: Value, dim: str) -> Value:
        """Of two computed values."""
        corners = [x * y for x in (a.lo, a.hi) for y in (b.lo, b.hi)]
        return Value(f"{_factored(a)} * {_factored(b)}", dim, min(corners), max(corners))

    def quotient(self, a: Value, dim: str) -> Value:
        """By something of one sign that is never 0."""
        by = self.leaf("1")
        size = f"(abs({by.text}) + {number(self.numbers.decimal(0, 3) or Fraction(1, 2))})"
        low = Fraction(size.rsplit("+ ", 1)[1].rstrip(")"))
        high = max(abs(by.lo), abs(by.hi)) + low
        low += ZERO if by.lo <= 0 <= by.hi else min(abs(by.lo), abs(by.hi))
        corners = [x / y for x in (a.lo, a.hi) for y in (low, high)]
        return Value(f"{_factored(a)} / {size}", dim, min(corners), max(corners))

    def across(self, dim: str, depth: int) -> Value | None:
        """A product of two dimensions that makes this one, where there is one."""
        pairs = [p for p, made in PRODUCTS.items() if made == dim]
        if not pairs or not all(self.known(d) for d in pairs[0]):
            return None
        a, b = (self.leaf(d) for d in pairs[0])
        return self.product(a, b, dim)

    def turned(self, dim: str, depth: int) -> Value | None:
        """Between degrees and plain numbers."""
        if dim == "1" and self.known("deg"):
            a = self.leaf("deg")
            return Value(f"to_rad({a.text})", dim, a.lo * PI_OVER_180, a.hi * PI_OVER_180)
        if dim == "deg":
            a = self.leaf("1")
            return Value(f"to_deg({a.text})", dim, a.lo / PI_OVER_180, a.hi / PI_OVER_180)
        return None

    # --- places and tests ------------------------------------------------------------------------------

    def placed(self, over: Ranged) -> str:
        """What goes into a ranged place: anything of its dimension, quotients whose divisor can be 0 among it."""
        if self.dice.random() < 0.3:
            found = self.unbounded(over)
            if found is not None:
                return found
        return self.of(over.dim, 2).text

    def unbounded(self, over: Ranged) -> str | None:
        """A quotient by something that ends in 0."""
        divisors = [("1", over.dim)] + [(b, a) for (a, b), made in QUOTIENTS.items() if made == over.dim]
        below, above = self.dice.choice(divisors)
        if over.dim == "1" and self.dice.random() < 0.6:
            below = above = self.dice.choice([d for d in UNITS if d != "K"])
        nonnegative = [v for v in self.known(below) if v.lo == 0 < v.hi]
        others = [v for v in self.known(below) if v.lo < 0 < v.hi]
        if nonnegative and (not others or self.dice.random() < 0.7):
            divisor = _factored(self.dice.choice(nonnegative))
            if self.dice.random() < 0.3:
                divisor = f"({divisor} * 2)"
        elif others:
            divisor = f"abs({self.dice.choice(others).text})"
        else:
            return None
        if self.dice.random() < 0.2:
            divisor = f"(-{divisor})"
        dividend = self.of(above, 1)
        if dividend.lo == dividend.hi:
            return None
        inside = over.lo + over.span * self.dice.choice((ZERO, Fraction(1), Fraction(1, 3)))
        if over.unit == "degC" or inside < 0:
            fallback = self.of(over.dim, 1).text
        else:
            fallback = number(inside).join(("(", ")")) if "/" in number(inside) else _literal(inside, over.unit)
            if "/" in number(inside) and over.unit:
                fallback = f"{number(inside).split('/')[0]} {over.unit} / {number(inside).split('/')[1]}"
        return f"{_factored(dividend)} / {divisor} otherwise {fallback}"

    def test(self, depth: int) -> str:
        """A condition."""
        r = self.dice
        if depth and r.random() < 0.25:
            joint = r.choice((" and ", " or "))
            return f"({joint.join(self.test(0) for _ in range(r.choice((2, 2, 3))))})"
        if r.random() < 0.1:
            return f"not ({self.test(0)})"
        a = r.choice([*self.scope.element, *self.scope.element, *self.scope.values])
        unit = r.choice([u for u in UNITS[a.dim] if u != "degC"])
        inside = sorted(self.inside(a, unit) for _ in range(2))
        low, high = (_literal(v, unit) for v in inside)
        op = r.choice(("<", "<=", ">", ">=", "==", "!="))
        kind = r.randrange(6)
        if kind == 0 and inside[0] < inside[1]:
            ends = f"[{number(inside[0])}, {number(inside[1])}]{f' {unit}' if unit else ''}"
            return f"{a.text} {r.choice(('in', 'not in'))} {ends}"
        if kind == 1:
            return f"{low} {r.choice(('<', '<='))} {a.text} {r.choice(('<', '<='))} {high}"
        if kind == 2:
            return f"{a.text} {op} {self.leaf(a.dim).text}"
        if kind == 3:
            return f"{a.text} {op} {self.of(a.dim, 1).text}"
        return f"{a.text} {op} {low}"

    def inside(self, value: Value, unit: str) -> Fraction:
        """A short number inside a value's interval, in the unit."""
        scale = coherent(Fraction(1), unit)
        lo, hi = value.lo / scale, value.hi / scale
        at = lo + (hi - lo) * Fraction(self.dice.randint(0, 8), 8)
        return Fraction(round(at * 100), 100) if hi - lo > 1 else Fraction(round(at * 10**6), 10**6)


def _factor(value: Fraction) -> str:
    text = number(value)
    return f"({text})" if "/" in text else text


def _factored(value: Value) -> str:
    """Text that can stand beside ``*`` and ``/``."""
    simple = all(c.isalnum() or c in "._" for c in value.text) or value.text.startswith("(")
    return value.text if simple and _closed(value.text) else f"({value.text})"


def _closed(text: str) -> bool:
    """Whether a leading parenthesis closes at the end only."""
    if not text.startswith("("):
        return True
    depths = list(itertools.accumulate({"(": 1, ")": -1}.get(c, 0) for c in text))
    return 0 not in depths[:-1]


def _literal(value: Fraction, unit: str) -> str:
    """A literal that may stand where a sum may; negatives in parentheses."""
    text = number(abs(value)) + (f" {unit}" if unit else "")
    return f"(-{text})" if value < 0 else text
