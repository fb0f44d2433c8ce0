"""Ranges and raws: what a variable can be, and the integers that carry it."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from fuzzyspec.check.constants import Constants
from fuzzyspec.check.quantities import number as shown
from fuzzyspec.check.similar import hint, listing
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Span
from fuzzyspec.model.units import ONE, Unit
from fuzzyspec.model.variable import RAW_LIMITS, CType, Raw, Variable
from fuzzyspec.syntax import tree


def finest_exponent(lo: Fraction, hi: Fraction, ctype: CType) -> int:
    """The largest f for which both ``lo * 2**f`` and ``hi * 2**f`` lie within the raw type; it may be negative.

    ``lo`` must not be negative for an unsigned type.
    """
    low, high = RAW_LIMITS[ctype]
    limits = [Fraction(high) / hi] if hi > 0 else []
    if lo < 0:
        limits.append(Fraction(low) / lo)
    if not limits:
        raise ValueError("a range of 0 alone has no finest step")
    most = min(limits)
    # floor(log2(most)), exactly: the estimate from the bit lengths is off by at most one.
    f = most.numerator.bit_length() - most.denominator.bit_length()
    return f if Fraction(2) ** f <= most else f - 1


def default_ctype(lo: Fraction) -> CType:
    """Unsigned where nothing is negative."""
    return "uint16" if lo >= 0 else "int16"


def stepped(lo: Fraction, hi: Fraction, ctype: CType, step: Fraction) -> Raw:
    """Raw 0 is 0; the legal raws are those inside the range (perhaps more than the type holds)."""
    return Raw(ctype, step, Fraction(0), math.ceil(lo / step), math.floor(hi / step))


def default_raw(lo: Fraction, hi: Fraction, ctype: CType | None = None) -> Raw:
    """The finest power of two that fits."""
    chosen = ctype or default_ctype(lo)
    return stepped(lo, hi, chosen, Fraction(2) ** -finest_exponent(lo, hi, chosen))


def counted(lo: Fraction, hi: Fraction, ctype: CType, first: int, last: int) -> Raw:
    """Counts ``first..last`` mapped affinely onto the range, perhaps backwards."""
    step = (hi - lo) / (last - first)
    return Raw(ctype, step, lo - step * first, min(first, last), max(first, last))


class Variables:
    """Checks the ranges and raws of one scope."""

    def __init__(self, constants: Constants) -> None:
        self._constants = constants

    def variable(self, name: tree.Name, range_: tree.Range, raw: tree.RawClause | None) -> Variable | None:
        """A variable, or None where its range or raw is wrong (both are looked at)."""
        unit, ends = self.range(range_)
        if unit is None or ends is None:
            if raw is not None:
                self._ctype(raw)
            return None
        found = self.raw(ends, unit, raw, range_.span)
        return None if found is None else Variable(name.text, *ends, unit, found, name.span)

    def renamed(self, variable: Variable, name: tree.Name) -> Variable:
        return replace(variable, name=name.text, span=name.span)

    # --- ranges ------------------------------------------------------------------------------

    def range(self, written: tree.Range) -> tuple[Unit | None, tuple[Fraction, Fraction] | None]:
        """The unit and the ends in it; each None where it cannot be told."""
        unit = self._unit(written)
        if unit is None:
            return None, None
        where = written.span if written.unit is None else written.unit.span
        lo = self._constants.placed(written.lo, unit, where, "the range")
        hi = self._constants.placed(written.hi, unit, where, "the range")
        if lo is None or hi is None:
            return unit, None
        if lo >= hi:
            what = "empty" if lo == hi else "reversed"
            self._report(
                "FZ401",
                f"this range is {what}",
                written.span,
                "both ends are the same" if lo == hi else "the low end is above the high end",
                "write the low end first, and a higher one after it",
            )
            return unit, None
        return unit, (lo, hi)

    def _unit(self, written: tree.Range) -> Unit | None:
        if written.unit is not None:
            return self._constants.units.resolve(written.unit, self._constants.findings.report)
        for end in (written.lo, written.hi):
            inner = end.operand if isinstance(end, tree.Unary) else end
            if isinstance(inner, tree.Number) and inner.unit is not None:
                return self._constants.units.resolve(inner.unit, self._constants.findings.report)
        return ONE

    # --- raws --------------------------------------------------------------------------------

    def raw(
        self, ends: tuple[Fraction, Fraction], unit: Unit, clause: tree.RawClause | None, where: Span
    ) -> Raw | None:
        """The raw of a range; ``where`` is the range's span."""
        lo, hi = ends
        ctype = default_ctype(lo) if clause is None else self._ctype(clause)
        if ctype is None:
            return None
        if clause is not None and clause.counts is not None:
            return self._counts(ends, ctype, clause.counts, clause)
        low, _ = RAW_LIMITS[ctype]
        if lo < 0 <= low:
            assert clause is not None
            self._report(
                "FZ402",
                f"{ctype} cannot hold this range",
                clause.ctype.span,
                "has no negative numbers",
                f"use `{ctype.removeprefix('u')}`",
                where,
                "goes below 0",
            )
            return None
        if clause is None or clause.step is None:
            raw = default_raw(lo, hi, ctype)
        else:
            step = self._step(clause.step, unit)
            if step is None:
                return None
            raw = stepped(lo, hi, ctype, step)
        span = where if clause is None else clause.span
        return raw if self._fits(raw, ends, unit, span, where) else None

    def _ctype(self, clause: tree.RawClause) -> CType | None:
        known: dict[str, CType] = {t: t for t in RAW_LIMITS}
        text = clause.ctype.text
        if text in known:
            return known[text]
        if text.removesuffix("_t") in known:
            way_out = f"write `{text.removesuffix('_t')}`"
        elif text.removesuffix("_t").endswith(("32", "64")):
            way_out = f"raws have 8 or 16 bits: {listing(known)}"
        else:
            way_out = hint(text, known, "raw types")
        self._report(
            "FZ208", f"unknown raw type `{text}`", clause.ctype.span, "not a type that a raw can have", way_out
        )
        return None

    def _step(self, written: tree.Expr, unit: Unit) -> Fraction | None:
        # A step is a difference, so of a unit with an offset only the scale counts.
        step = self._constants.placed(written, replace(unit, offset=Fraction(0)), written.span, "the step")
        if step is not None and step <= 0:
            self._report(
                "FZ403",
                "the step is not above 0",
                written.span,
                "must be positive",
                "counts can run backwards: `raw uint16 4095..0`" if step < 0 else None,
            )
            return None
        return step

    def _counts(
        self,
        ends: tuple[Fraction, Fraction],
        ctype: CType,
        written: tuple[tree.Expr, tree.Expr],
        clause: tree.RawClause,
    ) -> Raw | None:
        low, high = RAW_LIMITS[ctype]
        counts: list[int] = []
        for expr in written:
            value = self._constants.plain(expr, "a count")
            if value is None:
                continue
            if value.denominator != 1:
                self._report("FZ404", "a count is a whole number", expr.span, "not whole")
            elif not low <= value <= high:
                self._report(
                    "FZ402",
                    f"{ctype} cannot hold this count",
                    expr.span,
                    f"{ctype} goes from {low} to {high}",
                    "use a wider raw type",
                )
            else:
                counts.append(int(value))
        if len(counts) < 2:
            return None
        if counts[0] == counts[1]:
            self._report("FZ404", "both ends of the range have the same count", clause.span, "the counts must differ")
            return None
        return counted(*ends, ctype, counts[0], counts[1])

    def _fits(self, raw: Raw, ends: tuple[Fraction, Fraction], unit: Unit, span: Span, where: Span) -> bool:
        low, high = RAW_LIMITS[raw.ctype]
        if raw.lo < low or raw.hi > high:
            finest = default_raw(*ends, raw.ctype).step
            self._report(
                "FZ402",
                f"{raw.ctype} cannot hold this range at this step",
                span,
                f"would need raws from {raw.lo} to {raw.hi}, {raw.ctype} goes from {low} to {high}",
                f"the finest power of two that fits is {shown(finest)} {unit.symbol}".rstrip()
                + "; without `step` it is chosen for you",
                where,
                "this range",
            )
            return False
        if raw.hi - raw.lo < 1:
            legal = "no raw lies" if raw.hi < raw.lo else "only one raw lies"
            self._report(
                "FZ405",
                f"{legal} inside this range",
                where,
                f"raws are {shown(raw.step)} {unit.symbol}".rstrip() + " apart",
                "map counts onto it, as in `raw uint16 0..65535`, or choose a finer step",
            )
            return False
        return True

    # -----------------------------------------------------------------------------------------

    def _report(
        self,
        code: str,
        message: str,
        span: Span,
        label: str = "",
        help: str | None = None,
        other: Span | None = None,
        caption: str = "",
    ) -> None:
        labels = () if other is None or other == span else (Label(other, caption),)
        self._constants.findings.report(Diagnostic(code, message, span, label, labels, help))
