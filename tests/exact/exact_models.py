"""Models built by hand: the paper's danger controller, the benchmarks, and random ones."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from hypothesis import strategies as st

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.model.controller import (
    And,
    Antecedent,
    Behavior,
    CellRules,
    Controller,
    Fallback,
    Inference,
    Input,
    Is,
    Not,
    Or,
    Output,
    SentenceRule,
)
from fuzzyspec.model.term import PiecewiseLinear, Shape, Singleton, Term
from fuzzyspec.model.units import ONE, Unit
from fuzzyspec.model.variable import Raw, Variable

NOWHERE = Span(0, 0)
Number = int | str | Fraction


def variable(name: str, lo: Number, hi: Number, unit: Unit = ONE) -> Variable:
    """A variable whose raws are the 65,536 counts from lo to hi."""
    low, high = Fraction(lo), Fraction(hi)
    return Variable(name, low, high, unit, Raw("uint16", (high - low) / 65535, low, 0, 65535), NOWHERE)


def shape(*points: tuple[Number, Number]) -> PiecewiseLinear:
    """A shape through points."""
    return PiecewiseLinear(tuple((Fraction(x), Fraction(y)) for x, y in points))


def term(name: str, of: Shape) -> Term:
    """A term."""
    return Term(name, of, NOWHERE)


def partition_shapes(peaks: Sequence[Fraction]) -> list[PiecewiseLinear]:
    """Triangles of a strong partition, the ends shouldered."""
    if len(peaks) == 1:
        return [shape((peaks[0], 1))]
    shapes = [shape((peaks[0], 1), (peaks[1], 0))]
    shapes += [shape((a, 0), (b, 1), (c, 0)) for a, b, c in zip(peaks, peaks[1:], peaks[2:], strict=False)]
    return [*shapes, shape((peaks[-2], 0), (peaks[-1], 1))]


def even(lo: Number, hi: Number, count: int) -> list[Fraction]:
    """Evenly spaced peaks, the ends on the range's."""
    low, high = Fraction(lo), Fraction(hi)
    return [low + (high - low) * k / (count - 1) for k in range(count)]


def partitioned(name: str, peaks: Sequence[Number], unit: Unit = ONE) -> Input:
    """An input with a strong partition that spans its range."""
    exact = [Fraction(p) for p in peaks]
    terms = tuple(term(f"T{k}", s) for k, s in enumerate(partition_shapes(exact)))
    return Input(variable(name, exact[0], exact[-1], unit), terms, tuple(exact))


def partitioned_output(
    name: str, peaks: Sequence[Number], full: bool = False, fallback: Fallback | None = None, unit: Unit = ONE
) -> Output:
    """An output with a strong partition; ``full`` mirrors the ends' inner halves."""
    exact = [Fraction(p) for p in peaks]
    shapes = partition_shapes(exact)
    lo, hi = exact[0], exact[-1]
    if full:
        first, last = exact[1] - exact[0], exact[-1] - exact[-2]
        shapes[0] = shape((lo - first, 0), (lo, 1), (lo + first, 0))
        shapes[-1] = shape((hi - last, 0), (hi, 1), (hi + last, 0))
        lo, hi = lo - first, hi + last
    terms = tuple(term(f"T{k}", s) for k, s in enumerate(shapes))
    return Output(variable(name, exact[0], exact[-1], unit), terms, tuple(exact), full, lo, hi, fallback)


def output_of(name: str, lo: Number, hi: Number, shapes: Sequence[Shape], fallback: Fallback | None = None) -> Output:
    """An output with terms of any shape."""
    terms = tuple(term(f"T{k}", s) for k, s in enumerate(shapes))
    return Output(variable(name, lo, hi), terms, None, False, Fraction(lo), Fraction(hi), fallback)


def controller(
    inputs: Sequence[Input],
    outputs: Sequence[Output],
    cells: CellRules | None = None,
    sentences: Sequence[SentenceRule] = (),
    **more: Any,
) -> Controller:
    """A controller; an output without an ``otherwise`` is taken to fire always."""
    given: dict[str, Any] = {
        "name": "c",
        "infer": Inference(),
        "fires_at": Fraction(1, 64),
        "behaviors": (),
        "always_fires": tuple(o.fallback is None for o in outputs),
        "span": NOWHERE,
    } | more
    return Controller(inputs=tuple(inputs), outputs=tuple(outputs), cells=cells, sentences=tuple(sentences), **given)


