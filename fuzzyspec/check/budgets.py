"""The budgets of a controller or system: what they limit, how much, and on which machine."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction

from fuzzyspec.check.arithmetic import Value
from fuzzyspec.check.constants import Constants
from fuzzyspec.check.findings import Report
from fuzzyspec.check.quantities import number
from fuzzyspec.check.similar import listing, nearest
from fuzzyspec.check.units import describe, dims
from fuzzyspec.check.units import written as written_unit
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Span
from fuzzyspec.model.budget import MACHINES, MEMORY, QUANTITIES, TOLD_ON, Budget, Machine, Quantity
from fuzzyspec.model.units import Unit
from fuzzyspec.syntax import tree

BYTES = dims(B=1)
MEMORY_UNITS = (Unit("B", BYTES), Unit("kB", BYTES, Fraction(1000)), Unit("KiB", BYTES, Fraction(1024)))

_BYTES = f"bytes are counted in {listing(u.symbol for u in MEMORY_UNITS)}, as in `flash <= 1 KiB`"
_CALLED = {
    "rom": "flash", "code": "flash", "size": "flash", "memory": "ram", "sram": "ram", "time": "cycles",
    "clocks": "cycles", "ticks": "cycles", "steps": "instructions", "ops": "instructions",
}  # fmt: skip
"""Other words for what can be limited."""
_CORES = (
    ("cortex-m0", "cortex-m0plus"), ("m0", "cortex-m0plus"), ("m4", "cortex-m4"), ("cortex-m4", "cortex-m4"),
    ("m7", "cortex-m7"), ("cortex-m7", "cortex-m7"), ("at", "avr"), ("arduino", "avr"), ("risc", "rv32imc"),
    ("rv32", "rv32imc"),
)  # fmt: skip
"""How other names of the machines begin."""


def check_budgets(items: Iterable[tree.ControllerItem | tree.SystemItem], constants: Constants) -> tuple[Budget, ...]:
    """The limits of all ``budget`` blocks among a declaration's items, in the order of the text.

    Those in which something is wrong are told of and left out.
    """
    checker = _Budgets(constants)
    for item in items:
        if isinstance(item, tree.BudgetBlock):
            for limit in item.limits:
                checker.take(limit)
    return tuple(checker.found)


class _Budgets:
    """What was found so far, and where each was written."""

    def __init__(self, constants: Constants) -> None:
        self._report: Report = constants.findings.report
        self._constants = replace(constants, units=constants.units.extended(MEMORY_UNITS))
        self._written: dict[tuple[Quantity, Machine | None], Span] = {}
        self.found: list[Budget] = []

    def take(self, limit: tree.Limit) -> None:
        quantity = self._quantity(limit.quantity)
        sound, target = self._target(limit.target)
        if limit.op.text != "<=":
            self._say(
                "FZ265",
                "a budget says how much at most",
                limit.op.span,
                f"`{limit.op.text}` does not",
                f"write `{limit.quantity.text} <= ..`",
            )
            sound = False
        if quantity is None:
            return
        value = self._value(quantity, limit.value)
        sound = sound and self._told_there(quantity, target, limit)
        if not sound:
            return
        first = self._written.get((quantity, target))
        if first is not None:
            self._report(
                Diagnostic(
                    "FZ263",
                    f"{quantity}{'' if target is None else f' on {target}'} is limited twice",
                    limit.span,
                    label="limited again here",
                    labels=(Label(first, "first limited here"),),
                    help="drop one of them",
                )
            )
            return
        self._written[quantity, target] = limit.span
        if value is not None:
            self.found.append(Budget(quantity, value, target, limit.span))

    def _quantity(self, name: tree.Name) -> Quantity | None:
        for known in QUANTITIES:
            if name.text == known:
                return known
        likely = _CALLED.get(name.text.lower()) or nearest(name.text, QUANTITIES)
        self._say(
            "FZ260",
            f"`{name.text}` is nothing that a budget limits",
            name.span,
            "unknown quantity",
            f"did you mean `{likely}`?" if likely else f"a budget limits {listing(QUANTITIES)}",
        )
        return None

    def _target(self, name: tree.Name | None) -> tuple[bool, Machine | None]:
        """Whether a target is sound, and which one."""
        if name is None:
            return True, None
        for known in MACHINES:
            if name.text == known:
                return True, known
        likely = next((m for begins, m in _CORES if name.text.lower().startswith(begins)), None)
        likely = likely or nearest(name.text, MACHINES)
        self._say(
            "FZ261",
            f"unknown target `{name.text}`",
            name.span,
            "not a machine that costs are known of",
            f"did you mean `{likely}`?" if likely else f"targets known here: {listing(MACHINES)}",
        )
        return False, None

    def _told_there(self, quantity: Quantity, target: Machine | None, limit: tree.Limit) -> bool:
        """Whether a quantity can be told on a target."""
        if target is None or target in TOLD_ON[quantity]:
            return True
        other = "instructions" if quantity == "cycles" else "cycles"
        why = {
            "avr": "its cycles are counted instead",
            "rv32imc": "every core takes its own",
        }.get(target, "they depend on the flash and on what the core runs side by side")
        assert limit.target is not None
        self._say(
            "FZ264",
            f"{quantity} on {target} cannot be told",
            limit.target.span,
            why,
            f"limit `{other}` there; {quantity} can be limited on {listing(TOLD_ON[quantity])}",
        )
        return False

    def _value(self, quantity: Quantity, written: tree.Expr) -> int | None:
        """The limit, in bytes or as a count."""
        of = BYTES if quantity in MEMORY else ()
        if isinstance(written, tree.Number) and written.unit is not None and not self._fits(written.unit, quantity):
            return None
        value = self._constants.value(written)
        if value is None or value.constant is None:
            return None
        if value.dims != of and not value.zero:
            self._wrong_unit(quantity, value)
            return None
        least = 0 if quantity in ("ram", "stack") else 1
        if value.constant < least:
            self._say(
                "FZ444",
                f"no call keeps to {quantity} <= {number(value.constant)}",
                written.span,
                "below 0" if value.constant < 0 else f"less than {least}",
                "give it what there is: a limit is above 0",
            )
            return None
        return int(value.constant)

    def _fits(self, unit: tree.UnitExpr, quantity: Quantity) -> bool:
        """Whether a single number's unit is one of memory, of a quantity that is counted in bytes."""
        symbols = [u.symbol for u in MEMORY_UNITS]
        if quantity in MEMORY and len(unit.factors) == 1 and unit.factors[0][0] in symbols and unit.factors[0][1] == 1:
            return True
        text = written_unit(unit.factors)
        if quantity not in MEMORY:
            self._say("FZ262", f"{quantity} are a plain count", unit.span, f"`{text}` is a unit", "drop the unit")
            return False
        near = nearest(text, symbols)
        guess = "" if near is None else f"did you mean `{near}`? "
        self._say("FZ262", f"{quantity} is counted in bytes", unit.span, f"`{text}` counts none", guess + _BYTES)
        return False

    def _wrong_unit(self, quantity: Quantity, value: Value) -> None:
        label = f"this is {describe(value.dims)}"
        if quantity in MEMORY:
            self._say("FZ262", f"{quantity} is counted in bytes", value.span, label, _BYTES)
        else:
            self._say("FZ262", f"{quantity} are a plain count", value.span, label, "drop the unit")

    def _say(self, code: str, message: str, span: Span, label: str, help_: str) -> None:
        self._report(Diagnostic(code, message, span, label=label, help=help_))
