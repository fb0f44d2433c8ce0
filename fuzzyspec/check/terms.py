"""The terms of a variable: partitions, singletons and single shapes, checked against its range."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from fuzzyspec.check.constants import Constants
from fuzzyspec.check.names import Names
from fuzzyspec.check.quantities import number as shown
from fuzzyspec.check.shapes import (
    ARGUMENTS,
    COUNTS,
    LATER,
    even_peaks,
    has_area,
    in_order,
    partition,
    reaches,
    shaped,
)
from fuzzyspec.check.similar import hint
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Span
from fuzzyspec.model.term import PiecewiseLinear, Singleton, Term
from fuzzyspec.model.units import ONE, Unit
from fuzzyspec.syntax import tree


@dataclass(frozen=True, slots=True)
class Terms:
    """What was declared: ``names`` are all that rules may speak of, ``terms`` those that could be shaped.

    ``peaks`` and ``full`` are the partition's where one stands alone.
    """

    names: tuple[tree.Name, ...]
    terms: tuple[Term, ...]
    peaks: tuple[Fraction, ...] | None
    full: bool


class TermChecker:
    """Checks the terms of one variable; ``output`` tells of which kind it is."""

    def __init__(
        self, constants: Constants, unit: Unit, ends: tuple[Fraction, Fraction], where: Span, output: bool
    ) -> None:
        self._constants = constants
        self._unit = unit
        self._lo, self._hi = ends
        self._where = where
        self._output = output
        self._names: list[tree.Name] = []
        self._terms: list[Term] = []
        self._known = Names(constants.findings.report, cased=True)

    def check(self, members: tuple[tree.Member, ...]) -> Terms:
        """Every ``partition``, ``singletons`` and ``term`` of a variable."""
        peaks: tuple[Fraction, ...] | None = None
        partitions = [m for m in members if isinstance(m, tree.Partition)]
        kinds = [m for m in members if not isinstance(m, tree.OtherwiseClause)]
        for extra in partitions[1:]:
            self._report(
                "FZ419",
                "a variable has one partition",
                extra.span,
                "a second one",
                "put all terms into one, or write them as `term NAME = triangle(..)`",
                partitions[0].span,
                "the first",
            )
        for m in members:
            match m:
                case tree.Partition():
                    peaks = self._partition(m, alone=len(kinds) == 1)
                case tree.Singletons():
                    self._singletons(m)
                case tree.TermDecl():
                    self._term(m)
                case tree.OtherwiseClause():
                    pass
        full = any(p.full for p in partitions)
        if full and len(kinds) > 1:
            self._report(
                "FZ413",
                "`full` goes with a partition that stands alone",
                partitions[0].span,
                "other terms stand beside it",
                "write every term as a shape of its own",
            )
        self._one_kind()
        alone = len(kinds) == 1 and peaks is not None
        return Terms(tuple(self._names), tuple(self._terms), peaks if alone else None, full and alone)

    # --- partitions --------------------------------------------------------------------------

    def _partition(self, written: tree.Partition, alone: bool) -> tuple[Fraction, ...] | None:
        if written.full and not self._output:
            self._report(
                "FZ413",
                "`full` belongs to outputs",
                written.span,
                "this is an input",
                "drop it: an input's end terms keep their degree 1 beyond the peak",
            )
        for term in written.terms:
            if term.name.text == "full" and term.peak is None:
                self._report(
                    "FZ413",
                    "`full` stands behind the terms of a partition",
                    term.name.span,
                    "read as the name of a term here",
                    "move it to the end; a term of that name can only be placed: `full at 10`",
                )
        placed = self._places(written.terms, written.span, "partition")
        if placed is None:
            return None
        names, peaks = placed
        for a, b, name in zip(peaks, peaks[1:], names[1:], strict=False):
            if b <= a:
                self._report(
                    "FZ412",
                    "the peaks of a partition rise",
                    name.span,
                    f"{self._amount(b)} comes after {self._amount(a)}",
                    "list the terms from low to high",
                )
                return None
        full = written.full and self._output
        if full and (peaks[0] != self._lo or peaks[-1] != self._hi):
            off, end = (names[0], self._lo) if peaks[0] != self._lo else (names[-1], self._hi)
            self._report(
                "FZ413",
                "`full` needs the end peaks on the ends of the range",
                off.span,
                f"this peak is not at {self._amount(end)}",
                f"place it there: `{off.text} at {self._amount(end)}`, or drop `full`",
                self._where,
                "the range",
            )
            return None
        shapes = partition(peaks, full)
        for name, shape in zip(names, shapes, strict=True):
            self._add(name, shape)
        return peaks if alone and len({n.text for n in names}) == len(names) else None

    def _singletons(self, written: tree.Singletons) -> None:
        if not self._output:
            self._singleton_input(written.span)
            self._names += [t.name for t in written.terms]
            return
        placed = self._places(written.terms, written.span, "set of singletons")
        if placed is not None:
            for name, at in zip(*placed, strict=True):
                self._add(name, Singleton(at))

    def _places(
        self, terms: tuple[tree.PlacedTerm, ...], span: Span, what: str
    ) -> tuple[tuple[tree.Name, ...], tuple[Fraction, ...]] | None:
        """Names and peaks, even where none is given; None where one is wrong (the names are noted all the same)."""
        names = tuple(t.name for t in terms)
        fresh = [self._known.declare("term", n) for n in names]
        self._names += names
        if len(terms) < 2:
            self._report("FZ417", f"a {what} has two terms or more", span, f"has {len(terms)}")
            return None
        given = [t for t in terms if t.peak is not None]
        if not given:
            return (names, even_peaks(self._lo, self._hi, len(terms))) if all(fresh) else None
        peaks: list[Fraction] = []
        for t in terms:
            if t.peak is None:
                self._report(
                    "FZ417",
                    "either every term has a place or none has",
                    t.name.span,
                    "has no place",
                    f"write `{t.name.text} at ..`",
                )
            elif (peak := self._in_range(t.peak)) is not None:
                peaks.append(peak)
        return (names, tuple(peaks)) if len(peaks) == len(terms) and all(fresh) else None

    def _in_range(self, written: tree.Expr) -> Fraction | None:
        peak = self._number(written)
        if peak is not None and not self._lo <= peak <= self._hi:
            self._report(
                "FZ411",
                "this peak is outside of the range",
                written.span,
                f"{self._amount(peak)} is not in [{shown(self._lo)}, {shown(self._hi)}]",
                "move it inside, or widen the range",
                self._where,
                "the range",
            )
            return None
        return peak

    # --- single shapes -----------------------------------------------------------------------

    def _term(self, written: tree.TermDecl) -> None:
        if not self._known.declare("term", written.name):
            return
        self._names.append(written.name)
        shape = written.shape.text
        if shape not in ARGUMENTS:
            way_out = (
                "smooth shapes are not built in yet: approximate it with `points((x, y), ..)`"
                if shape in LATER
                else hint(shape, ARGUMENTS, "shapes")
            )
            self._report("FZ206", f"unknown shape `{shape}`", written.shape.span, "not a shape", way_out)
            return
        if shape == "points":
            self._points(written)
            return
        args = [self._number(a) for a in written.arguments]
        if len(args) != COUNTS[shape]:
            self._report(
                "FZ217",
                f"`{shape}` takes {COUNTS[shape]} arguments, not {len(args)}",
                written.span,
                "",
                f"write `{ARGUMENTS[shape]}`",
            )
            return
        corners = [a for a in args if a is not None]
        if len(corners) < len(args):
            return
        if shape == "singleton":
            if not self._output:
                self._singleton_input(written.span)
            elif self._in_range(written.arguments[0]) is not None:
                self._add(written.name, Singleton(corners[0]))
            return
        if not in_order(shape, corners):
            self._report(
                "FZ414",
                f"the arguments of `{shape}` are not in order",
                written.arguments[0].span.to(written.arguments[-1].span),
                "they must rise" if shape not in ("triangle", "trapezoid") else "they must not fall, nor all be equal",
                f"write `{ARGUMENTS[shape]}` from low to high",
            )
            return
        self._add(written.name, shaped(shape, corners), written.span)

    def _points(self, written: tree.TermDecl) -> None:
        xs = [self._number(a) for a in written.arguments[0::2]]
        ys = [self._height(a) for a in written.arguments[1::2]]
        if len(xs) != len(ys) or len(xs) < 2:
            self._report(
                "FZ217", "`points` takes two or more pairs", written.span, "", f"write `{ARGUMENTS['points']}`"
            )
            return
        good = [(x, y) for x, y in zip(xs, ys, strict=True) if x is not None and y is not None]
        if len(good) < len(xs):
            return
        for i in range(1, len(good)):
            if good[i][0] < good[i - 1][0]:
                self._report(
                    "FZ415",
                    "the points of a term go from low to high",
                    written.arguments[2 * i].span,
                    f"{self._amount(good[i][0])} comes after {self._amount(good[i - 1][0])}",
                    "sort them",
                )
                return
        self._add(written.name, PiecewiseLinear(tuple(good)), written.span)

    def _height(self, written: tree.Expr) -> Fraction | None:
        y = self._constants.placed(written, ONE, written.span, "a membership")
        if y is not None and not 0 <= y <= 1:
            self._report("FZ415", "a membership lies in [0, 1]", written.span, f"{shown(y)} is outside")
            return None
        return y

    def _add(self, name: tree.Name, shape: PiecewiseLinear | Singleton, span: Span | None = None) -> None:
        if isinstance(shape, PiecewiseLinear):
            if not reaches(shape.points, self._lo, self._hi):
                self._report(
                    "FZ410",
                    f"the term `{name.text}` lies wholly outside of the range",
                    span or name.span,
                    "its degree is 0 everywhere inside",
                    "move it, or widen the range",
                    self._where,
                    "the range",
                )
                return
            if self._output and not has_area(shape.points, self._lo, self._hi):
                self._report(
                    "FZ410",
                    f"the term `{name.text}` has no area inside of the range",
                    span or name.span,
                    "a centroid cannot take it into account",
                    "widen it, or use `singleton(..)`",
                    self._where,
                    "the range",
                )
                return
        self._terms.append(Term(name.text, shape, name.span if span is None else span))

    # -----------------------------------------------------------------------------------------

    def _one_kind(self) -> None:
        pointed = [t for t in self._terms if isinstance(t.shape, Singleton)]
        shaped_ = [t for t in self._terms if not isinstance(t.shape, Singleton)]
        if pointed and shaped_:
            self._report(
                "FZ416",
                "singletons and shapes do not go together in one output",
                pointed[0].span,
                "this is a singleton",
                "a weighted average takes singletons, a centroid takes shapes",
                shaped_[0].span,
                "this is a shape",
            )

    def _singleton_input(self, span: Span) -> None:
        self._report(
            "FZ416", "an input has no singletons", span, "almost no value would ever meet it", "use a narrow triangle"
        )

    def _number(self, written: tree.Expr) -> Fraction | None:
        return self._constants.placed(written, self._unit, self._where, "the range")

    def _amount(self, value: Fraction) -> str:
        return f"{shown(value)} {self._unit.symbol}".rstrip()

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
        labels = () if other is None else (Label(other, caption),)
        self._constants.findings.report(Diagnostic(code, message, span, label, labels, help))
