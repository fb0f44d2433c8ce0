"""A controller in fuzzylite's own language, for fuzzylite and pyfuzzylite."""

from __future__ import annotations

from benchmarks.peers.task import SAMPLES, averages, corners, place, rules
from fuzzyspec.model.controller import Controller
from fuzzyspec.model.term import Singleton, Term


def fll(controller: Controller) -> str:
    """The engine: Mamdani with clipped sets, or Takagi-Sugeno with constants."""
    average = averages(controller)
    lines = [f"Engine: {controller.name}"]
    for given in controller.inputs:
        lines += [f"InputVariable: {given.name}", "  enabled: true"]
        lines += [f"  range: {float(given.variable.lo)!r} {float(given.variable.hi)!r}", "  lock-range: false"]
        lines += [f"  term: {_term(t)}" for t in given.terms]
    for output in controller.outputs:
        lines += [f"OutputVariable: {output.name}", "  enabled: true"]
        lines += [f"  range: {float(output.integrate_lo)!r} {float(output.integrate_hi)!r}", "  lock-range: false"]
        lines += [f"  aggregation: {'none' if average else 'Maximum'}"]
        lines += [f"  defuzzifier: {'WeightedAverage TakagiSugeno' if average else f'Centroid {SAMPLES}'}"]
        lines += ["  default: nan", "  lock-previous: false"]
        lines += [f"  term: {_term(t)}" for t in output.terms]
    product = controller.infer.and_ == "product"
    lines += ["RuleBlock: rules", "  enabled: true", f"  conjunction: {'AlgebraicProduct' if product else 'Minimum'}"]
    lines += ["  disjunction: none", f"  implication: {'none' if average else 'Minimum'}", "  activation: General"]
    for at, consequents in rules(controller):
        if_ = " and ".join(f"{i.name} is {i.terms[k].name}" for i, k in zip(controller.inputs, at, strict=True))
        then = " and ".join(
            f"{o.name} is {o.terms[k].name}" for o, k in zip(controller.outputs, consequents, strict=True)
        )
        lines.append(f"  rule: if {if_} then {then}")
    return "\n".join(lines) + "\n"


def _term(term: Term) -> str:
    if isinstance(term.shape, Singleton):
        return f"{term.name} Constant {place(term)!r}"
    points = corners(term)
    if len(points) == 3:
        return f"{term.name} Triangle {' '.join(repr(x) for x, _ in points)}"
    (a, at_a), (b, _) = points
    return f"{term.name} Ramp {b!r} {a!r}" if at_a == 1 else f"{term.name} Ramp {a!r} {b!r}"
