"""The counted limit: what a call of a controller takes where someone writes it out by hand and wastes nothing.

It is a yardstick and not a proof. ``docs/limit.md`` tells what is counted and why, step by step in the order of this
module, and lists the sequences of instructions that the steps' prices come from (``cost.prices``).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import accumulate
from math import ceil, factorial, log2, prod

from fuzzyspec.cost.blocks import Axis, Block, blocks
from fuzzyspec.cost.measure import Measured, Record
from fuzzyspec.cost.prices import REGISTERS, core_of, fits, price
from fuzzyspec.cost.shapes import cut, even, overlaps, places, rounded, whole
from fuzzyspec.model.controller import And, Antecedent, Controller, Is, Not, Or, Output
from fuzzyspec.model.system import System

OWN_CODE = 16
"""Blocks that get code of their own at most: what one takes (some 100 bytes) times this is more than a step's flash."""

Steps = Counter[str]
"""How often each step of ``cost.prices`` is taken, on the mean: numbers of any size, not only whole ones."""


def limit(controller: Controller, target: str) -> int:
    """What a call takes at the least, in instructions of the target, or in cycles on AVR."""
    core = core_of(target)
    return ceil(sum(times * price(step, core) for step, times in steps(controller, core).items()))


@lru_cache(maxsize=64)
def steps(controller: Controller, core: str) -> Steps:
    """The steps of a call, as means over inputs that are spread evenly: of the ways to find what fires the cheapest."""
    ways = (_Call(controller, core), _Call(controller, core, by_shape=True))
    return min((way.steps for way in ways), key=lambda found: sum(n * price(step, core) for step, n in found.items()))


def with_limits(measured: Measured, functions: Mapping[str, Controller | System]) -> Measured:
    """The records with the limits of the controllers; a system's crisp arithmetic is not counted."""
    return replace(measured, records=tuple(_limited(r, functions[r.function]) for r in measured.records))


def _limited(record: Record, function: Controller | System) -> Record:
    if not isinstance(function, Controller):
        return record
    found = limit(function, record.target)
    if record.target == "avr":
        return replace(record, cycles_limit=found)
    return replace(record, instructions_limit=found)


def _step(**times: float) -> Steps:
    found = Steps()
    for name, n in times.items():
        found[name] = n  # type: ignore[assignment]
    return found


def _scaled(found: Steps, by: float) -> Steps:
    return _step(**{name: n * by for name, n in found.items()})


def _sum(parts: Iterable[Steps]) -> Steps:
    total = Steps()
    for part in parts:
        total.update(part)
    return total


