"""A module by hand: a controller that holds, called by a system, with names that C and C++ keep for themselves."""

from __future__ import annotations

from fractions import Fraction

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    Branch,
    CallFunction,
    Comment,
    Const,
    Define,
    Element,
    Function,
    Local,
    Port,
    Program,
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
)
from fuzzyspec.model.units import ONE
from fuzzyspec.model.variable import Raw, Variable

UNIT = Variable("duty", Fraction(0), Fraction(200), ONE, Raw("uint8", Fraction(1), Fraction(0), 0, 200), Span(0, 0))


def _holder() -> Function:
    given = Local("class", "int16", -(2**15), 2**15 - 1)
    curve = Table("curve", "int16", (-300, -20, 0, 5, 77, 100, 150, 200))
    at = Local("at", "uint8", 0, 7)
    idle = Local("idle", "uint8", 0, 0)
    value = Local("value", "int16", -300, 200)
    body: tuple[Stmt, ...] = (
        Comment("/* what is held */ comes from the last call that fired ??/"),
        Define(given, ReadPort("class", "int16", -(2**15), 2**15 - 1), True),
        Define(idle, Const(0), True),
        Record("fires.duty", idle),
        Define(at, build.shift_right(build.add(given, Const(2**15)), 13), True),
        Define(value, Element("curve", "int16", at, -300, 200, table=True), True),
        Branch(
            build.compare(">=", value, Const(0)),
            (SetOutput("duty", value), SetState("duty", value)),
            (SetOutput("duty", ReadState("duty", "uint8", 0, 200)), SetStatus("HELD_DUTY")),
        ),
    )
    return Function(
        "step",
        "controller",
        (Port("class", "int16", -(2**15), 2**15 - 1, None),),
        (Port("duty", "uint8", 0, 200, UNIT),),
        (StatePort("duty", "uint8", 9, 0, 200, UNIT),),
        (),
        (StatusBit("HELD_DUTY", "nothing fired, duty was held"),),
        (curve,),
        (),
        body,
    )


def _caller() -> Function:
    left, right = Local("left", "uint8", 0, 200), Local("right", "uint8", 0, 200)
    body: tuple[Stmt, ...] = (
        CallFunction(
            "in",
            "step",
            (ReadPort("a", "int16", -(2**15), 2**15 - 1),),
            (("duty", left),),
            "new",
            (("HELD_DUTY", "HELD_LEFT"),),
        ),
        CallFunction("other", "step", (Const(-5),), (("duty", right),), "other", ()),
        SetOutput("total", build.add(left, right)),
    )
    return Function(
        "main",
        "system",
        (Port("a", "int16", -(2**15), 2**15 - 1, None),),
        (Port("total", "uint16", 0, 400, None),),
        (),
        (("new", "step"), ("other", "step")),
        (StatusBit("HELD_LEFT", "left was held"),),
        (),
        (),
        body,
    )


HOLDING = Program("hold", (_holder(), _caller()))
