"""What the cost model is fitted to: the benchmarks, the examples, families of controllers, and random specs.

Nothing here depends on a machine: the same commit gives the same programs.
"""

from __future__ import annotations

import hashlib
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from itertools import count, islice, product
from pathlib import Path

from fuzzyspec import Source, api
from fuzzyspec.emit import emit
from fuzzyspec.fixed import Program
from fuzzyspec.fixed.build import RangeError
from fuzzyspec.fixed.program import Division
from fuzzyspec.lower.choice import strategies
from fuzzyspec.lower.controller import lower_controller
from fuzzyspec.lower.module import Lowered, Options
from fuzzyspec.lower.strategy import Strategy, Target, Widths
from fuzzyspec.lower.widths import fit_widths
from fuzzyspec.model.controller import Controller
from tests.random_specs.generator import spec as random_spec

ROOT = Path(__file__).resolve().parent.parent
SEED, RANDOM, SYSTEMS = 800, 40, 12
"""Of random specs: the first seed, how many controllers, how many specs with systems."""
DIVISIONS: Mapping[Widths, tuple[Division, ...]] = {
    "words": ("loop", "rounds", "newton", "reciprocal", "hardware"),
    "narrow": ("loop", "unrolled"),
}
"""How the programs for machines of 32 bits and for AVR divide. What the other ways take is known without them
(``scripts/measure_dividers.py``), and no choice falls on them."""
ALL, SEVERAL, ONE = 10**6, 3, 1
"""How many strategies of a controller are measured: of the benchmarks and nav, of the families, of the rest."""
FEW = ("tipper", "temperature")
"""Examples like benchmarks and families that are there."""
STRIDE = 7
"""From one of them to the next: prime to their number, so that every field of a strategy changes."""


@dataclass(frozen=True)
class Item:
    """One program to measure.

    ``strategy`` is None where the controllers' are the default ones (a system). The same program is once for machines
    of 32 bits and once for AVR (``widths``). ``every``: all strategies of the controller are measured.
    """

    spec: str
    function: str
    strategy: Strategy | None
    widths: Widths
    every: bool
    program: Program
    files: dict[str, bytes]

    @property
    def name(self) -> str:
        """The spec and its function; what is held out of a fit is held out by this name."""
        return f"{self.spec}: {self.function}"

    @property
    def digest(self) -> str:
        """Of the C without what tells of the spec, so that a measurement is known to be of this very program."""
        (source,) = (v for k, v in self.files.items() if k.endswith(".c") and not k.endswith("_selftest.c"))
        lines = source.split(b"*/\n", 1)[1].splitlines()
        return hashlib.sha256(b"\n".join(line for line in lines if b"DIGEST" not in line)).hexdigest()[:16]

    @property
    def choices(self) -> dict[str, str] | None:
        """The strategy as data."""
        return None if self.strategy is None else asdict(self.strategy)


def items() -> Iterator[Item]:
    """All programs, in a fixed order. Benchmarks, examples and families by every strategy, the rest by some."""
    for path in (*sorted((ROOT / "benchmarks").glob("*.fz")), *sorted((ROOT / "examples").glob("*.fz"))):
        loaded = api.load(path)
        most = ONE if path.stem.endswith("_raw16") else SEVERAL if path.stem in FEW else ALL
        for controller in loaded.module.controllers:
            yield from _controller(path.stem, loaded, controller, most)
        yield from _systems(path.stem, loaded)
    for name, text in families():
        loaded = api.load(text)
        for controller in loaded.module.controllers:
            yield from _controller(name, loaded, controller, SEVERAL)
    for loaded in islice((s for s in _random() if _all_used(s.module.controllers[-1])), RANDOM):
        yield from _controller(loaded.name, loaded, loaded.module.controllers[-1], ONE)
    for loaded in islice((s for s in _random() if s.systems and all(map(_all_used, s.module.controllers))), SYSTEMS):
        yield from _systems(loaded.name, loaded)


def _random() -> Iterator[api.Spec]:
    for seed in count(SEED):
        yield api.load(random_spec(seed))


def _all_used(controller: Controller) -> bool:
    """Whether the rules set every term of every output. Some compilers find out which they do not, and drop much."""
    used = {(o, t) for rule in controller.sentences for o, t in rule.consequents}
    if controller.cells is not None:
        used |= {(o, t) for o, terms in enumerate(controller.cells.consequents) for t in terms}
    return all((o, t) in used for o, output in enumerate(controller.outputs) for t in range(len(output.terms)))


def _controller(name: str, spec: api.Spec, controller: Controller, most: int) -> Iterator[Item]:
    for widths, divisions in DIVISIONS.items():
        possible = [s for s in strategies(controller) if s.division in divisions]
        start = 0 if most >= len(possible) else zlib.crc32(name.encode())
        step = 1 if most >= len(possible) else STRIDE
        for i in range(min(most, len(possible))):
            strategy = possible[(start + i * step) % len(possible)]
            try:
                yield item_of(name, spec, controller, strategy, widths, most == ALL)
            except RangeError:
                continue


def item_of(name: str, spec: api.Spec, controller: Controller, strategy: Strategy, widths: Widths, every: bool) -> Item:
    """A controller alone by one strategy. Raises RangeError where that does not fit 32 bits."""
    function, _ = lower_controller(controller, strategy)
    module = replace(spec.module, controllers=(controller,), systems=())
    program = Program(module.name, (fit_widths(function, widths),), narrow=widths == "narrow")
    files = dict(emit(module, Lowered(program, {}), _source(name)).files)
    return Item(name, controller.name, strategy, widths, every, program, files)


