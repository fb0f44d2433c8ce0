"""``fuzzyc eval``: one input through the exact meaning and the integer program."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from fuzzyspec.cli.lowering import add_tolerance
from fuzzyspec.cli.quantity import quantity
from fuzzyspec.cli.spec import spec_path
from fuzzyspec.diagnostics.refusal import Refusal

if TYPE_CHECKING:
    from fuzzyspec.api import Spec
    from fuzzyspec.verify.signals import Signals


def register(subparsers: Any) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "eval",
        help="evaluate one input",
        description="Evaluate a controller or system at one input: in real numbers, and as the C computes it.",
        epilog="example: fuzzyc eval nav.fz target_bearing=-30deg obstacles.0.distance=2.5 obstacles.0.bearing=10 "
        "obstacles.0.speed=0.2 obstacles.0.radius=20cm",
    )
    parser.add_argument("file", metavar="FILE.fz", type=spec_path, help="the spec")
    parser.add_argument("values", metavar="NAME=VALUE", nargs="*", help="an input, with or without its unit")
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--controller", metavar="NAME", help="evaluate this controller")
    which.add_argument("--system", metavar="NAME", help="evaluate this system (the default, where there is one)")
    add_tolerance(parser)
    parser.add_argument("--format", choices=("text", "json"), default="text", help="what is printed")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Evaluate, print."""
    from fuzzyspec import api

    spec = api.load(arguments.file).within(arguments.tolerance)
    function = _function(spec, arguments)
    found = evaluate(spec, function, arguments.values)
    if arguments.format == "json":
        import json

        print(json.dumps(found, indent=2))
    else:
        print("\n".join(_lines(found)))
    return 0


def _function(spec: Spec, arguments: argparse.Namespace) -> str:
    for name, known, what in (
        (arguments.controller, spec.controllers, "controller"),
        (arguments.system, spec.systems, "system"),
    ):
        if name is not None:
            if name not in known:
                raise Refusal(f"{spec.name} has no {what} `{name}`", f"it has {', '.join(known) or 'none'}")
            return str(name)
    return spec.default_function


def evaluate(spec: Spec, function: str, values: list[str]) -> dict[str, Any]:
    """What both meanings say of one input, as plain data. The exact meaning is taken at the raws, as the C is."""
    from fuzzyspec.verify.signals import signals_of

    signals = signals_of(spec.functions[function])
    raws = _raws(signals, values)
    fixed = spec.fixed(function, raws, raw=True)
    at = spec.dequantise(function, raws)
    along = spec.exact(function, at, decisions=fixed.decisions)
    alone = spec.exact(function, at)
    outputs: dict[str, Any] = {}
    for name, computed in fixed.outputs.items():
        unit = _unit(spec, function, name)
        raw, value = int(fixed.raws[name][0]), computed[0].item()
        outputs[name] = {"exact": float(along.outputs[name][0]), "fixed": value, "raw": raw, "unit": unit}
        if alone.outputs[name][0] != along.outputs[name][0]:
            outputs[name]["exact_alone"] = float(alone.outputs[name][0])
    inputs = {key: _echo(signals, key, raw) for key, raw in raws.items()}
    status = [bit for bit in fixed.bits if fixed.flag(bit)[0]]
    return {"function": function, "inputs": inputs, "outputs": outputs, "status": status}


def _raws(signals: Signals, values: list[str]) -> dict[str, Any]:
    """Raws by signal, as one case. Refusal for whatever is missing, unknown, twice there or no quantity."""
    from fuzzyspec.fixed.quantise import nearest

    given: dict[tuple[str, int], int] = {}
    for text in values:
        name, equals, written = text.partition("=")
        name = name.strip()
        if not equals:
            raise Refusal(f"`{text}` is no NAME=VALUE", f"{signals.function} takes {', '.join(_asked(signals))}")
        parts = name.split(".")
        indexed = len(parts) == 3 and parts[1].isdecimal()
        key, index = (f"{parts[0]}.{parts[2]}", int(parts[1])) if indexed else (name, 0)
        variable = signals.variables.get(key)
        if variable is None or signals.is_field(key) != indexed:
            raise Refusal(f"{signals.function} has no input `{name}`", f"it takes {', '.join(_asked(signals))}")
        if (key, index) in given:
            raise Refusal(f"`{name}` is given twice")
        given[key, index] = nearest(variable, quantity(written, variable, name))
    raws: dict[str, Any] = {}
    for key in signals.variables:
        name, _, field = key.partition(".")
        if not signals.is_field(key):
            if (key, 0) not in given:
                raise Refusal(f"`{key}` is missing", f"{signals.function} takes {', '.join(_asked(signals))}")
            raws[key] = [given[key, 0]]
            continue
        listed = {k for k in given if k[0].partition(".")[0] == name}
        length = max((index + 1 for _, index in listed), default=0)
        for index in range(length):
            if (key, index) not in given:
                raise Refusal(f"`{name}.{index}.{field}` is missing", "elements count from 0, each with all its fields")
        if length > 255:
            raise Refusal(f"`{name}` has {length} elements", "255 is the most")
        raws[key] = [[given[key, index] for index in range(length)]]
        raws[f"{name}.count"] = [length]
    return raws


def _asked(signals: Signals) -> list[str]:
    """The inputs as one would type them."""
    return [k.replace(".", ".0.") if signals.is_field(k) else k for k in signals.variables]


def _echo(signals: Signals, key: str, raws: list[Any]) -> Any:
    """An input as it was understood, for the output."""
    variable = signals.variables.get(key)
    if variable is None:
        return raws[0]
    one = raws[0] if isinstance(raws[0], list) else raws
    found = [{"value": float(variable.raw.value(r)), "raw": r, "unit": variable.unit.symbol} for r in one]
    return found if isinstance(raws[0], list) else found[0]


def _unit(spec: Spec, function: str, output: str) -> str:
    port = next(p for p in spec.lowered.program.function(function).outputs if p.name == output)
    return "" if port.variable is None else port.variable.unit.symbol


def _lines(found: dict[str, Any]) -> Iterator[str]:
    yield f"{found['function']} at"
    for key, value in found["inputs"].items():
        if isinstance(value, dict):
            yield f"  {key} = {_told(value)}"
        elif isinstance(value, list):
            name, _, field = key.partition(".")
            yield from (f"  {name}.{j}.{field} = {_told(v)}" for j, v in enumerate(value))
    rows = [("", "exact", "fixed", "raw")]
    for name, o in found["outputs"].items():
        rows.append((name, f"{o['exact']:.6g} {o['unit']}", f"{o['fixed']:.6g} {o['unit']}", str(o["raw"])))
    widths = [max(len(row[c].strip()) for row in rows) for c in range(4)]
    yield ""
    for row in rows:
        yield "  ".join(f"{cell.strip():{w}}" for cell, w in zip(row, widths, strict=True)).rstrip()
    for name, o in found["outputs"].items():
        if "exact_alone" in o:
            yield f"note: {name} is {o['exact_alone']:.6g} {o['unit']} where the exact meaning decides by itself"
    yield f"status: {' | '.join(found['status']) or 'OK'}"


def _told(value: dict[str, Any]) -> str:
    return f"{value['value']:.6g} {value['unit']}".strip() + f" (raw {value['raw']})"
