"""Cases at the edges of results, legal inputs one by one, and a state's beginning: what verify finds changed C by."""

from __future__ import annotations

import math

import numpy as np

from fuzzyspec import load
from fuzzyspec.native import NativeModule
from fuzzyspec.verify.draw import Draw
from fuzzyspec.verify.edges import edges
from tests.verify import verify_specs


def test_both_sides_of_an_edge_touch_and_differ() -> None:
    """Cases come in pairs that are one raw of one signal apart and end otherwise; lists and states are served too."""
    for subject in load(verify_specs.HOLDING)._subjects:
        found = list(edges(Draw(subject, 1), 300))
        assert sum(len(next(iter(i.values()))) for i, _ in found) > 100
        for (low, held), (high, same) in zip(found[::2], found[1::2], strict=True):
            apart = [np.abs(low[k] - high[k]).reshape(len(low[k]), -1).sum(axis=1) for k in low]
            assert (np.sum(apart, axis=0) == 1).all()
            assert all((held[k] == same[k]).all() for k in held)
            one, other = subject.fixed(low, held), subject.fixed(high, same)
            masks = [one.outputs[k] != other.outputs[k] for k in one.outputs]
            masks += [one.state[k] != other.state[k] for k in one.state]
            assert np.logical_or.reduce([*masks, one.status != other.status]).all()


def test_few_legal_inputs_are_tried_one_by_one() -> None:
    """Blocks made where the C runs hold each legal input once where there are few; then they are drawn."""
    spec = load(verify_specs.HOLDING)
    port = spec._subject("hold").ports["x"]
    with NativeModule(spec.lowered.program, dict(spec.compile().files)) as native:
        size = 4096
        blocks = math.ceil((port.hi - port.lo + 1) / size)
        raws = [native.block("hold", 5, b, size)[0]["x"] for b in range(blocks)]
        drawn = np.concatenate(raws)[: port.hi - port.lo + 1]
        assert sorted(drawn.tolist()) == list(range(port.lo, port.hi + 1))
        assert (np.diff(drawn) != 1).any()
        states = native.block("hold", 5, 0, size)[1]["y"]
        assert len(set(states.tolist())) > 1000
        beyond = native.block("hold", 5, blocks + 1, size)[0]["x"]
        assert beyond.min() < port.lo or beyond.max() > port.hi


def test_the_self_test_holds_a_state_to_its_beginning() -> None:
    """A state that is set up otherwise than the spec says is found by the module's own self-test."""
    spec = load(verify_specs.HOLDING)
    files = dict(spec.compile().files)
    first = next(line for line in files["keeper.c"].decode().splitlines() if "state->y = " in line)
    value = int(first.split("= ")[1].rstrip("U;"))
    changed = files["keeper.c"].replace(first.encode(), f"    state->y = {value + 1}U;".encode(), 1)
    with NativeModule(spec.lowered.program, files) as native:
        assert native.selftest() == 0
    with NativeModule(spec.lowered.program, {**files, "keeper.c": changed}) as native:
        assert native.selftest() == 1
