"""The numpy meaning of the integer program, held to one that runs a case at a time."""

from __future__ import annotations

import re
import sys

import numpy as np
import pytest

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import (
    Assign,
    Branch,
    CallFunction,
    Const,
    Define,
    Each,
    Function,
    ListPort,
    Local,
    Loop,
    Port,
    Program,
    ReadField,
    ReadPort,
    Record,
    SetOutput,
    StatusBit,
)
from fuzzyspec.fixed.run import CHUNK, IntervalError, Run, decision_shapes, initial_state, run
from tests.fixed.fixed_values import outputs
from tests.fixed.interpreter import Case
from tests.fixed.random_programs import CAPACITY, FIELDS, SCALARS, program

Arrays = dict[str, np.ndarray]


def lanes(seed: int, n: int, width: int = CAPACITY + 2) -> tuple[Arrays, Arrays]:
    """Random bytes for ``program``: small ones and ends often, counts from 0 to past the capacity; and states."""
    dice = np.random.default_rng(seed)

    def some(*shape: int) -> np.ndarray:
        kind = dice.random(shape)
        values = np.where(kind < 0.4, dice.integers(0, 4, shape), dice.integers(0, 256, shape))
        return np.where(kind > 0.9, 255, values)

    inputs = {name: some(n) for name in SCALARS}
    inputs |= {f"items.{f}": some(n, width) for f in FIELDS}
    inputs["items.count"] = dice.integers(0, width + 1, n)
    return inputs, {"kept": some(n), "inner.kept": some(n)}


def one(of: Program, inputs: Arrays, state: Arrays, lane: int) -> Case:
    """One lane by the interpreter."""
    width = inputs["items.size"].shape[1]
    numbers = {k: int(inputs[k][lane]) for k in SCALARS}
    records = [{f: int(inputs[f"items.{f}"][lane, j]) for f in FIELDS} for j in range(width)]
    held = {k: int(v[lane]) for k, v in state.items()}
    counts = {"items": int(inputs["items.count"][lane])}
    return Case(of, of.function("outer"), {**numbers, "items": records}, counts, held).call()


def decided(found: Run, lane: int) -> dict[tuple[str, int | None], int]:
    """A lane's decisions as the interpreter keeps them: those that were taken."""
    taken: dict[tuple[str, int | None], int] = {}
    for key, values in found.decisions.items():
        if values.ndim == 1:
            taken[key, None] = int(values[lane])
        else:
            taken |= {(key, j): int(v) for j, v in enumerate(values[lane])}
    return {k: v for k, v in taken.items() if v >= 0}


@pytest.mark.parametrize("seed", range(60))
def test_lanes_are_independent_cases(seed: int) -> None:
    """Outputs, status, state and decisions of every lane are what a plain interpreter gives for that lane alone."""
    of = program(seed)
    inputs, state = lanes(seed, 24)
    found = run(of, "outer", inputs, state, record=True, checked=True)
    for lane in range(24):
        alone = one(of, inputs, state, lane)
        assert {k: int(v[lane]) for k, v in found.outputs.items()} == alone.outputs
        assert {k: int(v[lane]) for k, v in found.state.items()} == alone.state
        assert int(found.status[lane]) == alone.status
        assert decided(found, lane) == alone.decisions


def same(one: Run, other: Run) -> None:
    """Two runs are equal in everything."""
    assert np.array_equal(one.status, other.status)
    for mine, theirs in ((one.outputs, other.outputs), (one.state, other.state), (one.decisions, other.decisions)):
        assert list(mine) == list(theirs)
        for key in mine:
            assert np.array_equal(mine[key], theirs[key]), key


