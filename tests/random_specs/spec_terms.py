"""Terms of random specs: partitions, singletons, and shapes of every kind."""

from __future__ import annotations

import random
from fractions import Fraction

from tests.random_specs.spec_numbers import Ranged, number


class Terms:
    """Draws what stands in a variable's braces."""

    def __init__(self, dice: random.Random) -> None:
        self.dice = dice

    def of_input(self, names: list[str], over: Ranged, irregular: float) -> tuple[str, bool]:
        """Text, and whether it is a strong partition."""
        kind = self.dice.random()
        if kind < irregular:
            return self.shapes(names, over, holes=True), False
        if kind < irregular + 0.06 and len(names) > 2:
            return f"{self.partition(names[:-1], over, output=False)}  {self.shapes(names[-1:], over)}", False
        return self.partition(names, over, output=False), True

    def of_output(self, names: list[str], over: Ranged, singletons: bool) -> str:
        """Text."""
        if singletons:
            return self.singletons(names, over)
        kind = self.dice.random()
        if kind < 0.3:
            return self.shapes(names[:5], over)
        return self.partition(names, over, output=True)

    def singletons(self, names: list[str], over: Ranged) -> str:
        """Even or placed ones, in any order, two of them perhaps at one place."""
        if self.dice.random() < 0.5:
            return f"singletons {' '.join(names)}"
        places = [over.lo + over.span * Fraction(self.dice.randint(0, 97), 97) for _ in names]
        if self.dice.random() < 0.5:
            placed = ", ".join(f"{n} at {number(p)}" for n, p in zip(names, places, strict=True))
            return f"singletons {placed}"
        return "  ".join(f"term {n} = singleton({number(p)})" for n, p in zip(names, places, strict=True))

    def partition(self, names: list[str], over: Ranged, output: bool) -> str:
        """Even, or with peaks at any place; an input's end peaks, and an output's without ``full``, may lie inside."""
        full = output and self.dice.random() < 0.4
        if self.dice.random() < 0.5:
            return f"partition {' '.join(names)}{' full' if full else ''}"
        grain = self.dice.choice((97, 64, 1009))
        inner = sorted(self.dice.sample(range(1, grain), len(names) - 2))
        peaks = [over.lo, *(over.lo + over.span * Fraction(p, grain) for p in inner), over.hi]
        if not full and self.dice.random() < 0.4:
            peaks[0] += (peaks[1] - peaks[0]) / self.dice.choice((2, 3, 50))
        if not full and self.dice.random() < 0.4:
            peaks[-1] -= (peaks[-1] - peaks[-2]) / self.dice.choice((2, 3, 50))
        # A sign before a quantity turns all of it round, offset included: -5 degC is no temperature below freezing.
        unit = f" {over.unit}" if over.unit not in ("", "degC") and self.dice.random() < 0.3 else ""
        placed = ", ".join(f"{n} at {_with(p, unit)}" for n, p in zip(names, peaks, strict=True))
        return f"partition {placed}{' full' if full else ''}"

    def shapes(self, names: list[str], over: Ranged, holes: bool = False) -> str:
        """Irregular terms, each around its share of the range, some sticking out; with ``holes`` gaps may be left."""
        n = len(names)
        width = over.span / n
        lines: list[str] = []
        for k, name in enumerate(names):
            left, right = over.lo + width * k, over.lo + width * (k + 1)
            reach = Fraction(self.dice.randint(0 if holes else 2, 6), 10) * width
            lines.append(f"term {name} = {self.shape(left - reach, left, right, right + reach, over)}")
        return "  ".join(lines)

    def shape(self, a: Fraction, b: Fraction, c: Fraction, d: Fraction, over: Ranged) -> str:
        """A shape that is positive somewhere between b and c, within a .. d."""
        inner = [b + (c - b) * Fraction(self.dice.randint(0, 8), 8) for _ in range(2)]
        low, high = min(inner), max(inner)
        middle = (low + high) / 2
        match self.dice.randrange(12):
            case 0:
                return _call("ramp_down", high, d) if d > high else _call("ramp_down", b, c)
            case 1:
                return _call("ramp_up", a, low) if low > a else _call("ramp_up", b, c)
            case 2 | 3:
                return _call("triangle", a, middle, d) if a < d else _call("triangle", b, middle, c)
            case 4 | 5 if a < d:
                return _call("trapezoid", a, low, high, d)
            case 6:
                # Edges that stand upright, at an end of the range often.
                return _call("trapezoid", b, b, c, c) if self.dice.random() < 0.5 else _call("triangle", b, b, c)
            case 7:
                return _points((b, 0), (b, 1), (middle, "0.3"), (middle, "0.9"), (c, "0.2"), (c, 0))
            case 8:
                return _points((a, 0), (middle, "0.2"), (middle, 1), (middle, "0.4"), (d, 0))
            case 9:
                return _points((over.lo, "0.1"), (low, "0.7"), (high, "0.7"), (over.hi, "0.05"))
            case 10:
                quarter = (c - b) / 4
                return _points((b, 0), (b + quarter, 1), (b + 2 * quarter, "1/3"), (c - quarter, "0.8"), (c, 0))
            case _:
                return _points((a, 0), (low, "0.6"), (high, 1), (d, 0))


def _with(value: Fraction, unit: str) -> str:
    """A number, or a quantity where it is short enough to be one."""
    text = number(value)
    return f"{text}{unit}" if unit and "/" not in text else text


def _call(name: str, *corners: Fraction) -> str:
    return f"{name}({', '.join(number(c) for c in corners)})"


def _points(*points: tuple[Fraction, int | str]) -> str:
    return f"points({', '.join(f'({number(x)}, {y})' for x, y in points)})"
