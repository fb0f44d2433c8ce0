"""Random systems whose arithmetic float64 does without rounding: few-bit numbers, divisors that are powers of two."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from hypothesis import strategies as st

from fuzzyspec.model.controller import Behavior, Controller, Fallback, Inference
from fuzzyspec.model.system import (
    Abs,
    ActingOutput,
    Add,
    Both,
    Call,
    CallOutput,
    Clamp,
    Compare,
    Const,
    Div,
    Either,
    Expr,
    Fold,
    ForEach,
    Greatest,
    If,
    Least,
    Let,
    ListInput,
    Mul,
    Neg,
    Neither,
    ReadField,
    ReadInput,
    ReadLet,
    Statement,
    Sub,
    System,
    SystemOutput,
    Test,
)
from fuzzyspec.model.term import Singleton
from fuzzyspec.model.units import Unit
from fuzzyspec.model.variable import Variable
from tests.exact.exact_models import NOWHERE, controller, grid, output_of, partitioned, table, variable

QUARTER = Unit("q", (), Fraction(1, 4))
SHIFTED = Unit("s", (), Fraction(2), Fraction(3))
DIVISORS = [Fraction(n) for n in ("0", "1/2", "1", "2", "4")]
CAPACITY = 3

SCALARS = (
    variable("x", -8, 8),
    variable("y", 0, 16, QUARTER),
    variable("z", -2, 2, SHIFTED),
    variable("up", 0, 4),
    variable("down", -4, 0),
)
FIELDS = (variable("a", -4, 4), variable("b", 0, 8, QUARTER), variable("up", 0, 4))
LIST = ListInput("items", CAPACITY, FIELDS, NOWHERE)


def blend(hold: bool) -> Controller:
    """y = 2 x where x is at most 3, else what it holds or 1; without rounding. Two behaviors, the lower half first."""
    x = partitioned("x", [0, 2, 4], QUARTER)
    y = output_of("y", 0, 8, [Singleton(Fraction(p)) for p in (0, 4)], Fallback(Fraction(1), hold))
    behaviors = (Behavior("LOW", 1, 2, NOWHERE), Behavior("HIGH", 2, 1, NOWHERE))
    infer = Inference(aggregate="sum", defuzzify="weighted_average")
    cells = table([x], [0, 1, -1], owner=[1, 2, 2])
    return controller([x], [y], cells, infer=infer, behaviors=behaviors, fires_at=Fraction(1, 2), name="blend")


class Names:
    """What an expression may speak of, and fresh keys."""

    def __init__(self) -> None:
        self.lets: list[ReadLet] = []
        self.outputs: list[CallOutput] = []
        self.item_lets: list[ReadLet] = []
        self.item_outputs: list[CallOutput] = []
        self.keys = 0

    def key(self, kind: str) -> str:
        """A fresh key."""
        self.keys += 1
        return f"{kind}{self.keys}"


SMALL = grid(-4, 4, 4)
FACTOR = grid(-2, 2, 2)
INTO = st.tuples(grid(-8, 0, 1), grid(1, 8, 1))
CHANCE = st.booleans()
SHAPES = ("leaf", "leaf", "sum", "product", "one", "least", "clamp", "if", "ratio", "fold")


def expression(draw: st.DrawFn, names: Names, inside: bool, depth: int) -> Expr:
    """A number; ``inside`` a loop or fold over the list."""

    def one() -> Expr:
        return expression(draw, names, inside, depth - 1)

    kind = draw(st.sampled_from(SHAPES)) if depth else "leaf"
    match kind:
        case "sum":
            return draw(st.sampled_from([Add, Sub]))(one(), one())
        case "product":
            if draw(CHANCE):
                return Mul(one(), Const(draw(FACTOR)))
            return Mul(ReadInput(draw(st.sampled_from("xy"))), one())
        case "one":
            if draw(CHANCE):
                return Div(one(), Const(Fraction(-4)), None, None, names.key("ratio"), NOWHERE)
            return draw(st.sampled_from([Neg, Abs]))(one())
        case "least":
            operands = tuple(one() for _ in range(draw(st.integers(2, 3))))
            return draw(st.sampled_from([Least, Greatest]))(operands)
        case "clamp":
            return Clamp(one(), *draw(INTO))
        case "if":
            return If(condition(draw, names, inside, depth - 1), one(), one())
        case "ratio":
            divisors = [ReadInput("up"), ReadInput("down"), *([ReadField("items", "up")] if inside else [])]
            otherwise = one() if draw(CHANCE) else None
            divisor = draw(st.sampled_from(divisors))
            return Div(one(), divisor, draw(INTO), otherwise, names.key("ratio"), NOWHERE)
        case "fold" if not inside:
            test = condition(draw, names, True, depth - 1) if draw(CHANCE) else None
            how = draw(st.sampled_from(["max", "min", "sum", "count"]))
            body = None if how == "count" else expression(draw, names, True, depth - 1)
            return Fold(how, "items", body, test, one() if how in ("max", "min") else None)
        case _:
            known: list[Expr] = [*(ReadInput(v.name) for v in SCALARS[:3]), *names.lets, *names.outputs]
            if inside:
                known += [*(ReadField("items", f.name) for f in FIELDS), *names.item_lets, *names.item_outputs]
            return draw(st.sampled_from([None, *known])) or Const(draw(SMALL))


def condition(draw: st.DrawFn, names: Names, inside: bool, depth: int) -> Test:
    """A condition."""
    kind = draw(st.sampled_from([None, None, Both, Either, Neither])) if depth > 0 else None
    if kind is None:
        op = draw(st.sampled_from(["<", "<=", ">", ">=", "==", "!="]))
        left = expression(draw, names, inside, max(depth - 1, 0))
        right = expression(draw, names, inside, max(depth - 1, 0))
        return Compare(op, left, right, names.key("if"), NOWHERE)
    if kind is Neither:
        return Neither(condition(draw, names, inside, depth - 1))
    return kind(tuple(condition(draw, names, inside, depth - 1) for _ in range(draw(st.integers(1, 3)))))


@st.composite
def systems(draw: st.DrawFn) -> System:
    """A few lets and calls, some of them in a loop, and outputs in several units."""
    names = Names()
    statements: list[Statement] = []
    for number in range(draw(st.integers(0, 2))):
        statements.append(_step(draw, names, False, f"_{number}"))
    if draw(st.booleans()):
        body = [_step(draw, names, True, f"_o{number}") for number in range(draw(st.integers(1, 2)))]
        statements.append(ForEach("items", tuple(body), NOWHERE))
    statements.append(_step(draw, names, False, "_last"))
    outputs: list[SystemOutput | ActingOutput] = []
    for number, unit in enumerate((Unit(""), QUARTER, SHIFTED)):
        into = Variable(f"out{number}", Fraction(-64), Fraction(64), unit, SCALARS[0].raw, NOWHERE)
        outputs.append(SystemOutput(into, expression(draw, names, False, 3), None, True))
    outputs += [ActingOutput(f"acting{n}", o.call, NOWHERE) for n, o in enumerate(names.outputs)]
    return System("s", (*SCALARS, LIST), tuple(statements), tuple(outputs), NOWHERE)


def _step(draw: st.DrawFn, names: Names, inside: bool, suffix: str) -> Let | Call:
    value = expression(draw, names, inside, 3)
    if draw(st.booleans()):
        lets = names.item_lets if inside else names.lets
        lets.append(ReadLet(f"let{suffix}", "items" if inside else None))
        return Let(f"let{suffix}", value, NOWHERE)
    outputs = names.item_outputs if inside else names.outputs
    outputs.append(CallOutput(f"call{suffix}", "y"))
    return Call(f"call{suffix}", blend(not inside), (value,), NOWHERE)


@st.composite
def steps(draw: st.DrawFn) -> dict[str, Any]:
    """One step's inputs; the list holds up to two records more than count."""
    drawn: dict[str, Any] = {v.name: draw(grid(-10, 10, 4)) for v in SCALARS[:3]}
    drawn["up"], drawn["down"] = draw(st.sampled_from(DIVISORS)), -draw(st.sampled_from(DIVISORS))
    drawn["items.count"] = draw(st.integers(0, CAPACITY + 2))
    for f in FIELDS[:2]:
        drawn[f"items.{f.name}"] = draw(st.lists(grid(-5, 5, 4), min_size=CAPACITY + 2, max_size=CAPACITY + 2))
    ups = st.lists(st.sampled_from(DIVISORS), min_size=CAPACITY + 2, max_size=CAPACITY + 2)
    drawn["items.up"] = draw(ups)
    return drawn
