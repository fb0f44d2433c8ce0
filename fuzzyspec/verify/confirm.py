"""Second look, in rationals, at what float64 says is beyond the certificate.

A bound may be met to the last digit, and then the rounding of the float64 evaluation must not decide: what is reported
was found by evaluating the definitions in rationals.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from fuzzyspec.exact import Exact, Point, SystemPoint, controller_point, system_point
from fuzzyspec.fixed.run import Run
from fuzzyspec.model.controller import Controller
from fuzzyspec.verify.cases import Batch
from fuzzyspec.verify.report import Difference
from fuzzyspec.verify.runner import Bools
from fuzzyspec.verify.subject import Subject
from fuzzyspec.verify.tally import disagreements, errors_of

MOST = 32
"""How many cases of a batch are looked at again, those furthest beyond first."""


def beyond_bound(
    subject: Subject, batch: Batch, run: Run, exact: Exact, suspects: Bools
) -> tuple[int, Difference] | None:
    """A case whose error is beyond its output's bound, and that output; None where none is."""
    for name, errors in errors_of(subject, run, exact).items():
        bound = subject.bound(name)
        if bound is None:
            continue
        excess = np.where(suspects, errors - float(bound), -1.0)
        for at in np.argsort(-excess)[:MOST]:
            if excess[at] <= 0:
                break
            error = _error(subject, batch, run, int(at), name)
            if error > bound:
                what = f"|C - exact| of {name}"
                return int(at), Difference(what, f"at most {float(bound):.9g}", f"{float(error):.9g}")
    return None


def beyond_band(
    subject: Subject, batch: Batch, run: Run, exact: Exact, suspects: Bools
) -> tuple[int, Difference] | None:
    """A case at which the exact meaning decides otherwise although its operands are further apart than the band."""
    bands = {b.key: b.width for b in subject.certificate.bands}
    for key, (otherwise, margins, _) in disagreements(run, exact).items():
        width = bands.get(key, Fraction(0))
        excess = np.where(otherwise, margins - float(width), -1.0)
        worst = excess if excess.ndim == 1 else excess.max(axis=1, initial=-1.0)
        worst = np.where(suspects, worst, -1.0)
        for at in np.argsort(-worst)[:MOST]:
            if worst[at] <= 0:
                break
            margin = _margin(subject, batch, run, int(at), key)
            if margin > width:
                what = f"distance of the operands of {key}, where the meanings decide otherwise"
                return int(at), Difference(what, f"at most {float(width):.9g}", f"{float(margin):.9g}")
    return None


def _error(subject: Subject, batch: Batch, run: Run, at: int, output: str) -> Fraction:
    """The error of one output."""
    variable = next(p.variable for p in subject.function.outputs if p.name == output)
    assert variable is not None
    exact = _point(subject, batch, run, at).outputs[output]
    return abs(variable.raw.value(int(run.outputs[output][at])) - exact)


def _margin(subject: Subject, batch: Batch, run: Run, at: int, key: str) -> Fraction:
    """How far a decision's operands are apart at most where the exact meaning decides otherwise, else 0."""
    point = _point(subject, batch, run, at)
    taken = run.decisions[key][at]
    if isinstance(point, Point):
        return point.margins[key] if point.decisions[key] != int(taken) else Fraction(0)
    apart = Fraction(0)
    for where, decision in point.decisions.items():
        if where[0] == key:
            mine = int(taken[where[1]]) if where[1] else int(taken)
            if mine >= 0 and mine != decision:
                apart = max(apart, point.margins[where])
    return apart


def _point(subject: Subject, batch: Batch, run: Run, at: int) -> Point | SystemPoint:
    """The definitions at one case, along the model's decisions."""
    values: dict[str, Fraction | int | list[Fraction]] = {}
    ports = subject.ports
    for key, array in batch.inputs.items():
        port = ports.get(key)
        if port is None:
            values[key] = int(array[at])
            continue
        assert port.variable is not None
        value = port.variable.raw.value
        values[key] = value(int(array[at])) if array.ndim == 1 else [value(int(r)) for r in array[at]]
    state = {k: p.variable.raw.value(int(batch.state[k][at])) for k, p in subject.state.items()}
    if isinstance(subject.model, Controller):
        scalars = {k: v for k, v in values.items() if isinstance(v, Fraction)}
        return controller_point(subject.model, scalars, {k: int(v[at]) for k, v in run.decisions.items()}, state)
    along = {k: [int(d) for d in v[at]] if v.ndim == 2 else int(v[at]) for k, v in run.decisions.items()}
    return system_point(subject.model, values, along, state)
