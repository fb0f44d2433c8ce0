"""The baselines compute what they say they do: tables that are right at their nodes, float C that samples rightly."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from benchmarks.baselines import SAMPLES, DoesNotFit, Lookup, float_c, lookup_c, lookup_of
from benchmarks.baselines.interface import alone, product_files
from benchmarks.own import float_slack
from benchmarks.workloads import WORKLOADS, Workload
from fuzzyspec import load
from fuzzyspec.native import NativeModule
from tests.benchmarks.hand_written import sampled

ODD = Workload("odd", "tests/benchmarks/odd.fz", "fan", "")
CONTROLLERS = [*(w for w in WORKLOADS if w.controller is not None), ODD]
TABLED = [w for w in CONTROLLERS if w.name != "nav velocity"]
DEFAULT_RAWS = [w for w in TABLED if w.short]


def table_of(workload: Workload) -> Lookup:
    """The workload's lookup table."""
    assert workload.controller is not None
    return lookup_of(workload.controller, lambda values: workload.spec.exact(workload.function, values).outputs)


def native(workload: Workload, source: str) -> NativeModule:
    """A baseline's C on this machine, under the strict flags of generated C."""
    assert workload.controller is not None
    program = alone(workload.spec.lowered.program, workload.controller)
    return NativeModule(program, product_files(program, workload.spec.compile().files, source))


@pytest.mark.parametrize("option", ["O2", "Os"])
@pytest.mark.parametrize("workload", TABLED, ids=lambda w: w.name)
def test_a_tables_c_computes_its_own_model(workload: Workload, option: str) -> None:
    """Bit for bit, written out and as loops; inputs beyond their range saturate and are told as by fuzzyc."""
    lookup, controller = table_of(workload), workload.controller
    assert controller is not None
    spec = workload.spec
    rng = np.random.default_rng(3)
    cases = workload.cases(1000)
    for port in spec.lowered.program.function(workload.function).inputs:
        low, high = np.iinfo(port.ctype).min, np.iinfo(port.ctype).max  # type: ignore[union-attr]
        cases[port.name] = np.concatenate([cases[port.name], rng.integers(low, high + 1, 500), [low, high]])
    with native(workload, lookup_c(lookup, spec.lowered.program, controller, option)) as c:
        result = c.run(workload.function, cases)
    for name, wanted in lookup.run(cases).items():
        assert np.array_equal(result.outputs[name], wanted)
    assert np.array_equal(result.status, spec.fixed(workload.function, cases, raw=True).status)


@pytest.mark.parametrize("workload", DEFAULT_RAWS, ids=lambda w: w.name)
def test_a_table_is_exact_at_its_nodes(workload: Workload) -> None:
    """The nearest raw to the exact meaning, but for what a place rounded up goes on towards the next node."""
    lookup, spec = table_of(workload), workload.spec
    rows = list(product(*([int(r) for r in axis.node_raws()] for axis in lookup.axes)))
    assert all(r.denominator == 1 for axis in lookup.axes for r in axis.node_raws())
    raws = {axis.name: np.array([row[k] for row in rows]) for k, axis in enumerate(lookup.axes)}
    exact = spec.exact(workload.function, spec.dequantise(workload.function, raws)).outputs
    assert workload.controller is not None
    for output in workload.controller.outputs:
        raw, table = output.variable.raw, lookup.tables[output.name]
        wanted = np.floor((exact[output.name] - float(raw.origin)) / float(raw.step) + 0.5)
        beyond = [((a.hi - a.lo) * a.multiplier >> a.shift) - (1 << 15) for a in lookup.axes]
        steps = [np.abs(np.diff(table, axis=k)).max() for k in range(len(beyond))]
        moved = sum(b * s for b, s in zip(beyond, steps, strict=True)) / (1 << lookup.bits)
        rounded = len(beyond) / 2 if any(beyond) else 0
        assert np.abs(lookup.run(raws)[output.name] - wanted).max() <= moved + rounded


@pytest.mark.parametrize("workload", CONTROLLERS, ids=lambda w: w.name)
def test_float_c_is_inference_over_samples(workload: Workload) -> None:
    """The raw nearest to what numpy computes in the same way, up to what float rounding may move it."""
    spec, controller, n = workload.spec, workload.controller, 60
    assert controller is not None
    program = spec.lowered.program
    cases = workload.cases(n)
    with native(workload, float_c(program, controller)) as c:
        found = c.run(workload.function, cases)
    values = spec.dequantise(workload.function, cases)
    rows = [sampled(controller, {k: float(v[i]) for k, v in values.items()}, SAMPLES - 1, ends=True) for i in range(n)]
    for output in controller.outputs:
        raw = output.variable.raw
        wanted = (np.array([row[output.name] for row in rows]) - float(raw.origin)) / float(raw.step)
        clipped = np.clip(np.floor(wanted + 0.5), raw.lo, raw.hi)
        assert np.abs(found.outputs[output.name] - clipped).max() <= float_slack(program, controller)
    if controller.behaviors:
        assert np.array_equal(found.outputs["acting"], spec.fixed(workload.function, cases, raw=True).raws["acting"])


SENTENCES = """\
module other
controller fan {
    input x in [0, 1] { partition low high }
    output y in [0, 1] { partition low high }
    rules { if x is low then y is high  if x is high then y is low }
}
"""


def test_what_does_not_fit_is_refused_with_its_reason() -> None:
    """Sentences for the float C, an acting behavior for the table."""
    spec = load(SENTENCES)
    with pytest.raises(DoesNotFit, match="sentences"):
        float_c(spec.lowered.program, spec.controllers["fan"])
    (velocity,) = [w for w in WORKLOADS if w.name == "nav velocity"]
    with pytest.raises(DoesNotFit, match="acting"):
        table_of(velocity)