@dataclass(frozen=True)
class _Call:
    """A controller on a core, and what its parts take."""

    controller: Controller
    core: str
    by_shape: bool = False

    @cached_property
    def axes(self) -> tuple[Axis, ...]:
        return tuple(Axis(i) for i in self.controller.inputs)

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        return tuple(blocks(self.controller, self.axes))

    @property
    def n(self) -> int:
        return len(self.axes)

    @property
    def partitions(self) -> bool:
        """Cells over strong partitions alone: at most two terms of an input are active, and their degrees sum to 1."""
        return self.controller.cells is not None and all(i.peaks is not None for i in self.controller.inputs)

    @property
    def sorted(self) -> bool:
        """Strengths are minors in their order."""
        return self.partitions and self.controller.infer.and_ == "min"

    @property
    def multilinear(self) -> bool:
        infer = self.controller.infer
        means = infer.defuzzify == "weighted_average" and infer.aggregate == "sum"
        complete = self.controller.cells is not None and all(min(c) >= 0 for c in self.controller.cells.consequents)
        return self.partitions and complete and infer.and_ == "product" and means

    @property
    def many(self) -> bool:
        """More blocks than get code of their own."""
        return prod(len(a.pieces) for a in self.axes) > OWN_CODE

    @property
    def by_level(self) -> bool:
        """Cells are looked up one by one, strongest first."""
        return self.sorted and self.n > 2 and not (self.by_shape and self.n == 3)

    @property
    def shared(self) -> bool:
        """Blocks of one shape share their code, which is looked up."""
        return self.sorted and not self.by_level and self.many

    @property
    def scattered(self) -> bool:
        """What a cell names is looked up, and its strength kept with its term's in memory."""
        return self.controller.cells is not None and not self.sorted and self.many

    @cached_property
    def steps(self) -> Steps:
        parts = [_step(call=1), *(self._placed(a) for a in self.axes)]
        if self.multilinear:
            parts.append(self._interpolated())
        else:
            parts += [self._fired(), self._defuzzified(), self._otherwise()]
        parts += [self._written(o) for o in self.controller.outputs]
        parts.append(_step(address=self._tables))
        if self.controller.behaviors:
            asked = 1 if self.sorted else sum(b.share * len(b.sloped) for b in self.blocks)
            parts.append(_step(cell=1 if self.sorted else 0, test=0 if self.sorted else asked, store_byte=1))
        return _sum([*parts, self._spilled()])

    @property
    def _tables(self) -> int:
        """Tables that are read, besides those of other steps."""
        if self.by_level:
            return 1 + len(self.controller.outputs)
        return 2 if self.scattered else int(self.multilinear or self.shared)

    # --- inputs ------------------------------------------------------------------------------

    def _placed(self, axis: Axis) -> Steps:
        """Load a raw, saturate it, find its piece, compute the degrees that are wanted there."""
        raw = axis.given.variable.raw
        byte = raw.ctype in ("uint8", "int8")
        load = _step(**{"load" + "_signed" * raw.ctype.startswith("int") + "_byte" * byte: 1})
        looked_up = self.by_level or self.multilinear or self.shared
        found = [self._by_tests(axis, byte)]
        if looked_up and axis.even:
            found.append(self._by_scale(axis, byte))
        cheapest = min(found, key=self._price)
        if looked_up or self.scattered:
            cheapest.update(_step(prepare=1) if self.by_level else _step(add=1))
        return _sum([load, cheapest])

    def _price(self, found: Steps) -> float:
        return sum(times * price(step, self.core) for step, times in found.items())

    def _tests(self, thresholds: list[int], byte: bool, times: float) -> Steps:
        """So many comparisons of a raw with these thresholds, of which some may be short."""
        short = [fits(self.core, t, byte) for t in thresholds]
        share = sum(short) / max(len(short), 1)
        return _step(short_threshold=times * share, threshold=times * (1 - share))

    def _by_tests(self, axis: Axis, byte: bool) -> Steps:
        """A tree of tests finds the piece, and for minors which half of it."""
        found = self._tests(
            axis.thresholds, byte, axis.mean_tests(halves=self.sorted) + axis.mean_saturation(halves=self.sorted)
        )
        lines, complements = self._lines(axis)
        if axis.shifted and lines:
            found.update(_step(shift_line=lines, add=(lines / 2 if self.sorted else 0) + complements))
        else:
            found.update(_step(**{"line_byte" if byte else "line": lines}, add=complements))
        return found

    def _by_scale(self, axis: Axis, byte: bool) -> Steps:
        """Pieces of one width: the upper bits of a line, or of the raw, count them; the lower ones are the degree."""
        upper = axis.lengths
        found = self._tests(upper, byte, len(upper))
        found.update(_step(test=axis.sides - len(upper)))
        line = "shift_line" if axis.shifted else "line_byte" if byte else "line"
        found.update(_step(**{line: 1}, split=1))
        if self.sorted:
            found.update(_step(test=1, add=0.5))
        return found

    def _lines(self, axis: Axis) -> tuple[float, float]:
        """Lines for an input, and degrees that are 1 minus another."""
        if self.sorted or self.multilinear:
            return float(sum(p.share for p in axis.pieces if p.sloped)), 0.0
        complements = float(sum(p.share * p.complements for p in axis.pieces))
        return float(sum(p.share * len(p.sloped) for p in axis.pieces)) - complements, complements

    # --- firing ------------------------------------------------------------------------------

    def _fired(self) -> Steps:
        if self.controller.cells is None:
            return self._sentences()
        outputs = self.controller.outputs
        if self.sorted:
            order = log2(factorial(self.n))
            if self.shared and self.n > 2:
                # Too many orders for code of their own: minima over 2, 3 .. inputs, and of what names a term again.
                again = sum(b.share * sum(len(named) - len(set(named)) for named in b.named) for b in self.blocks)
                minima = sum(2**i for i in range(2, self.n + 1)) + again
                return _step(minimum=minima, add=self.n + len(outputs), dispatch=1, cell=1)
            if not self.by_level:
                return _step(test=order, add=1 + self.shared * len(outputs), dispatch=self.shared, cell=self.shared)
            ordered = _step(exchange=order, add=1)
            if self.controller.infer.aggregate == "sum":
                return ordered
            bits = sum(len(o.terms) for o in outputs)
            more = ceil(bits / (8 if self.core == "avr" else 32)) - 1
            return _sum([ordered, _scaled(_step(cell=1, more=more), 2**self.n)])
        found = _sum(_scaled(self._cells_of(b), b.share) for b in self.blocks)
        if self.scattered:
            terms = sum(len(o.terms) for o in outputs)
            found.update(_step(store=terms / 2, load=terms, test=terms))
        return found

    def _cells_of(self, block: Block) -> Steps:
        """Each active cell's strength by itself, joined with what names the same term."""
        infer = self.controller.infer
        if self.scattered:
            found = _step(cell=len(block.sloped), update=sum(len(named) for named in block.named))
        else:
            joins = sum(len(named) - len(set(named)) for named in block.named)
            found = _step(**{"minimum" if infer.aggregate == "max" else "sum": joins})
        if infer.and_ == "min":
            found.update(_step(minimum=sum(max(0, n - 1) for n in block.sloped)))
        else:
            active = [len(p.active) for p in block.pieces]
            found.update(_step(multiply=sum(list(accumulate(active, lambda a, b: a * b))[1:])))
        return found

    def _sentences(self) -> Steps:
        """Literals that are not settled by the block, joined; then the consequents of what may fire."""
        infer = self.controller.infer
        total = Steps()
        for block in self.blocks:
            seen: list[tuple[int, int]] = []
            found = Steps()
            for rule in self.controller.sentences:
                literals = _literals(rule.antecedent, [p.active for p in block.pieces])
                if literals == 0:
                    continue
                joined = {"minimum" if infer.and_ == "min" else "multiply": max(0.0, literals - 1)}
                found.update(_step(**joined))
                found.update(_step(multiply=int(rule.weight != 1)))
                again = sum(c in seen for c in rule.consequents)
                found.update(_step(**{"minimum" if infer.aggregate == "max" else "sum": again}))
                seen += rule.consequents
            total.update(_scaled(found, block.share))
        return total

    def _named(self, block: Block) -> list[set[int]]:
        """The terms of each output that can have a strength in a block."""
        if self.controller.cells is not None:
            return [set(named) for named in block.named]
        active = [p.active for p in block.pieces]
        live = [r for r in self.controller.sentences if _literals(r.antecedent, active)]
        return [
            {term for r in live for o, term in r.consequents if o == k} for k in range(len(self.controller.outputs))
        ]

    def _otherwise(self) -> Steps:
        """Whether the strongest strength is enough."""
        total = Steps()
        for k, output in enumerate(self.controller.outputs):
            if output.fallback is None or self.controller.always_fires[k]:
                continue
            total.update(_step(threshold=1))
            if not self.sorted:
                others = sum(b.share * max(0, len(self._named(b)[k]) - 1) for b in self.blocks)
                total.update(_step(minimum=others))
        return total

    # --- outputs -----------------------------------------------------------------------------

    def _known(self, block: Block, k: int) -> bool:
        """One term alone, whose mean does not depend on its strength: nothing is computed, unless all blocks share
        their code."""
        output, named = self.controller.outputs[k], self._named(block)[k]
        if self.by_level or self.scattered:
            return False
        return len(named) <= 1 and all(whole(output, t) for t in named)

    def _defuzzified(self) -> Steps:
        infer = self.controller.infer
        outputs = self.controller.outputs
        if self.by_level and infer.aggregate == "max" and all(even(o) for o in outputs):
            ends = sum(
                b.share * sum(not whole(o, t) for t in named)
                for b in self.blocks
                for o, named in zip(outputs, self._named(b), strict=True)
            )
            levels = self.n + 1
            return _step(level=levels, weights=levels * len(outputs), cube=ends, sum=ends)
        if self.by_level and infer.defuzzify == "weighted_average" and infer.aggregate == "sum":
            return _step(cell=2**self.n * len(outputs), singleton=(self.n + 1) * len(outputs))
        return _sum(_scaled(self._centroids(b), b.share) for b in self.blocks)

    def _centroids(self, block: Block) -> Steps:
        """The sums of a block's outputs, from the strengths of its terms."""
        infer = self.controller.infer
        found, squares = Steps(), 0
        for k, (output, named) in enumerate(zip(self.controller.outputs, self._named(block), strict=True)):
            if self._known(block, k) or not named:
                continue
            if infer.defuzzify == "weighted_average":
                found.update(_step(singleton=len(named)))
                continue
            meeting = overlaps(output, named) if infer.aggregate == "max" else 0
            if infer.implies == "product":
                found.update(_step(singleton=len(named) + meeting, quotient=meeting, multiply=meeting))
                continue
            if not self.sorted:
                found.update(_step(minimum=meeting, threshold=meeting))
            if even(output):
                squares += len(named)
                ends = sum(not whole(output, t) for t in named)
                found.update(_step(sum=2 * len(named) - 2 + ends, scaled_sum=2 * len(named), cube=ends))
            else:
                cuts, wholes = (sum(f(output, t) for t in named) for f in (cut, whole))
                found.update(_step(quadratic=len(named) + meeting, threshold=cuts))
                found.update(_step(cubic=len(named) + meeting - wholes, moment=wholes))
        found.update(_step(square=min(squares, self.n + 1) if self.sorted else squares))
        return found

    def _written(self, output: Output) -> Steps:
        """The quotient, scaled to raws, stored."""
        raw = output.variable.raw
        store = "store_byte" if raw.ctype in ("uint8", "int8") else "store"
        if self.multilinear:
            return _step(**{store: 1, "line": 0, "round": 1} if rounded(output) else {store: 1, "line": 1})
        k = self.controller.outputs.index(output)
        divided = 1 - sum(b.share for b in self.blocks if self._known(b, k))
        return _step(**{store: 1, "quotient": divided, "round" if rounded(output) else "line": divided})

    def _interpolated(self) -> Steps:
        """Multilinear interpolation between the 2^n corners of a block."""
        n, m = self.n, len(self.controller.outputs)
        if n == 1:
            return _step(add=1, lerp=m, cell=m)
        packed = self.core != "avr" and all(places(o) < 2**7 for o in self.controller.outputs)
        groups, words = 2 ** (n - 2), ceil(m / 2) if packed else m
        pairs = m // 2 if packed else 0
        corners = "corners" if all(places(o) < 2**8 for o in self.controller.outputs) else "wide_corners"
        found = _step(inner=1, unpack=groups * pairs, lerp=(groups - 1) * m, add=n - 1)
        found.update(_step(**{corners: groups * words}))
        return found

    # --- registers ---------------------------------------------------------------------------

    def _spilled(self) -> Steps:
        """What lives at once and finds no register; AVR's are saved for the caller once a call."""
        n, m = self.n, len(self.controller.outputs)
        told = any(a.sides for a in self.axes)
        free = REGISTERS[self.core] + (0 if told else 1)
        if self.core == "avr":
            squares = min(n + 1, max(sum(len(named) for named in self._named(b)) for b in self.blocks))
            pairs = 4 * m + 7 if self.by_level or self.multilinear else n + 7 + 1.5 * squares
            return _step(spill=max(0, pairs - free))
        if self.multilinear:
            outer = max(0, n - 2)
            found = max(0, 9 + 2 * outer + outer * ceil(m / 2) - free)
        elif self.by_level:
            found = max(0, n + 6 - free) + (n + 1) * max(0, 2 * m + 8 - free)
        else:
            found = max(0, self._most_values() - free)
        return _step(spill=found, frame=int(found > 0))

    def _most_values(self) -> int:
        """Most words that live at once where blocks have their code: degrees while strengths are found, then strengths
        and their squares, area, moment and a word to work with; always the status and where the outputs go."""
        found = 0
        for block in self.blocks:
            degrees = 0 if self.sorted else sum(len(p.sloped) for p in block.pieces) + (7 if self.scattered else 4)
            for output, named in zip(self.controller.outputs, self._named(block), strict=True):
                strengths = min(len(named), self.n + 1) if self.sorted else len(named)
                found = max(found, degrees, strengths + (strengths if even(output) else 1) + 5)
        return found


def _literals(antecedent: Antecedent, active: Sequence[Sequence[int]]) -> float:
    """How many literals decide a strength in a block: 0 where it is 0 there."""
    match antecedent:
        case Is(given, terms):
            return sum(t in active[given] for t in terms)
        case Not(operand):
            return max(1, _literals(operand, active))
        case And(operands):
            found = [_literals(o, active) for o in operands]
            return sum(found) if all(found) else 0
        case Or(operands):
            return sum(_literals(o, active) for o in operands)