@pytest.mark.parametrize("seed", range(6))
def test_chunks_do_not_show(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """More lanes than a chunk give what all lanes at once give, the last, short chunk included."""
    inputs, state = lanes(seed, 250)
    whole = run(program(seed), "outer", inputs, state, record=True)
    monkeypatch.setattr(sys.modules[run.__module__], "CHUNK", 60)
    same(run(program(seed), "outer", inputs, state, record=True), whole)


def test_a_real_chunk_is_crossed() -> None:
    """Lanes beyond the chunk's true size come out in order."""
    of = Program("p", (_echo(),))
    values = np.arange(2 * CHUNK + 5) % 256
    assert np.array_equal(run(of, "echo", {"x": values}).outputs["y"], values)


def _echo() -> Function:
    body = (SetOutput("y", ReadPort("x", "uint8", 0, 255)),)
    return Function("echo", "controller", (_port("x"),), (_port("y"),), (), (), (), (), (), body)


def _port(name: str) -> Port:
    return Port(name, "uint8", 0, 255, None)


def test_no_lanes_are_no_lanes() -> None:
    """Arrays of length 0 give outputs of length 0."""
    found = run(Program("p", (_echo(),)), "echo", {"x": np.zeros(0)})
    assert found.outputs["y"].shape == (0,)


def test_no_state_is_the_initial_one() -> None:
    """Without a state the initial ones of the function and of what it calls are taken, by their full names."""
    of = program(1)
    inputs, _ = lanes(1, 10)
    first = initial_state(of, of.function("outer"))
    assert first == {"kept": 17, "inner.kept": 17}
    same(run(of, "outer", inputs), run(of, "outer", inputs, {k: np.full(10, v) for k, v in first.items()}))


def test_a_run_changes_no_array_of_the_caller() -> None:
    """Inputs and states that were handed in are as before."""
    inputs, state = lanes(3, 50)
    before = {k: v.copy() for k, v in (inputs | state).items()}
    run(program(3), "outer", inputs, state)
    for key, values in (inputs | state).items():
        assert np.array_equal(values, before[key])


@pytest.mark.parametrize("seed", range(20))
def test_decisions_have_a_column_an_element(seed: int) -> None:
    """A decision inside a list has the list's capacity as width, whatever the arrays' width; other ones have none."""
    of = program(seed)
    shapes = decision_shapes(of, of.function("outer"))
    for width in (CAPACITY, CAPACITY + 2):
        inputs, state = lanes(seed, 7, width)
        found = run(of, "outer", inputs, state, record=True)
        assert {k: v.shape for k, v in found.decisions.items()} == {
            k: (7,) if capacity is None else (7, capacity) for k, capacity in shapes.items()
        }
    assert run(of, "outer", inputs, state).decisions == {}


def _totals(capacity: int) -> Program:
    """A function that adds up a list, and records what it saw of each element."""
    total, item = Local("total", "uint16", 0, 255 * capacity), Local("item", "uint8", 0, 255)
    body = (
        Define(total, Const(0), False),
        Each(
            "items",
            Local("n", "uint8", 0, capacity - 1),
            (
                Define(item, ReadField("items", "size", "uint8", 0, 255), True),
                Record("large", build.compare(">", item, Const(9))),
                Assign(total, build.add_bounded(total, item, 255 * capacity)),
            ),
        ),
        SetOutput("total", total),
    )
    ports = (ListPort("items", capacity, (_port("size"),)),)
    outputs = (Port("total", "uint16", 0, 255 * capacity, None),)
    status = (StatusBit("OVERRUN_ITEMS", "too many"),)
    return Program("p", (Function("totals", "system", ports, outputs, (), (), status, (), (), body),))


def test_counts_from_none_to_past_the_capacity() -> None:
    """The first min(count, capacity) elements are used, the bit tells of more, elements beyond decide nothing (-1)."""
    counts = np.array([0, 1, 2, 3, 4, 5, 200])
    sizes = np.tile(np.array([5, 10, 20, 40, 80]), (7, 1))
    found = run(_totals(3), "totals", {"items.size": sizes, "items.count": counts}, record=True)
    assert found.outputs["total"].tolist() == [0, 5, 15, 35, 35, 35, 35]
    assert found.status.tolist() == [0, 0, 0, 0, 1, 1, 1]
    assert found.decisions["large"].tolist() == [
        [-1, -1, -1],
        [0, -1, -1],
        [0, 1, -1],
        *[[0, 1, 1]] * 4,
    ]


def test_arrays_may_be_as_narrow_as_the_counts() -> None:
    """Records that no count reaches need not be there; one that a count reaches must be."""
    sizes = np.array([[7, 8]])
    assert run(_totals(3), "totals", {"items.size": sizes, "items.count": [2]}).outputs["total"].tolist() == [15]
    empty = {"items.size": np.zeros((1, 0)), "items.count": [0]}
    assert run(_totals(3), "totals", empty).outputs["total"].tolist() == [0]
    with pytest.raises(ValueError, match="count of 3 with 2 records"):
        run(_totals(3), "totals", {"items.size": sizes, "items.count": [3]})


def test_missing_and_uneven_signals_are_named() -> None:
    """A signal that is not there is a KeyError with its name, arrays of different lengths are a ValueError."""
    inputs, _ = lanes(0, 4)
    with pytest.raises(KeyError, match=r"items\.count"):
        run(program(0), "outer", {k: v for k, v in inputs.items() if k != "items.count"})
    with pytest.raises(ValueError, match="differ in length"):
        run(program(0), "outer", inputs | {"a": np.zeros(3)})


def test_checked_runs_hold_values_against_intervals() -> None:
    """A local that is set outside its interval stops a checked run; lanes that a branch excludes do not."""
    x, y = Local("x", "uint8", 0, 255), Local("y", "uint8", 0, 9)
    start = [Define(x, ReadPort("x", "uint8", 0, 255), True), Define(y, Const(0), False)]
    ports = [_port("x")]
    wrong = [*start, Assign(y, x), SetOutput("result", y)]
    with pytest.raises(IntervalError, match=re.escape("y: 3 .. 40 outside 0 .. 9")):
        outputs(ports, wrong, {"x": [3, 40]})
    guarded = [*start, Branch(build.compare("<", x, Const(10)), (Assign(y, x),)), SetOutput("result", y)]
    assert outputs(ports, guarded, {"x": [3, 40]})["result"].tolist() == [3, 0]


def test_a_call_inside_a_list_decides_an_element_at_a_time() -> None:
    """Decisions of a called function are columns by element, under the call's id."""
    x = Local("x", "uint8", 0, 255)
    inner_body = (
        Define(x, ReadPort("x", "uint8", 0, 255), True),
        Record("high", build.compare(">=", x, Const(100))),
        SetOutput("y", x),
    )
    inner = Function("inner", "controller", (_port("x"),), (_port("y"),), (), (), (), (), (), inner_body)
    got = Local("got", "uint8", 0, 255)
    each = Each(
        "items",
        Local("n", "uint8", 0, 1),
        (CallFunction("look", "inner", (ReadField("items", "size", "uint8", 0, 255),), (("y", got),), None, ()),),
    )
    ports = (ListPort("items", 2, (_port("size"),)),)
    status = (StatusBit("OVERRUN_ITEMS", "too many"),)
    outer = Function("outer", "system", ports, (), (), (), status, (), (), (each,))
    sizes = np.array([[99, 100], [100, 99], [255, 0]])
    found = run(Program("p", (inner, outer)), "outer", {"items.size": sizes, "items.count": [2, 2, 1]}, record=True)
    assert found.decisions["look.high"].tolist() == [[0, 1], [1, 0], [1, -1]]


def test_loops_count_from_0() -> None:
    """A loop's counter takes 0 .. count - 1, in order."""
    seen, i = Local("seen", "uint32", 0, 10**5), Local("i", "uint8", 0, 4)
    body = [
        Define(seen, Const(0), False),
        Loop(i, 5, (Assign(seen, build.add_bounded(build.mul(seen, Const(10)), i, 10**5)),)),
        SetOutput("result", seen),
    ]
    assert outputs([_port("x")], body, {"x": [0]})["result"].tolist() == [1234]


def test_random_programs_take_every_statement() -> None:
    """The random programs above are no empty ones: branches go both ways, elements differ, states and bits change."""
    changed: set[str] = set()
    for seed in range(20):
        inputs, state = lanes(seed, 24)
        found = run(program(seed), "outer", inputs, state, record=True)
        changed |= {f"bit {i}" for i in range(3) if len(set((found.status >> i & 1).tolist())) == 2}
        changed |= {k for k in state if not np.array_equal(found.state[k], state[k])}
        changed |= {f"{v.ndim}-d" for v in found.decisions.values() if v.max() > 0}
        changed |= {k for k, v in found.outputs.items() if len(np.unique(v)) > 3}
    assert changed == {"bit 0", "bit 1", "bit 2", "kept", "inner.kept", "1-d", "2-d", "y", "z"}