def _systems(name: str, spec: api.Spec) -> Iterator[Item]:
    """By fixed strategies, so that what is measured does not depend on what was fitted before."""
    explicit = [(s.name, Strategy()) for s in spec.module.systems]
    for controller in spec.module.controllers:
        possible = strategies(controller)
        explicit.append((controller.name, possible[zlib.crc32(name.encode()) % len(possible)]))
    targets: tuple[tuple[Widths, Target], ...] = (("words", "generic"), ("narrow", "avr"))
    for widths, target in targets if spec.module.systems else ():
        lowered = spec.lower(Options(target=target, explicit=tuple(explicit)))
        files = dict(emit(spec.module, lowered, spec.source).files)
        for system in spec.module.systems:
            yield Item(name, system.name, None, widths, False, lowered.program, files)


def _source(name: str) -> Source:
    return Source(name, "")


# --- families that no benchmark is of ----------------------------------------------------------


def families() -> Iterator[tuple[str, str]]:
    """Names and texts."""
    yield (
        "singletons_7x7",
        _table("singletons_7x7", (7, 7), "singletons " + _terms("o", 7), average=True, multiplied=False),
    )
    yield "products_7x7", _table("products_7x7", (7, 7), "singletons " + _terms("o", 7), average=True, multiplied=True)
    yield "three_of_five", _table("three_of_five", (5, 5, 5), "partition " + _terms("o", 5))
    yield "two_of_seven", _table("two_of_seven", (7, 7), "partition " + _terms("o", 7))
    yield "bytes", _table("bytes", (3, 3), "partition " + _terms("o", 3), raw=" raw int8", out=" raw int8")
    yield "one_input", _table("one_input", (5,), "partition " + _terms("o", 5))
    yield "irregular", _irregular()
    yield "otherwise", _otherwise()


def _terms(stem: str, n: int) -> str:
    return " ".join(f"{stem}{i}" for i in range(n))


def _table(
    name: str,
    sizes: tuple[int, ...],
    output: str,
    raw: str = "",
    out: str = "",
    average: bool = False,
    multiplied: bool = False,
) -> str:
    """A full table over strong partitions; the consequents follow the sum of the indices."""
    letters = "abcd"[: len(sizes)]
    terms = output.count(" o")
    lines = [f"module {name}", "controller c {"]
    for letter, n in zip(letters, sizes, strict=True):
        lines.append(f"    input {letter} in [-1, 2]{raw} {{ partition {_terms(letter, n)} }}")
    lines.append(f"    output z in [-3, 4]{out} {{ {output} }}")
    if average:
        lines.append(f"    infer {{ and = {'product' if multiplied else 'min'}, defuzzify = weighted_average }}")
    lines += [*_rows(sizes, terms), "}", ""]
    return "\n".join(lines)


def _rows(sizes: tuple[int, ...], terms: int) -> list[str]:
    """The table of ``z``: the last input across, the others label the rows."""
    letters = "abcd"[: len(sizes)]
    most = 2 * sum(n - 1 for n in sizes) + sizes[0] - 1

    def entry(cell: tuple[int, ...]) -> str:
        return f"o{(2 * sum(cell) + cell[0]) * (terms - 1) // most}"

    if len(sizes) == 1:
        return ["    table z by a {", "        " + "  ".join(f"a{i}: {entry((i,))}" for i in range(sizes[0])), "    }"]
    lines = [f"    table z by {', '.join(letters)} {{", "        " + _terms(letters[-1], sizes[-1])]
    for row in product(*(range(n) for n in sizes[:-1])):
        names = [f"{letter}{i}" for letter, i in zip(letters, row, strict=False)]
        label = names[0] if len(names) == 1 else f"({', '.join(names)})"
        lines.append(f"        {label}: " + " ".join(entry((*row, i)) for i in range(sizes[-1])))
    return [*lines, "    }"]


def _irregular() -> str:
    """25 rules of irregular triangles and trapezoids."""
    shapes = ("ramp_down(0.7, 1.9)", "triangle(0.3, 2.2, 3.1)", "trapezoid(1.7, 2.9, 4.4, 5.2)",
              "triangle(3.7, 5.9, 8.3)", "ramp_up(6.1, 8.8)")  # fmt: skip
    lines = ["module irregular", "controller c {"]
    for letter in "ab":
        lines.append(f"    input {letter} in [0, 10] {{")
        lines += [f"        term {letter}{i} = {s}" for i, s in enumerate(shapes)]
        lines.append("    }")
    lines.append("    output z in [0, 10] {")
    lines += [f"        term o{i} = {s}" for i, s in enumerate(shapes)]
    lines += ["    }", *_rows((5, 5), 5), "}", ""]
    return "\n".join(lines)


def _otherwise() -> str:
    """Sentence rules that leave much of the inputs to `otherwise`."""
    return """\
module otherwise
controller c {
    input a, b in [0, 10] { partition low mid high }
    output z in [0, 1] { partition off on  otherwise 0.25 }
    rules {
        if a is low and b is high then z is on
        if a is high or b is mid then z is off with 0.7
    }
}
"""