def table(inputs: Sequence[Input], *consequents: Sequence[int], owner: Sequence[int] | None = None) -> CellRules:
    """One row of term indices an output, cells in row-major order."""
    size = tuple(len(i.terms) for i in inputs)
    return CellRules(size, tuple(tuple(c) for c in consequents), tuple(owner or [0] * len(consequents[0])))


def sentence(antecedent: Antecedent, *consequents: tuple[int, int], weight: Number = 1) -> SentenceRule:
    """A sentence rule."""
    return SentenceRule(antecedent, tuple(consequents), Fraction(weight), NOWHERE)


def danger(full: bool = True) -> Controller:
    """Layer 1 of the paper's robot (Table 1), which is the benchmark W2 without ``full``."""
    inputs = [partitioned("eta_t", even(0, 6, 3)), partitioned("eta_d", even(0, 4, 3))]
    by_row = {"DS": "BBB", "DM": "BMM", "DB": "BMS"}  # eta_d down, eta_t across
    cells = ["SMB".index(by_row[d][t]) for t, d in itertools.product(range(3), ("DS", "DM", "DB"))]
    output = partitioned_output("ddc", even(0, 1, 3), full)
    return controller(inputs, [output], table(inputs, cells), name="danger")


def w3(singletons: bool = False) -> Controller:
    """Benchmark W3: four inputs of three terms, 81 cells, outputs of five and seven terms; or W3s."""
    inputs = [partitioned(n, even(0, 1, 3)) for n in ("l", "f", "r")] + [partitioned("t", even(-90, 90, 3))]
    v, w = [], []
    for a, b, c, t in itertools.product(range(3), repeat=4):
        v.append(max(0, 4 - 2 * b - (a + c + abs(t - 1)) // 2))
        w.append(min(6, max(0, 3 + (a - c) + (t - 1) * (2 - b))))
    peaks_v, peaks_w = even(0, "0.7", 5), even(-1, 1, 7)
    if not singletons:
        outputs = [partitioned_output("v", peaks_v), partitioned_output("w", peaks_w)]
        return controller(inputs, outputs, table(inputs, v, w))
    outputs = [
        output_of("v", 0, "0.7", [Singleton(p) for p in peaks_v]),
        output_of("w", -1, 1, [Singleton(p) for p in peaks_w]),
    ]
    infer = Inference(and_="product", aggregate="sum", defuzzify="weighted_average")
    return controller(inputs, outputs, table(inputs, v, w), infer=infer)


# --- random models -----------------------------------------------------------------------------


def grid(lo: int, hi: int, den: int = 64) -> st.SearchStrategy[Fraction]:
    """Rationals that float64 holds, so that both meanings start from the same numbers."""
    return st.integers(lo * den, hi * den).map(lambda n: Fraction(n, den))


@st.composite
def peak_lists(draw: st.DrawFn, most: int = 5) -> list[Fraction]:
    """Two or more strictly increasing peaks, uneven."""
    low = draw(grid(-8, 8))
    gaps = draw(st.lists(st.integers(1, 256).map(lambda n: Fraction(n, 64)), min_size=1, max_size=most - 1))
    return list(itertools.accumulate(gaps, initial=low))


@st.composite
def irregular(draw: st.DrawFn, jumps: bool = True) -> PiecewiseLinear:
    """A triangle, trapezoid, ramp or list of points inside [0, 8]; ``points`` may jump."""
    kind = draw(st.sampled_from(["triangle", "trapezoid", "up", "down", "points"]))
    if kind == "points":
        xs = sorted(draw(st.lists(grid(0, 8, 8), min_size=1, max_size=4, unique=not jumps)))
        ys = draw(st.lists(grid(0, 1, 16), min_size=len(xs), max_size=len(xs)))
        return PiecewiseLinear(tuple(zip(xs, ys, strict=True)))
    count = {"triangle": 3, "trapezoid": 4, "up": 2, "down": 2}[kind]
    xs = sorted(draw(st.lists(grid(0, 8, 16), min_size=count, max_size=count, unique=True)))
    ys = {"triangle": (0, 1, 0), "trapezoid": (0, 1, 1, 0), "up": (0, 1), "down": (1, 0)}[kind]
    return shape(*zip(xs, ys, strict=True))


@st.composite
def inputs_of(draw: st.DrawFn, name: str, strong: bool | None = None, jumps: bool = True) -> Input:
    """A strong partition, or one to four irregular terms over [0, 8]."""
    if strong is None:
        strong = draw(st.booleans())
    if strong:
        return partitioned(name, draw(peak_lists()))
    shapes = draw(st.lists(irregular(jumps), min_size=1, max_size=4))
    return Input(variable(name, 0, 8), tuple(term(f"T{k}", s) for k, s in enumerate(shapes)), None)


def antecedents(inputs: Sequence[Input]) -> st.SearchStrategy[Antecedent]:
    """Trees of is, not, and, or."""
    leaves = [
        st.lists(st.integers(0, len(i.terms) - 1), min_size=1, max_size=len(i.terms), unique=True).map(
            lambda terms, number=number: Is(number, tuple(terms))
        )
        for number, i in enumerate(inputs)
    ]
    return st.recursive(
        st.one_of(leaves),
        lambda inner: st.one_of(
            inner.map(Not),
            st.lists(inner, min_size=2, max_size=3).map(lambda o: And(tuple(o))),
            st.lists(inner, min_size=2, max_size=3).map(lambda o: Or(tuple(o))),
        ),
        max_leaves=4,
    )


@st.composite
def controllers(draw: st.DrawFn, jumps: bool = True, infer: Inference | None = None) -> Controller:
    """Any controller of the language: cells or sentences, shapes or singletons, with ``otherwise``."""
    inputs = [draw(inputs_of(f"x{k}", jumps=jumps)) for k in range(draw(st.integers(1, 3)))]
    infer = infer or Inference(
        draw(st.sampled_from(["min", "product"])),
        draw(st.sampled_from(["max", "probsum"])),
        draw(st.sampled_from(["min", "product"])),
        draw(st.sampled_from(["max", "sum"])),
        draw(st.sampled_from(["centroid", "weighted_average"])),
    )
    outputs = []
    for k in range(draw(st.integers(1, 2))):
        name, fallback = f"y{k}", Fallback(draw(grid(0, 1)), draw(st.booleans()))
        if infer.defuzzify == "weighted_average":
            places = draw(st.lists(grid(0, 8, 16), min_size=1, max_size=5))
            outputs.append(output_of(name, 0, 8, [Singleton(p) for p in places], fallback))
        elif draw(st.booleans()):
            outputs.append(partitioned_output(name, draw(peak_lists()), draw(st.booleans()), fallback))
        else:
            shapes = draw(st.lists(irregular(jumps), min_size=1, max_size=4))
            outputs.append(output_of(name, 0, 8, shapes, fallback))
    if draw(st.booleans()):
        cells = 1
        for i in inputs:
            cells *= len(i.terms)
        codes = draw(st.integers(0, 3))
        rows = [draw(st.lists(st.integers(-1, len(o.terms) - 1), min_size=cells, max_size=cells)) for o in outputs]
        owner = draw(st.lists(st.integers(0, codes), min_size=cells, max_size=cells))
        behaviors = tuple(Behavior(f"B{c}", c, 10 - c, NOWHERE) for c in range(1, codes + 1))
        return controller(inputs, outputs, table(inputs, *rows, owner=owner), infer=infer, behaviors=behaviors)
    consequents = st.sampled_from([(o, t) for o, out in enumerate(outputs) for t in range(len(out.terms))])
    rules = draw(
        st.lists(
            st.builds(
                lambda antecedent, which, weight: sentence(antecedent, *which, weight=weight),
                antecedents(inputs),
                st.lists(consequents, min_size=1, max_size=2, unique_by=lambda c: c[0]),
                st.integers(1, 16).map(lambda n: Fraction(n, 16)),
            ),
            min_size=1,
            max_size=5,
        )
    )
    return controller(inputs, outputs, sentences=rules, infer=infer)


@st.composite
def points_of(draw: st.DrawFn, of: Controller) -> dict[str, Fraction]:
    """A value an input, often on a breakpoint, sometimes outside the range."""
    chosen = {}
    for i in of.inputs:
        lo, hi = i.variable.lo, i.variable.hi
        bends = [x for t in i.terms if isinstance(t.shape, PiecewiseLinear) for x, _ in t.shape.points]
        inside = st.integers(0, 4096).map(lambda n, lo=lo, hi=hi: lo + (hi - lo) * Fraction(n, 4096))
        chosen[i.name] = draw(st.one_of(inside, st.sampled_from(bends), st.sampled_from([lo - 1, hi + 1])))
    return chosen
