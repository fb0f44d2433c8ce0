"""Plain float C: every rule of the table, slopes divided beforehand, the centroid over samples.

The way in which fuzzy controllers are written by hand, and in which most libraries compute.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from benchmarks.baselines.interface import DoesNotFit, InputC, Interface, interface_of, require_cells, template
from fuzzyspec.fixed.program import Port, Program
from fuzzyspec.model.controller import Controller, Input, Output
from fuzzyspec.model.term import PiecewiseLinear, Singleton, Term
from fuzzyspec.model.variable import Variable

SAMPLES = 101
"""From one end of the output's domain to the other, both included."""


def float_c(program: Program, controller: Controller) -> str:
    """The C, behind the generated header. DoesNotFit where plain tables of triangles will not do."""
    consequents = require_cells(controller)
    infer = controller.infer
    averages = infer.defuzzify == "weighted_average"
    if not averages and (infer.aggregate, infer.implies) != ("max", "min"):
        raise DoesNotFit("sets are scaled and added up")
    interface = interface_of(program, controller)
    cells = controller.cells
    assert cells is not None
    ports = [p for p in program.function(controller.name).outputs if p.variable is not None]
    outputs = [
        _output(interface, port, output, list(terms), averages)
        for port, output, terms in zip(ports, controller.outputs, consequents, strict=True)
    ]
    inputs = [_input(c, of) for c, of in zip(interface.inputs, controller.inputs, strict=True)]
    owners = list(cells.owner) if controller.behaviors else []
    return template("float.c.j2").render(
        header=interface.names.header,
        status_t=interface.names.status_t,
        ok=interface.names.ok,
        function=interface.c.function,
        input_t=interface.c.input_t,
        output_t=interface.c.output_t,
        samples=SAMPLES,
        inputs=inputs,
        outputs=outputs,
        sets=[i["terms"] for i in inputs] + ([] if averages else [o["terms"] for o in outputs]),
        places=[o["places"] for o in outputs] if averages else [],
        centroids=not averages,
        minimum=infer.and_ == "min" or not averages,
        cells=len(cells.owner),
        owners=owners,
        acting_member=interface.c.outputs["acting"] if owners else "",
        loops=_loops(controller, inputs, outputs),
    )


def _loops(controller: Controller, inputs: list[dict[str, Any]], outputs: list[dict[str, Any]]) -> list[str]:
    """Nested loops over the rules, the strength so far kept at every level."""
    lines: list[str] = []
    so_far = ""
    for depth, of in enumerate(inputs):
        pad = "    " * depth
        index, degree = f"i{depth}", f"{of['member']}_degree[i{depth}]"
        lines.append(f"{pad}for (uint8_t {index} = 0U; {index} < {of['count']}U; ++{index}) {{")
        if not so_far:
            joined = degree
        elif controller.infer.and_ == "min":
            joined = f"minimum({so_far}, {degree})"
        else:
            joined = f"{so_far} * {degree}"
        so_far = "strength" if depth + 1 == len(inputs) else f"strength_{depth}"
        lines.append(f"{pad}    const float {so_far} = {joined};")
    pad = "    " * len(inputs)
    for output in outputs:
        level = f"{output['member']}_level"
        if controller.infer.aggregate == "max":
            lines += [f"{pad}k = READ_8({output['rules']}[rule]);"]
            lines += [f"{pad}if (strength > {level}[k]) {{", f"{pad}    {level}[k] = strength;", f"{pad}}}"]
        else:
            lines += [f"{pad}{level}[READ_8({output['rules']}[rule])] += strength;"]
    if controller.behaviors:
        lines += [f"{pad}if (strength > strongest || (strength == strongest && READ_8(owner[rule]) < acting)) {{"]
        lines += [f"{pad}    strongest = strength;", f"{pad}    acting = READ_8(owner[rule]);", f"{pad}}}"]
    lines += [f"{pad}++rule;"]
    return lines + ["    " * depth + "}" for depth in reversed(range(len(inputs)))]


def _input(c: InputC, of: Input) -> dict[str, Any]:
    raw = of.variable.raw
    value = f"(float){c.name} * {_float(raw.step)}"
    if raw.origin != 0:
        value += f" + {_float(raw.origin)}"
    return {
        **{name: getattr(c, name) for name in ("member", "name", "ctype", "lo", "hi", "saturated", "below", "above")},
        "count": len(of.terms),
        "value": value,
        "set": f"{c.member}_terms",
        "terms": {"name": f"{c.member}_terms", "terms": [_triangle(t) for t in of.terms]},
    }


def _output(interface: Interface, port: Port, of: Output, consequents: list[int], averages: bool) -> dict[str, Any]:
    member = interface.c.outputs[port.name]
    count = len(of.terms)
    step = (of.integrate_hi - of.integrate_lo) / (SAMPLES - 1)
    sampled = f"centroid({member}_terms, {member}_level, {count}U, {_float(of.integrate_lo)}, {_float(step)})"
    return {
        "member": member,
        "ctype": f"{port.ctype}_t",
        "lo": port.lo,
        "hi": port.hi,
        "count": count,
        "rules": f"{member}_rules",
        "consequents": [f"{c}U" for c in consequents],
        "terms": {} if averages else {"name": f"{member}_terms", "terms": [_triangle(t) for t in of.terms]},
        "places": {"name": f"{member}_places", "numbers": [_float(_place(t)) for t in of.terms]} if averages else {},
        "defuzzified": f"average({member}_places, {member}_level, {count}U)" if averages else sampled,
        "at": _raw_at(member, of.variable),
    }


def _raw_at(member: str, variable: Variable) -> str:
    raw = variable.raw
    moved = member if raw.origin == 0 else f"({member} - {_float(raw.origin)})"
    return f"{moved} * {_float(1 / raw.step)}"


def _triangle(term: Term) -> dict[str, str]:
    """Peak and 1 over the sides; a side is a shoulder where the term stays at 1."""
    if not isinstance(term.shape, PiecewiseLinear):
        raise DoesNotFit(f"{term.name} is no triangle")
    points = term.shape.points
    tops = [k for k, (_, y) in enumerate(points) if y == 1]
    if len(tops) != 1 or len(points) > 3 or any(y not in (0, 1) for _, y in points):
        raise DoesNotFit(f"{term.name} is no triangle")
    (top,) = tops
    peak = points[top][0]
    rise = 1 / (peak - points[top - 1][0]) if top > 0 else Fraction(0)
    fall = 1 / (points[top + 1][0] - peak) if top + 1 < len(points) else Fraction(0)
    return {"peak": _float(peak), "rise": _float(rise), "fall": _float(fall)}


def _place(term: Term) -> Fraction:
    if not isinstance(term.shape, Singleton):
        raise DoesNotFit(f"{term.name} is no singleton")
    return term.shape.at


def _float(value: Fraction) -> str:
    """A C float literal: nine digits name every float."""
    text = f"{float(value):.9g}"
    return f"{text}F" if any(c in text for c in ".en") else f"{text}.0F"
