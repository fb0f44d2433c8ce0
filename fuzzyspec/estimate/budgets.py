"""What the model says to a spec's budgets, before anything is built.

How far estimates were off on specs that they were not fitted to is known: nine in ten by no more than so much, and one
by most. A limit is only called broken where it would be even if this estimate were off by that most. What lies nearer
is for ``fuzzyc cost`` to measure.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Literal, assert_never

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Severity
from fuzzyspec.estimate.model import Estimate, of_profile
from fuzzyspec.estimate.profile import profile
from fuzzyspec.estimate.weights import Option, weights
from fuzzyspec.fixed.program import Program
from fuzzyspec.model.budget import MACHINES, MEMORY, Budget, Machine, amount, words

Verdict = Literal["kept", "close", "doubtful", "broken"]
"""``kept``: with room for the band of nine in ten. ``close``: without. ``doubtful``: the estimate is above the limit.
``broken``: by more than any was ever off."""


@dataclass(frozen=True, slots=True)
class Forecast:
    """One limit of a function on one machine, and the model's figures for it.

    ``typical`` is the mean of a call, ``most`` the longest path through it; a size is both. ``spread``: the relative
    error that nine in ten estimates keep to, ``worst``: the largest seen on the machine.
    """

    function: str
    limit: Budget
    machine: Machine
    typical: float
    most: float
    spread: float
    worst: float

    @property
    def least(self) -> float:
        """What a mean call costs, were the estimate as much too high as the worst was."""
        return self.typical / (1 + self.worst)

    @property
    def verdict(self) -> Verdict:
        """What comes of it."""
        if self.least > self.limit.limit:
            return "broken"
        if self.most > self.limit.limit:
            return "doubtful"
        return "kept" if self.most <= self.limit.limit * (1 - self.spread) else "close"


def forecasts(
    budgets: Mapping[str, Sequence[Budget]], program: Program, target: Machine | Literal["generic"], option: Option
) -> tuple[Forecast, ...]:
    """Every limit that holds on a target, or with ``generic`` on any, by the estimate for a build with ``option``."""
    found: list[Forecast] = []
    for function, limits in budgets.items():
        profiled = profile(program, function)
        for machine in MACHINES if target == "generic" else (target,):
            figures = of_profile(profiled, machine, option)
            for limit in limits:
                if machine in limit.machines:
                    typical, most = _figures(figures, limit)
                    found.append(Forecast(function, limit, machine, typical, most, *_errors(limit, machine, option)))
    return tuple(found)


def _errors(limit: Budget, machine: Machine, option: Option) -> tuple[float, float]:
    """How far nine in ten estimates were off on a machine, and the worst; RAM is known, not estimated."""
    quantity = limit.quantity
    if quantity == "ram":
        return 0.0, 0.0
    own = weights(machine, option, quantity)
    alike = weights(LIKE.get(machine, machine), option, quantity)
    assert own is not None and alike is not None
    return own.nine_in_ten, max(own.worst, alike.worst)


LIKE: Mapping[Machine, Machine] = {"cortex-m7": "cortex-m4"}
"""A machine that was measured on few specs, so that the worst seen there says little: its sister's counts too."""


def _figures(found: Estimate, limit: Budget) -> tuple[float, float]:
    """Mean and longest. What has no honest figure on a machine cannot be limited there."""
    pair: tuple[float | None, float | None]
    match limit.quantity:
        case "flash":
            pair = found.flash, found.flash
        case "ram":
            pair = found.ram, found.ram
        case "stack":
            pair = found.stack, found.stack
        case "instructions":
            pair = found.instructions, found.instructions_max
        case "cycles":
            pair = found.cycles, found.cycles_max
        case _:
            assert_never(limit.quantity)
    typical, most = pair
    assert typical is not None and most is not None
    return typical, max(typical, most)


# --- what is told of it ----------------------------------------------------------------------

_CODES: Mapping[Verdict, tuple[str, Severity]] = {"broken": ("FZ460", "error"), "doubtful": ("FZ461", "warning")}
_SMALLER = "fewer rules, terms or inputs cost less"
_ANYWAY = "`--over-budget warn` writes the C all the same"


