"""Every strategy of every function, measured: what there is to choose from, and what was chosen."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, get_args

from fuzzyspec.cost.measure import Conditions, Mismatch, Record, measure
from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.emit import emit
from fuzzyspec.estimate import Estimate, estimate
from fuzzyspec.estimate.weights import Option
from fuzzyspec.fixed.certificate import Certificate
from fuzzyspec.lower import Lowered, Options, lower
from fuzzyspec.lower.choice import choose, strategies
from fuzzyspec.lower.strategy import Goal, Strategy, Target
from fuzzyspec.model.system import Module

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Choice:
    """A function by one strategy, on one target, built with one option.

    ``goals`` are those whose choice it is. A system is listed as the goals make it, controllers and all, so it has no
    strategy of its own. ``optimal``: no other of its function, target and option is better in one of time, flash,
    stack and certified error without being worse in another.
    """

    record: Record
    strategy: Strategy | None
    goals: tuple[Goal, ...]
    estimate: Estimate
    certificate: Certificate
    optimal: bool = False

    @property
    def figures(self) -> tuple[float, ...]:
        """What is to be small."""
        r = self.record
        time = r.instructions_mean if r.instructions_mean is not None else r.cycles_mean
        errors = [o.percent_of_range for o in self.certificate.outputs]
        worst = max((float("inf") if e is None else float(e) for e in errors), default=0.0)
        return (time or 0.0, float(r.flash), float(r.stack or 0), worst)


@dataclass(frozen=True)
class Choices:
    """All of them, by function, target and option, and what did not come out as the program says."""

    found: tuple[Choice, ...]
    mismatches: tuple[Mismatch, ...]


@dataclass(frozen=True)
class _Variant:
    """A function to be built: the module that holds it and what it needs, and how it is lowered."""

    function: str
    module: Module
    strategy: Strategy | None
    goals: tuple[Goal, ...]
    options: Options


def pareto(module: Module, source: Source, conditions: Conditions, progress: Progress | None = None) -> Choices:
    """Build and run every strategy. ``progress`` as of ``measure``. Raises what that raises, and LoweringError."""
    planned = [
        (compiler, variant)
        for compiler in conditions.compilers
        for variant in _variants(module, _target(compiler.target.name), conditions.only)
    ]
    found: list[Choice] = []
    mismatches: list[Mismatch] = []
    for done, (compiler, variant) in enumerate(planned):
        if progress is not None:
            progress(done, len(planned), f"{variant.function} on {compiler.target.name}")
        lowered = lower(variant.module, variant.options)
        files = emit(variant.module, lowered, source, variant.options).files
        own = replace(conditions, compilers=(compiler,), only=(variant.function,), worst=False)
        measured = measure(lowered.program, _always(files), own)
        mismatches += measured.mismatches
        found += [_choice(variant, lowered, record) for record in measured.records]
    return Choices(tuple(_judged(found)), tuple(mismatches))


def _target(name: str) -> Target:
    return next(t for t in get_args(Target) if t == name)


def _always(files: Mapping[str, bytes]) -> Callable[[str, str], Mapping[str, bytes]]:
    return lambda _target, _option: files


def _choice(variant: _Variant, lowered: Lowered, record: Record) -> Choice:
    option: Option = "Os" if record.option == "Os" else "O2"
    return Choice(
        record,
        variant.strategy,
        variant.goals,
        estimate(lowered.program, variant.function, record.target, option),
        lowered.certificates[variant.function],
    )


def _variants(module: Module, target: Target, only: Sequence[str]) -> Iterator[_Variant]:
    """Controllers alone, by every strategy; systems as each goal makes them, equal ones once."""
    goals: tuple[Goal, ...] = get_args(Goal)
    chosen = {(c.name, goal): choose(c, goal, target).strategy for c in module.controllers for goal in goals}
    for controller in module.controllers:
        if only and controller.name not in only:
            continue
        alone = replace(module, controllers=(controller,), systems=())
        for strategy in strategies(controller):
            taken = tuple(g for g in goals if chosen[controller.name, g] == strategy)
            options = Options(target=target, explicit=((controller.name, strategy),))
            yield _Variant(controller.name, alone, strategy, taken, options)
    for system in module.systems:
        if only and system.name not in only:
            continue
        for goal in goals:
            yield _Variant(system.name, module, None, (goal,), Options(optimize=goal, target=target))


def _judged(found: Sequence[Choice]) -> Iterator[Choice]:
    """In order, those that nothing beats marked."""
    for choice in found:
        key = _place(choice)
        rivals = [c.figures for c in found if _place(c) == key]
        own = choice.figures
        beaten = any(r != own and all(a <= b for a, b in zip(r, own, strict=True)) for r in rivals)
        yield replace(choice, optimal=not beaten)


def _place(choice: Choice) -> tuple[str, str, str]:
    return choice.record.function, choice.record.target, choice.record.option


# --- reports -------------------------------------------------------------------------------------

_HEADS = ("", "for", "strategy", "instructions", "largest", "estimate", "cycles", "flash", "estimate", "RAM", "stack",
          "estimate", "error %")  # fmt: skip
_LEFT = 3


def pareto_json(module: str, conditions: Conditions, choices: Choices, missing: Mapping[str, str]) -> dict[str, Any]:
    """One entry per function, target, option and strategy; ``certified`` by output in percent of its range."""
    return {
        "ok": not choices.mismatches,
        "module": module,
        "inputs": conditions.inputs,
        "choices": [
            {
                **asdict(c.record),
                "strategy": None if c.strategy is None else asdict(c.strategy),
                "goals": list(c.goals),
                "optimal": c.optimal,
                "estimate": asdict(c.estimate),
                "certified": {
                    o.output: None if o.percent_of_range is None else float(o.percent_of_range)
                    for o in c.certificate.outputs
                },
            }
            for c in choices.found
        ],
        "mismatches": [asdict(m) for m in choices.mismatches],
        "missing": dict(missing),
    }


def pareto_text(module: str, conditions: Conditions, choices: Choices, missing: Mapping[str, str]) -> str:
    """A table per function, target and option."""
    lines = [f"{module}: every strategy, over {conditions.inputs} inputs", ""]
    for place in dict.fromkeys(map(_place, choices.found)):
        function, target, option = place
        rows = [_HEADS, *(_row(c) for c in choices.found if _place(c) == place)]
        lines += [f"{function} on {target} -{option}", *_laid_out(rows), ""]
    lines.append("*: nothing else is better in time, flash, stack or certified error without being worse in another")
    lines.append("for: the goals of --optimize that choose it; estimate: what the choice was made by")
    lines += [f"not measured: {target} ({why})" for target, why in missing.items()]
    return "\n".join(lines)


def _row(choice: Choice) -> tuple[str, ...]:
    r, e = choice.record, choice.estimate
    errors = ", ".join("none" if o.percent_of_range is None else f"{float(o.percent_of_range):.4f}"
                       for o in choice.certificate.outputs)  # fmt: skip
    guess = e.instructions if e.instructions is not None else e.cycles
    return (
        "*" if choice.optimal else "",
        ", ".join(choice.goals),
        _words(choice.strategy),
        _number(r.instructions_mean),
        _number(r.instructions_max),
        _number(guess),
        _number(r.cycles_mean),
        str(r.flash),
        _number(e.flash),
        str(r.ram),
        _number(r.stack),
        _number(e.stack),
        errors,
    )


def _words(strategy: Strategy | None) -> str:
    return "as chosen" if strategy is None else " ".join(asdict(strategy).values())


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.0f}"


def _laid_out(rows: Sequence[tuple[str, ...]]) -> list[str]:
    widths = [max(len(row[i]) for row in rows) for i in range(len(_HEADS))]
    return [
        "  "
        + "  ".join(
            cell.ljust(width) if i < _LEFT else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
