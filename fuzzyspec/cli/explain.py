"""``fuzzyc explain``: a diagnostic code's page, or which rules fire at an input."""

from __future__ import annotations

import argparse
import json
import re
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from fuzzyspec.cli.quantity import quantity
from fuzzyspec.diagnostics.refusal import Refusal

if TYPE_CHECKING:
    from fuzzyspec.check.explanation import Explanation, Firing
    from fuzzyspec.diagnostics.diagnostic import Source
    from fuzzyspec.exact import Point
    from fuzzyspec.model.controller import Controller
    from fuzzyspec.model.system import Module

MOST_FIRINGS = 32
"""Cells that the text lists; JSON has them all."""


def register(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``fuzzyc explain``."""
    parser = subparsers.add_parser(
        "explain",
        help="explain a diagnostic code, or which rules fire at an input",
        description="Explain a diagnostic code, or what a controller does at an input: degrees, firing rules, outputs.",
        epilog="examples: fuzzyc explain FZ301; fuzzyc explain nav.fz --controller danger eta_t=1.5 eta_d=0.5",
    )
    parser.add_argument("subject", metavar="CODE|FILE.fz", help="a code such as FZ301, or a spec")
    parser.add_argument(
        "values", metavar="name=value", nargs="*", help="an input, with or without its unit: target=-20deg"
    )
    parser.add_argument("--controller", metavar="NAME", help="which, where there are several")
    parser.add_argument("--format", choices=("text", "json"), default="text")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Explain; 1 where the spec has errors, 2 for an unknown code or inputs that do not fit."""
    if re.fullmatch(r"[Ff][Zz]\d+", arguments.subject) and not Path(arguments.subject).exists():
        return _page(arguments.subject.upper(), arguments.values, arguments.format)
    if not Path(arguments.subject).exists():
        raise Refusal(
            f"`{arguments.subject}` is neither a diagnostic code nor a file",
            "a code is written like FZ301; of a spec, `fuzzyc explain FILE.fz NAME=VALUE ..` tells which rules fire",
        )
    return _fire(arguments)


def _page(code: str, values: list[str], form: str) -> int:
    from fuzzyspec.diagnostics.codes import REGISTRY

    if values:
        raise Refusal(f"{code} takes no values", "give a spec to see which rules fire")
    known = REGISTRY.get(code)
    if known is None:
        near = [c for c in REGISTRY if c[:3] == code[:3]]
        raise Refusal(f"there is no code {code}", f"the codes near it: {', '.join(near)}" if near else None)
    if form == "json":
        data = {"code": known.code, "title": known.title, "severity": known.severity, "page": known.page}
        print(json.dumps(data, indent=2))
    else:
        print(f"{known.severity}[{known.code}]: {known.title}\n\n{known.page.rstrip()}")
    return 0


def _fire(arguments: argparse.Namespace) -> int:
    from fuzzyspec.api import load
    from fuzzyspec.check.explanation import explain
    from fuzzyspec.exact import controller_point

    spec = load(arguments.subject)
    controller = _controller(spec.module, arguments.controller)
    at = _inputs(controller, arguments.values)
    explanation = explain(controller, at, spec.source)
    point = controller_point(controller, at)
    if arguments.format == "json":
        print(json.dumps(_as_json(controller, explanation, point, spec.source), indent=2))
    else:
        print("\n".join(_text(controller, explanation, point, spec.source)))
    return 0


def _controller(module: Module, name: str | None) -> Controller:
    from fuzzyspec.check.similar import did_you_mean

    known = {c.name: c for c in module.controllers}
    if name is None and len(known) == 1:
        return module.controllers[0]
    if name is None:
        listed = ", ".join(known)
        raise Refusal(
            f"{module.name} has several controllers: {listed}" if known else f"{module.name} has no controller",
            "say --controller NAME",
        )
    if name not in known:
        raise Refusal(
            f"{module.name} has no controller `{name}`",
            did_you_mean(name, known) or f"its controllers are {', '.join(known)}",
        )
    return known[name]


def _inputs(controller: Controller, pairs: list[str]) -> dict[str, Fraction]:
    """The values given for the controller's inputs. Refusal where they do not fit."""
    from fuzzyspec.check.similar import did_you_mean

    known = {v.name: v.variable for v in controller.inputs}
    listed = "its inputs are " + ", ".join(known)
    at: dict[str, Fraction] = {}
    for pair in pairs:
        name, equals, text = (part.strip() for part in pair.partition("="))
        if not equals:
            raise Refusal(f"`{pair}` is no name=value")
        if name not in known:
            raise Refusal(f"controller {controller.name} has no input `{name}`", did_you_mean(name, known) or listed)
        if name in at:
            raise Refusal(f"input `{name}` is given twice")
        at[name] = quantity(text, known[name], name)
    missing = [name for name in known if name not in at]
    if missing:
        raise Refusal(f"no value for {', '.join(missing)}", " ".join(f"{name}=.." for name in missing))
    return at


# --- text ------------------------------------------------------------------------------------


def _text(controller: Controller, explanation: Explanation, point: Point, source: Source) -> list[str]:
    from fuzzyspec.check.quantities import number
    from fuzzyspec.check.quantities import quantity as shown

    lines = [f"controller {controller.name}", "", "degrees"]
    width = max(len(v.name) for v in controller.inputs)
    values = [shown(i.value, v.variable.unit) for i, v in zip(explanation.inputs, controller.inputs, strict=True)]
    value_width = max(len(v) for v in values)
    for item, variable, value in zip(explanation.inputs, controller.inputs, values, strict=True):
        degrees = "  ".join(f"{term} {number(d)}" for term, d in item.degrees.items() if d > 0) or "no term"
        note = "" if item.given == item.value else f"  (saturated from {shown(item.given, variable.variable.unit)})"
        lines.append(f"  {item.name.ljust(width)} = {value.ljust(value_width)}  {degrees}{note}")
    lines += ["", *_firings(controller, explanation.firings, source), "", "outputs"]
    rows = []
    for output in controller.outputs:
        heights: dict[str, Fraction] = {}
        for firing in explanation.firings:
            if output.name in firing.sets:
                term = firing.sets[output.name]
                heights[term] = max(heights.get(term, Fraction(0)), firing.strength)
        fired = point.decisions.get(f"fires.{output.name}", 1)
        terms = "  ".join(f"{term} {number(h)}" for term, h in heights.items())
        if not fired:
            kept = output.fallback is not None and output.fallback.hold
            terms = f"nothing reaches {controller.fires_at}: " + ("its first value is held" if kept else "`otherwise`")
        rows.append((output.name, shown(point.outputs[output.name], output.variable.unit), terms))
    if controller.behaviors:
        acting = next((b.name for b in controller.behaviors if b.code == point.acting), "nobody")
        rows.append(("acting", acting, f"code {point.acting}"))
    widths = [max(len(row[k]) for row in rows) for k in range(2)]
    lines += [f"  {name.ljust(widths[0])} = {value.ljust(widths[1])}  {terms}".rstrip() for name, value, terms in rows]
    return lines


def _firings(controller: Controller, firings: tuple[Firing, ...], source: Source) -> list[str]:
    from fuzzyspec.check.quantities import number

    what = "cells" if controller.cells is not None and not controller.sentences else "rules"
    how = (
        f"`{controller.infer.and_}` over all inputs"
        if what == "cells"
        else "inputs that a rule does not name do not matter"
    )
    if not firings:
        return [f"no {what[:-1]} fires"]
    rows = []
    for firing in firings[:MOST_FIRINGS]:
        sets = ", ".join(f"{output} is {term}" for output, term in firing.sets.items()) or "nothing is set"
        owner = firing.owner.name if firing.owner is not None else ""
        places = ", ".join(f"line {source.position(span.start)[0]}" for span in firing.spans)
        sentence = firing.rule.startswith("if ")
        rows.append((number(firing.strength), owner, firing.rule, "" if sentence else f"-> {sets}", places))
    widths = [max(len(row[k]) for row in rows) for k in range(5)]
    lines = [f"{len(firings)} {what if len(firings) > 1 else what[:-1]} fire{'' if len(firings) > 1 else 's'} ({how})"]
    for row in rows:
        columns = [column.ljust(width) for column, width in zip(row, widths, strict=True) if width]
        lines.append(("  " + "  ".join(columns)).rstrip())
    if len(firings) > MOST_FIRINGS:
        lines.append(f"  and {len(firings) - MOST_FIRINGS} weaker ones")
    return lines


# --- data ------------------------------------------------------------------------------------


def _as_json(controller: Controller, explanation: Explanation, point: Point, source: Source) -> dict[str, object]:
    acting = next((b.name for b in controller.behaviors if b.code == point.acting), None)
    return {
        "controller": controller.name,
        "inputs": [
            {
                "name": item.name,
                "value": float(item.value),
                "given": float(item.given),
                "unit": variable.variable.unit.symbol,
                "degrees": {term: float(d) for term, d in item.degrees.items()},
            }
            for item, variable in zip(explanation.inputs, controller.inputs, strict=True)
        ],
        "firings": [
            {
                "rule": firing.rule,
                "strength": float(firing.strength),
                "weight": float(firing.weight),
                "sets": dict(firing.sets),
                "behavior": None if firing.owner is None else firing.owner.name,
                "lines": [source.position(span.start)[0] for span in firing.spans],
            }
            for firing in explanation.firings
        ],
        "acting": acting,
        "outputs": [
            {
                "name": output.name,
                "value": float(point.outputs[output.name]),
                "unit": output.variable.unit.symbol,
                "fires": bool(point.decisions.get(f"fires.{output.name}", 1)),
            }
            for output in controller.outputs
        ],
    }
