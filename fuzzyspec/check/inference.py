"""How a controller infers: the settings of ``infer``, their defaults, and what goes together."""

from __future__ import annotations

from typing import get_args, get_type_hints

from fuzzyspec.check.findings import Report
from fuzzyspec.check.similar import hint, listing
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Span
from fuzzyspec.model.controller import Inference, Output
from fuzzyspec.model.term import Singleton
from fuzzyspec.syntax import tree

_FIELDS = {"and": "and_", "or": "or_", "implies": "implies", "aggregate": "aggregate", "defuzzify": "defuzzify"}
_HINTS = get_type_hints(Inference)
VALUES: dict[str, tuple[str, ...]] = {name: get_args(_HINTS[field]) for name, field in _FIELDS.items()}
"""The settings and the values that each may have."""


def resolve_inference(decl: tree.ControllerDecl, outputs: tuple[Output, ...], report: Report) -> Inference:
    """The settings of all ``infer`` blocks; where nothing is said, what the outputs' terms call for."""
    said: dict[str, tree.Setting] = {}
    for item in decl.items:
        if isinstance(item, tree.InferBlock):
            for setting in item.settings:
                _read(setting, said, report)
    pointed = [o for o in outputs if o.terms and all(isinstance(t.shape, Singleton) for t in o.terms)]
    values = {name: s.value.text for name, s in said.items()}
    if "defuzzify" not in values and pointed:
        values["defuzzify"] = "weighted_average"
    if "aggregate" not in values and values.get("defuzzify") == "weighted_average":
        values["aggregate"] = "sum"
    infer = Inference(**{_FIELDS[name]: value for name, value in values.items()})  # type: ignore[arg-type]
    _check_terms(infer, outputs, pointed, said, decl.name.span, report)
    _check_supported(infer, said, decl.name.span, report)
    return infer


def _read(setting: tree.Setting, said: dict[str, tree.Setting], report: Report) -> None:
    name, value = setting.name, setting.value
    if name.text not in VALUES:
        report(
            Diagnostic(
                "FZ207",
                f"unknown setting `{name.text}`",
                name.span,
                label="not a setting of `infer`",
                help=hint(name.text, VALUES, "settings"),
            )
        )
    elif value.text not in VALUES[name.text]:
        report(
            Diagnostic(
                "FZ207",
                f"`{name.text}` cannot be `{value.text}`",
                value.span,
                label="not a method known here",
                help=f"`{name.text}` is one of {listing(VALUES[name.text])}",
            )
        )
    elif name.text in said:
        report(
            Diagnostic(
                "FZ210",
                f"setting `{name.text}` is given twice",
                setting.span,
                label="given again here",
                labels=(Label(said[name.text].span, "first given here"),),
                help="drop one of them",
            )
        )
    else:
        said[name.text] = setting


def _check_terms(
    infer: Inference,
    outputs: tuple[Output, ...],
    pointed: list[Output],
    said: dict[str, tree.Setting],
    where: Span,
    report: Report,
) -> None:
    """Weighted average goes with singletons, centroid with shapes."""
    shaped = [o for o in outputs if o.terms and o not in pointed]
    wrong = shaped if infer.defuzzify == "weighted_average" else pointed
    for o in wrong:
        asked = said.get("defuzzify")
        other = Label(asked.value.span, "asked for here") if asked is not None else None
        if other is None and pointed:
            other = Label(pointed[0].variable.span, f"`{pointed[0].name}` has singletons, so the average is taken")
        has = "shapes" if o in shaped else "singletons"
        wants = "singletons: `term A = singleton(x)`" if o in shaped else "shapes, such as `partition A B C`"
        report(
            Diagnostic(
                "FZ421",
                f"`{infer.defuzzify}` does not go with the {has} of `{o.name}`",
                o.variable.span,
                label=f"its terms are {has}",
                labels=() if other is None else (other,),
                help=f"give it {wants}, or change `defuzzify`",
            )
        )


def _check_supported(infer: Inference, said: dict[str, tree.Setting], where: Span, report: Report) -> None:
    if infer.defuzzify != "centroid" or (infer.implies == "min" and infer.aggregate == "max"):
        return
    off = [
        said[n] for n, usual in (("implies", "min"), ("aggregate", "max")) if n in said and said[n].value.text != usual
    ]
    report(
        Diagnostic(
            "FZ420",
            f"a centroid with implies = {infer.implies} and aggregate = {infer.aggregate} is not supported",
            off[0].span if off else where,
            label="no closed form for this one yet",
            help="supported: centroid with implies = min and aggregate = max, or weighted_average with singletons",
        )
    )