def findings(found: Sequence[Forecast], others: Mapping[str, Sequence[Forecast]]) -> tuple[Diagnostic, ...]:
    """An error for each limit that is broken, a warning for each that is in doubt.

    A limit that fails on several machines is told of once, where it fails by most. ``others``: the forecasts under
    other goals, by ``--optimize``; what keeps the limit among them is the way out.
    """
    told: list[Diagnostic] = []
    for _, group in groupby(sorted(found, key=_place), key=_place):
        failing = [f for f in group if f.verdict in _CODES]
        if failing:
            failing.sort(key=lambda f: (f.verdict != "broken", -f.most / max(f.limit.limit, 1)))
            told.append(_finding(failing[0], failing[1:], others))
    return tuple(told)


def _place(forecast: Forecast) -> tuple[int, int]:
    return forecast.limit.span.start, forecast.limit.span.end


def _finding(worst: Forecast, rest: Sequence[Forecast], others: Mapping[str, Sequence[Forecast]]) -> Diagnostic:
    code, severity = _CODES[worst.verdict]
    limit = worst.limit
    comes_to = f"`{worst.function}` comes to about {estimated(worst)} of {limit.quantity} on {worst.machine}"
    if limit.quantity not in MEMORY:
        comes_to = f"`{worst.function}` takes about {estimated(worst)} {limit.quantity} on {worst.machine}"
    if worst.verdict == "broken":
        message = f"{comes_to}: over its budget"
        least = amount(limit.quantity, math.ceil(worst.least))
        label = f"at least {least}, were the estimate {_percent(worst.worst)} too high"
    else:
        message = f"{comes_to}: perhaps over its budget"
        label = f"nine in ten estimates are off by {_percent(worst.spread)} at most"
    measure = f"`fuzzyc cost FILE --target {worst.machine}` decides by measuring"
    way_out = _way_out(worst, others) or _SMALLER
    help_ = f"{way_out}; {measure if worst.verdict == 'doubtful' else _ANYWAY}"
    notes = tuple(f"on {f.machine}: about {estimated(f)}" for f in rest)
    return Diagnostic(code, message, limit.span, label=label, help=help_, notes=notes, severity=severity)


def _way_out(worst: Forecast, others: Mapping[str, Sequence[Forecast]]) -> str:
    """The goal under which the estimate is the smallest, if it is smaller than the one that was asked for."""
    same = {
        goal: f
        for goal, found in others.items()
        for f in found
        if (f.function, f.limit, f.machine) == (worst.function, worst.limit, worst.machine) and f.most < worst.most
    }
    if not same:
        return ""
    goal, best = min(same.items(), key=lambda item: item[1].most)
    return f"`--optimize {goal}` comes to about {estimated(best)}"


def estimated(forecast: Forecast) -> str:
    """The figure in three digits: ``1,230 B``; mean and longest path where they differ: ``250 (at most 310)``."""
    quantity = forecast.limit.quantity
    typical, most = (amount(quantity, _three_digits(x)) for x in (forecast.typical, forecast.most))
    return typical if typical == most else f"{typical} (at most {most})"


def _three_digits(value: float) -> int:
    return int(float(f"{value:.3g}")) if value >= 100 else round(value)


def _percent(error: float) -> str:
    return f"{math.ceil(100 * error)} %"


_OUTCOME: Mapping[Verdict, str] = {
    "kept": "kept",
    "close": "close: `fuzzyc cost` decides",
    "doubtful": "in doubt: `fuzzyc cost` decides",
    "broken": "broken",
}


def as_lines(found: Sequence[Forecast]) -> list[str]:
    """A line a limit and machine: what it is estimated at."""
    rows = [("budget", "target", "estimate", "")]
    rows += [(f"{f.function}: {words(f.limit)}", f.machine, estimated(f), _OUTCOME[f.verdict]) for f in found]
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    return ["  ".join([*(c.ljust(w) for c, w in zip(row, widths, strict=False)), row[3]]).rstrip() for row in rows]


def as_data(forecast: Forecast) -> dict[str, object]:
    """A forecast as plain data; ``estimate`` is the mean, ``longest`` the longest path."""
    return {
        "function": forecast.function,
        "quantity": forecast.limit.quantity,
        "limit": forecast.limit.limit,
        "target": forecast.machine,
        "estimate": round(forecast.typical, 1),
        "longest": round(forecast.most, 1),
        "error": round(forecast.spread, 4),
        "error_worst": round(forecast.worst, 4),
        "verdict": forecast.verdict,
    }
