"""Folds over lists against plain loops in rationals."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from fuzzyspec import load
from fuzzyspec.fixed import run
from fuzzyspec.model.system import ListInput, SystemOutput

F = Fraction
CAPACITY = 4
Item = dict[str, F]
Elements = list[Item]

LIST = f"""
    input items[{CAPACITY}] {{
        size in [0, 9] m raw uint8, side in [-180, 180] deg raw int16 step 1.5, pace in [-2, 3] m/s raw int8
    }}
    input w in [0, 4] m raw uint8
"""

LOOP = "for each o in items { let o.gap = max(0 m, o.size * 3 - w - 0.2 m) }"


def gap(o: Item, w: F) -> F:
    """What the loop gives an element."""
    return max(F(0), o["size"] * 3 - w - F(2, 10))


Meaning = Callable[[Elements, F], F]
FOLDS: dict[str, tuple[str, Meaning]] = {
    "max of a field, none is its own end": (
        "max(o.size for o in items, otherwise 0)",
        lambda e, w: max((o["size"] for o in e), default=F(0)),
    ),
    "max with an otherwise inside the range": (
        "max(o.pace for o in items, otherwise 1.5 m/s)",
        lambda e, w: max((o["pace"] for o in e), default=F(3, 2)),
    ),
    "min with an otherwise beyond the range": (
        "min(o.pace for o in items, otherwise 7 m/s)",
        lambda e, w: min((o["pace"] for o in e), default=F(7)),
    ),
    "min with an otherwise below the range": (
        "min(o.pace for o in items, otherwise (-7 m/s))",
        lambda e, w: min((o["pace"] for o in e), default=F(-7)),
    ),
    "max of negatives with a sector": (
        "max(o.pace for o in items if o.side in [-90, 30] deg, otherwise 0 m/s)",
        lambda e, w: max((o["pace"] for o in e if -90 <= o["side"] <= 30), default=F(0)),
    ),
    "an otherwise that is computed": (
        "min(o.size for o in items if o.pace > 0, otherwise w / 3 + 1 m)",
        lambda e, w: min((o["size"] for o in e if o["pace"] > 0), default=w / 3 + 1),
    ),
    "sum of both signs": ("sum(o.pace for o in items)", lambda e, w: sum((o["pace"] for o in e), F(0))),
    "sum with a test": (
        "sum(o.size * 2 for o in items if not (o.side > 0 deg))",
        lambda e, w: sum((o["size"] * 2 for o in e if o["side"] <= 0), F(0)),
    ),
    "count with a chain": (
        "count(o for o in items if -20 deg <= o.side < 41.5 deg)",
        lambda e, w: F(sum(-20 <= o["side"] < F(83, 2) for o in e)),
    ),
    "count of all": ("count(o for o in items)", lambda e, w: F(len(e))),
    "the list's own count": ("items.count * 1", lambda e, w: F(len(e))),
    "a let of the loop": (
        "max(o.gap for o in items, otherwise 30 m)",
        lambda e, w: max((gap(o, w) for o in e), default=F(30)),
    ),
    "a let with a test on it": (
        "sum(o.gap for o in items if o.gap < 9 m or o.pace == 1 m/s)",
        lambda e, w: sum((gap(o, w) for o in e if gap(o, w) < 9 or o["pace"] == 1), F(0)),
    ),
    "a value of the step's own": (
        "sum(w / 2 for o in items if o.side != 0 deg)",
        lambda e, w: sum((w / 2 for o in e if o["side"] != 0), F(0)),
    ),
    "two folds that meet": (
        "max(o.size for o in items, otherwise 0 m) - min(o.size for o in items, otherwise 0 m)",
        lambda e, w: max((o["size"] for o in e), default=F(0)) - min((o["size"] for o in e), default=F(0)),
    ),
    "a fold that another decides about": (
        "sum(o.size for o in items) if count(o for o in items if o.pace > 1 m/s) >= 2 else w",
        lambda e, w: sum((o["size"] for o in e), F(0)) if sum(o["pace"] > 1 for o in e) >= 2 else w,
    ),
}


@pytest.mark.parametrize("name", FOLDS)
def test_a_fold_is_the_plain_loop(name: str) -> None:
    """A fold over 0 to too many elements equals the loop in rationals, within its bound, and tells of too many."""
    text, meaning = FOLDS[name]
    loop = LOOP if "gap" in text else ""
    spec = load(f"module folds\nsystem step {{ {LIST} {loop} output y = {text} }}\n")
    (system,) = spec.module.systems
    function = spec.lowered.program.function("step")
    (output,) = system.outputs
    assert isinstance(output, SystemOutput)
    listed = next(i for i in system.inputs if isinstance(i, ListInput))
    w = next(i for i in system.inputs if not isinstance(i, ListInput))
    dice = np.random.default_rng(5)
    n = 300
    inputs = {"w": dice.integers(w.raw.lo, w.raw.hi + 1, n), "items.count": np.arange(n) % (CAPACITY + 2)}
    for f in listed.fields:
        legal = dice.integers(f.raw.lo, f.raw.hi + 1, (n, CAPACITY + 1))
        ends = dice.choice([f.raw.lo, f.raw.hi, f.raw.nearest(F(0)), f.raw.nearest(F(30))], (n, CAPACITY + 1))
        inputs[f"items.{f.name}"] = np.where(dice.random(legal.shape) < 0.3, ends, legal)
    found = run(spec.lowered.program, "step", inputs, record=True, checked=True)
    bound = spec.lowered.certificates["step"].output("y").error
    assert bound is not None
    bits = [b.name for b in function.status]
    for case in range(n):
        used = min(int(inputs["items.count"][case]), CAPACITY)
        elements = [
            {f.name: f.raw.value(int(inputs[f"items.{f.name}"][case, j])) for f in listed.fields} for j in range(used)
        ]
        wanted = meaning(elements, w.raw.value(int(inputs["w"][case])))
        mine = output.variable.raw.value(int(found.outputs["y"][case]))
        assert abs(mine - wanted) <= bound, (elements, wanted)
        told = bool(found.status[case] >> bits.index("OVERRUN_ITEMS") & 1)
        assert told == (inputs["items.count"][case] > CAPACITY)


@pytest.mark.parametrize(("first", "second"), list(product(["max", "min", "sum", "count"], repeat=2)))
def test_folds_share_a_pass(first: str, second: str) -> None:
    """Two folds behind a ``for each`` ride in its one loop over the records, and neither changes the other's result."""

    def fold(kind: str) -> str:
        end = ", otherwise 0 m" if kind in ("max", "min") else ""
        return f"{kind}({'o' if kind == 'count' else 'o.gap'} for o in items if o.pace > 0{end})"

    start = f"system step {{ {LIST} {LOOP}"
    both = load(f"module both\n{start} output y = {fold(first)}  output z = {fold(second)} }}\n")
    alone = {
        name: load(f"module one\n{start} output {name} = {fold(kind)} }}\n")
        for name, kind in (("y", first), ("z", second))
    }
    body = both.lowered.program.function("step").body
    assert sum(type(s).__name__ == "Each" for s in body) == 1
    dice = np.random.default_rng(1)
    inputs = {
        "items.size": dice.integers(0, 256, (50, CAPACITY)),
        "items.side": dice.integers(-120, 121, (50, CAPACITY)),
        "items.pace": dice.integers(-128, 128, (50, CAPACITY)),
        "items.count": dice.integers(0, CAPACITY + 1, 50),
        "w": dice.integers(0, 256, 50),
    }
    together = run(both.lowered.program, "step", inputs, checked=True)
    for name, spec in alone.items():
        assert np.array_equal(together.outputs[name], run(spec.lowered.program, "step", inputs).outputs[name])
