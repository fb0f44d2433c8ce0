"""What a program does, counted."""

from __future__ import annotations

import pytest

from fuzzyspec import load
from fuzzyspec.estimate.features import of_statement
from fuzzyspec.estimate.pressure import arrays, pressure
from fuzzyspec.estimate.profile import profile
from fuzzyspec.estimate.weights import Weights
from fuzzyspec.fixed import Program, build
from fuzzyspec.fixed.program import (
    Assign,
    Branch,
    Const,
    Define,
    DefineArray,
    Element,
    Function,
    Local,
    Loop,
    Port,
    ReadPort,
    Record,
    SetOutput,
    Stmt,
    Table,
    Window,
)
from tests.cost.cost_specs import KEEPING, PLAIN

X = Local("x", "uint32", 0, 255)
Y = Local("y", "uint32", 0, 65535)


def function(*body: Stmt, tables: tuple[Table, ...] = ()) -> Program:
    """A function of one input, a raw of 8 bits drawn evenly from its range, and one output."""
    (controller, *_) = load(PLAIN).module.controllers
    variable = controller.inputs[0].variable
    given, out = Port("x", "uint16", 0, 40960, variable), Port("y", "uint16", 0, 65535, None)
    return Program("p", (Function("f", "controller", (given,), (out,), (), (), (), tables, (), body),))


READ = Define(X, ReadPort("x", "uint16", 0, 65535), False)


def test_operations_are_counted_by_kind_and_width() -> None:
    """A product of two bytes of 16 bits is wide, a power of two is a shift, a large constant is loaded."""
    byte, word = Local("b", "uint8", 0, 255), Local("w", "uint32", 0, 2**20)
    assert of_statement(SetOutput("y", build.mul(byte, byte))) == {"multiply_wide.8": 1, "output.16": 1}
    assert of_statement(SetOutput("y", build.mul(byte, Const(8)))) == {
        "shift.16": 1, "shifted_bits.16": 3, "output.16": 1,
    }  # fmt: skip
    assert of_statement(SetOutput("y", build.add(word, Const(1000)))) == {"add.32": 1, "constant": 1, "output.32": 1}
    assert of_statement(Assign(byte, build.add(byte, Const(0)))) == {"set.8": 1}


def test_elements_at_a_known_place_are_told_from_those_looked_up() -> None:
    """A constant index costs no address; an index into wider elements is scaled."""
    known = Element("t", "uint16", Const(2), 0, 9, True)
    looked_up = Element("t", "uint16", X, 0, 9, True)
    assert of_statement(Define(Y, known, True)) == {"table_at.16": 1}
    assert of_statement(Define(Y, looked_up, True)) == {"table.16": 1, "scaled": 1}


def test_records_cost_nothing() -> None:
    """C does not print them, nor what only they read."""
    plain = profile(function(READ, SetOutput("y", X)), "f")
    recorded = profile(function(READ, Define(Y, build.add(X, X), True), Record("k", Y), SetOutput("y", X)), "f")
    assert (recorded.mean, recorded.code) == (plain.mean, plain.code)


@pytest.mark.parametrize(("threshold", "share"), [(0, 0.0), (10240, 0.25), (20480, 0.5), (40961, 1.0)])
def test_a_branch_counts_as_often_as_it_is_taken(threshold: int, share: float) -> None:
    """Over evenly drawn inputs an arm below a threshold is entered in the threshold's share of the range."""
    arm = Assign(Y, build.add(Y, Const(3)))
    low = Branch(build.compare("<", Local("x", "uint32", 0, 65535), Const(threshold)), (arm,))
    read = Define(Local("x", "uint32", 0, 65535), ReadPort("x", "uint16", 0, 65535), False)
    found = profile(function(read, Define(Y, Const(0), False), low, SetOutput("y", Y)), "f", 400)
    assert found.mean.get("add.32", 0.0) == pytest.approx(share, abs=0.07)


def test_the_longest_path_takes_every_round_and_the_heavier_arm() -> None:
    """Worked out by hand: five rounds, each with the arm of two additions, not the one of one."""
    z = Local("z", "uint32", 0, 2**20)
    i = Local("i", "uint8", 0, 4)
    one = Assign(z, build.add_bounded(z, X, 2**20))
    fork = Branch(build.compare("<", X, Const(7)), (one,), (one, one))
    body = (READ, Define(z, Const(0), False), Loop(i, 5, (fork,)), SetOutput("y", z))
    found = profile(function(*body), "f")
    assert found.longest(Weights({"add": 1.0}, 0, 0, 0)) == 10
    assert found.mean["add.32"] <= 10
    assert found.code["add.32"] == 3


def test_callees_count_as_often_as_they_are_called() -> None:
    """A system of a controller enters two functions a call; its code and its longest path hold both."""
    program = load(KEEPING).lowered.program
    alone, both = profile(program, "hold"), profile(program, "both")
    assert (alone.mean["entry"], both.mean["entry"]) == (1, 2)
    assert both.code["entry"] == 2
    weights = Weights({"compare": 1.0, "element": 2.0}, 0, 0, 0)
    assert both.longest(weights) > alone.longest(weights) + 2 * 3
    assert 0 < both.mean["element"] < 3


def test_tables_are_counted_in_bytes_where_they_are_read() -> None:
    """A table that nothing reads is not printed."""
    used, unused = Table("t", "uint16", (1, 2, 3)), Table("u", "uint8", (1,) * 99)
    read = Define(Y, Element("t", "uint16", Const(1), 0, 9, True), True)
    assert profile(function(READ, read, SetOutput("y", Y), tables=(used, unused)), "f").tables == 6


def test_a_window_reads_its_table() -> None:
    """A pointer is set, and the table behind it is printed."""
    window, table = Window("w", "uint16", "t", Const(5)), Table("t", "uint16", (1, 2, 3) * 99)
    read = Define(Y, Element("w", "uint16", Const(1), 0, 9, True), True)
    found = profile(function(READ, window, read, SetOutput("y", Y), tables=(table,)), "f", 1)
    assert (found.mean["window"], found.tables) == (1, 594)


def test_pressure_grows_with_what_lives_at_once() -> None:
    """Nine locals that are all read at the end live at once; read one after the other, two do."""
    many = [Local(f"v{i}", "uint16", 0, 9) for i in range(9)]
    define = [Define(v, Const(i), True) for i, v in enumerate(many)]
    at_once = (*define, *(SetOutput("y", v) for v in many))
    in_turn = tuple(s for d, v in zip(define, many, strict=True) for s in (d, SetOutput("y", v)))
    assert (pressure(at_once).words, pressure(at_once).bytes) == (9, 18)
    assert pressure(in_turn).words == 1
    assert pressure(at_once).blocks[id(at_once)]["crowded_4"] > 0


def test_what_the_next_round_reads_lives_through_the_loop() -> None:
    """A sum that is set in a loop and read after it lives in the whole body."""
    i, z, t = Local("i", "uint8", 0, 4), Local("z", "uint32", 0, 99), Local("t", "uint8", 0, 9)
    inner: tuple[Stmt, ...] = (Define(t, Const(1), True), Assign(z, build.add_bounded(z, t, 99)))
    body = (Define(z, Const(0), False), Loop(i, 5, inner), SetOutput("y", z))
    assert pressure(body).words == 2


def test_local_arrays_are_bytes_of_the_frame() -> None:
    """By size and type."""
    assert arrays((DefineArray("a", "uint16", 5), DefineArray("b", "uint32", 2))) == 18
