"""The report as text, for an engineer at a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TypeVar

from fuzzyspec.check.decisions import Decision
from fuzzyspec.check.quantities import at_least, at_most, interval, number, quantity
from fuzzyspec.check.report import BehaviorReport, ControllerReport, ModuleReport, OutputReport, SystemReport
from fuzzyspec.model.budget import Budget, words
from fuzzyspec.model.controller import Input
from fuzzyspec.model.system import ActingOutput, ListInput
from fuzzyspec.model.variable import Variable

T = TypeVar("T")

LABEL = 11
"""Width of the column of labels."""


def report_text(report: ModuleReport) -> str:
    """The whole report; ends without a newline."""
    sections = [f"module {report.name}"]
    sections += ["\n".join(_controller(c, report.bands.get(c.controller.name))) for c in report.controllers]
    sections += ["\n".join(_system(s, report.bands.get(s.system.name))) for s in report.systems]
    return "\n\n".join(sections)


def _controller(report: ControllerReport, bands: Mapping[str, Fraction] | None) -> list[str]:
    controller, infer = report.controller, report.infer
    lines = [f"controller {controller.name}"]
    lines += [_line(label, row) for label, row in _labelled("inputs", _inputs(controller.inputs))]
    rules = []
    if controller.cells is not None:
        if report.claimed == report.cells:
            rules.append(f"all {_count(report.cells, 'cell')} claimed")
        else:
            rules.append(f"{report.claimed} of {_count(report.cells, 'cell')} claimed")
    if controller.sentences:
        rules.append(_count(len(controller.sentences), "sentence rule"))
    how = f"and {infer.and_}"
    if controller.sentences:
        how += f", or {infer.or_}"
    if infer.defuzzify == "centroid":
        how += f", implies {infer.implies}"
    how += f", aggregate {infer.aggregate}, {infer.defuzzify.replace('_', ' ')}"
    lines += [_line("rules", ", ".join(rules)), _line("inference", how)]
    if report.behaviors:
        lines += _behaviors(report.behaviors, report.cells)
    told: dict[str, str] = {}
    for output in report.outputs:
        lines += _output(output, controller.fires_at, told)
    return lines + _decisions(report.decisions, bands) + _budgets(controller.budgets)


def _inputs(inputs: Sequence[Input]) -> list[str]:
    """Neighbours that share their range and terms share a line."""
    rows: list[tuple[list[str], str]] = []
    for item in inputs:
        v = item.variable
        rest = f"in {interval(v.lo, v.hi, v.unit)}: {' '.join(t.name for t in item.terms)}"
        if rows and rows[-1][1] == rest:
            rows[-1][0].append(item.name)
        else:
            rows.append(([item.name], rest))
    return [f"{', '.join(names)} {rest}" for names, rest in rows]


def _behaviors(behaviors: Sequence[BehaviorReport], cells: int) -> list[str]:
    """A small table: who started how many cells, who executed them, to whom the others went."""
    head = ("behaviors", "priority", "rules", "started", "executed", "lost")
    rows = []
    for b in behaviors:
        lost = ", ".join(f"{count} to {name}" for name, count in b.lost) or "-"
        rules = f"{b.rules}" + (f" ({b.dead} never win)" if b.dead and b.behavior.priority is not None else "")
        priority = "below" if b.behavior.priority is None else str(b.behavior.priority)
        rows.append((b.behavior.name, priority, rules, str(b.started), str(b.executed), lost))
    executed = sum(b.executed for b in behaviors)
    rows.append(("", "", "", "", str(executed), f"of {_count(cells, 'cell')}"))
    widths = [max(len(row[k]) for row in (head, *rows)) for k in range(len(head))]
    widths[0] = max(widths[0], LABEL - 2)
    lines = []
    for row in (head, *rows):
        columns = [row[0].ljust(widths[0]), *(row[k].rjust(widths[k]) for k in range(1, 5)), row[5]]
        lines.append(("  " + "  ".join(columns)).rstrip())
    return lines


def _output(report: OutputReport, fires_at: Fraction, told: dict[str, str]) -> list[str]:
    """``told`` maps a coverage to the output that it was told of first, so that it is not told again."""
    variable, fallback = report.output.variable, report.output.fallback
    lines = [_line("output", _ranged(variable) + ": " + " ".join(t.name for t in report.output.terms))]
    lines.append(_line("", f"reaches   {_reach(report)}"))
    floor = report.floor
    where = ", ".join(f"{name} = {value}" for name, value in report.where.items())
    if floor.exact:
        strength = f"never weaker than {at_least(floor.proved)}" if floor.proved else "nothing fires"
        strength += f" (at {where})" if where else ""
    else:
        strength = f"never weaker than {at_least(floor.proved)}; {at_most(floor.seen)} was seen"
        strength += f" (at {where})" if where else ""
    if report.always_fires:
        strength += ": always fires"
    first = told.setdefault(strength, variable.name)
    lines.append(_line("", f"coverage  {strength if first == variable.name else f'as of {first}'}"))
    if fallback is not None:
        value = quantity(fallback.value, variable.unit)
        what = f"holds its last value, at first {value}" if fallback.hold else f"is {value}"
        if report.always_fires:
            lines.append(_line("", "otherwise never needed: some rule always fires"))
        else:
            lines.append(_line("", f"otherwise {what}, below a strength of {fires_at}"))
    if report.unset:
        lines.append(_line("", f"unset     in {_count(report.unset, 'cell')}"))
    if report.reach.unused:
        lines.append(_line("", f"unused    {' '.join(report.reach.unused)}"))
    return lines


def _reach(report: OutputReport) -> str:
    """The enclosure, and what is known to be attained of it."""
    reach, variable = report.reach, report.output.variable
    outer = interval(reach.lo, reach.hi, variable.unit)
    if reach.exact:
        whole = (reach.lo, reach.hi) == (variable.lo, variable.hi)
        return f"{outer}, {'the whole range' if whole else 'both ends attained'}"
    if reach.attained is None:
        return f"within {outer}"
    lo, hi = reach.attained
    seen = f"{quantity(lo, variable.unit)} is" if lo == hi else f"{interval(lo, hi, variable.unit)} is"
    return f"within {outer}; {seen} attained"


def _system(report: SystemReport, bands: Mapping[str, Fraction] | None) -> list[str]:
    system = report.system
    lines = [f"system {system.name}"]
    rows: list[str] = []
    for item in system.inputs:
        if isinstance(item, ListInput):
            rows.append(f"{item.name}, at most {item.capacity}")
            rows += [f"  .{_ranged(field)}, {_raw(field)}" for field in item.fields]
        else:
            rows.append(f"{_ranged(item)}, {_raw(item)}")
    lines += [_line(label, row) for label, row in _labelled("inputs", rows)]
    results: list[str] = []
    for output in system.outputs:
        if isinstance(output, ActingOutput):
            results.append(f"{output.name}: the code of the behavior that acts in {output.call}")
            continue
        text = f"{_ranged(output.variable)}, {_raw(output.variable)}"
        if output.bare is not None:
            text += f", {output.bare[0]}.{output.bare[1]} as it is"
        results.append(text + (", saturates" if output.saturates else ""))
    lines += [_line(label, row) for label, row in _labelled("outputs", results)]
    return lines + _decisions(report.decisions, bands) + _budgets(system.budgets)


def _decisions(decisions: Sequence[Decision], bands: Mapping[str, Fraction] | None) -> list[str]:
    rows = []
    for d in decisions:
        words = {"0/0": f"0/0 in {d.what}", "comparison": d.what, "fires": d.what, "acting": d.what}[d.kind]
        if bands is None:
            band = ""
        elif bands.get(d.key):
            band = f"; may differ within {at_most(bands[d.key])}"
        else:
            band = "; both meanings agree"
        rows.append(f"{d.key}: {words}{band}")
    return [_line(label, row) for label, row in _labelled("decisions", rows)]


def _budgets(budgets: Sequence[Budget]) -> list[str]:
    return [_line(label, row) for label, row in _labelled("budget", [words(b) for b in budgets])]


def _ranged(variable: Variable) -> str:
    return f"{variable.name} in {interval(variable.lo, variable.hi, variable.unit)}"


def _raw(variable: Variable) -> str:
    step = abs(variable.raw.step)
    for power in (step, 1 / step):
        # Exact, and easier to take in than its decimals.
        if power.denominator == 1 and power > 1 and power.numerator.bit_count() == 1:
            sign = "-" if power != step else ""
            return f"{variable.raw.ctype} step 2^{sign}{power.numerator.bit_length() - 1}"
    return f"{variable.raw.ctype} step {number(step)}"


def _labelled(label: str, items: Sequence[T]) -> list[tuple[str, T]]:
    """The label beside the first item only."""
    return [(label if k == 0 else "", item) for k, item in enumerate(items)]


def _line(label: str, text: str) -> str:
    return f"  {label.ljust(LABEL)}{text}".rstrip()


def _count(number: int, one: str) -> str:
    return f"{number:,} {one}" if number == 1 else f"{number:,} {one}s"
