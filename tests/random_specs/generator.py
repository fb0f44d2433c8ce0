"""Random valid specs over the language: sizes, shapes, raws, inference kinds, behaviors, chains, lists."""

from __future__ import annotations

import random
from fractions import Fraction

RAWS = ("", "", "", " raw uint16", " raw int16", " raw int8", " raw uint8")


class SpecWriter:
    """Writes one spec from one seed."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.name = f"spec{seed}"

    def number(self, lo: float, hi: float) -> Fraction:
        digits = self.random.choice((0, 1, 2, 3))
        return Fraction(self.random.randint(int(lo * 10**digits), int(hi * 10**digits)), 10**digits)

    def range(self, raw: str) -> tuple[Fraction, Fraction]:
        low_zero = raw in (" raw uint16", " raw uint8") or self.random.random() < 0.4
        lo = Fraction(0) if low_zero and self.random.random() < 0.7 else self.number(0 if low_zero else -200, 50)
        span = self.number(1, 100) if self.random.random() < 0.8 else self.number(200, 3000)
        return lo, lo + max(span, Fraction(1, 2))

    def raw(self) -> str:
        raw = self.random.choice(RAWS)
        return raw

    def counts(self, raw: str) -> str:
        """Counts or a step for some of the raws, else nothing."""
        if self.random.random() < 0.12:
            ends = self.random.choice(
                (" raw uint16 0..4095", " raw uint16 4095..0", " raw int16 -1000..1000", " raw uint8 0..200")
            )
            return ends
        return raw

    def terms(self, prefix: str, count: int) -> list[str]:
        return [f"{prefix}{i}" for i in range(count)]

    def partition(self, names: list[str], lo: Fraction, hi: Fraction, output: bool) -> str:
        full = " full" if output and self.random.random() < 0.4 else ""
        if self.random.random() < 0.5 or len(names) < 2:
            return f"partition {' '.join(names)}{full}"
        inner = sorted(self.random.sample(range(1, 97), len(names) - 2))
        peaks = [lo, *(lo + (hi - lo) * Fraction(p, 97) for p in inner), hi]
        if not output and self.random.random() < 0.3:
            peaks[0] = lo + (peaks[1] - lo) / 3
        placed = ", ".join(f"{n} at {number(p)}" for n, p in zip(names, peaks, strict=True))
        return f"partition {placed}{full}"

    def shapes(self, names: list[str], lo: Fraction, hi: Fraction) -> str:
        """Irregular terms that together leave no point uncovered: neighbours overlap."""
        n = len(names)
        cuts = [lo + (hi - lo) * Fraction(k, n) for k in range(n + 1)]
        width = (hi - lo) / n
        lines: list[str] = []
        for k, name in enumerate(names):
            a, d = cuts[k] - width * self.part(), cuts[k + 1] + width * self.part()
            kind = self.random.choice(("trapezoid", "points", "triangle"))
            b = cuts[k] + width * Fraction(self.random.randint(0, 4), 10)
            c = cuts[k + 1] - width * Fraction(self.random.randint(0, 4), 10)
            if k == 0 and self.random.random() < 0.5:
                lines.append(f"term {name} = ramp_down({number(c)}, {number(d)})")
            elif k == n - 1 and self.random.random() < 0.5:
                lines.append(f"term {name} = ramp_up({number(a)}, {number(b)})")
            elif kind == "points":
                y = Fraction(self.random.randint(5, 9), 10)
                points = ", ".join(f"({number(x)}, {number(v)})" for x, v in ((a, 0), (b, y), (c, 1), (d, 0)))
                lines.append(f"term {name} = points({points})")
            elif kind == "triangle":
                lines.append(f"term {name} = triangle({number(a)}, {number((b + c) / 2)}, {number(d)})")
            else:
                lines.append(f"term {name} = trapezoid({number(a)}, {number(b)}, {number(c)}, {number(d)})")
        return "  ".join(lines)

    def part(self) -> Fraction:
        return Fraction(self.random.randint(2, 6), 10)

    def controller(self, name: str, sentences: bool | None = None) -> tuple[str, list[str], list[str]]:
        """Text, input names, output names."""
        r = self.random
        sugeno = r.random() < 0.25
        spoken = r.random() < 0.3 if sentences is None else sentences
        inputs = r.choice((1, 2, 2, 3, 3, 4)) if r.random() < 0.93 else 5
        budget = {1: 7, 2: 7, 3: 5, 4: 3, 5: 3}[inputs]
        lines = [f"controller {name} {{"]
        names, terms = [], []
        for i in range(inputs):
            raw = self.counts(self.raw())
            lo, hi = self.range(raw)
            labels = self.terms("ABCDE"[i], r.randint(2, budget))
            irregular = r.random() < (0.5 if spoken else 0.15)
            body = self.shapes(labels, lo, hi) if irregular else self.partition(labels, lo, hi, output=False)
            names.append(f"x{i}")
            terms.append(labels)
            lines.append(f"  input x{i} in [{number(lo)}, {number(hi)}]{raw} {{ {body} }}")
        outputs, consequents = [], []
        for o in range(r.choice((1, 1, 2))):
            raw = self.counts(self.raw())
            lo, hi = self.range(raw)
            labels = self.terms("YZ"[o], r.randint(2, 7))
            if sugeno:
                body = f"singletons {' '.join(labels)}"
            elif r.random() < 0.25:
                body = self.shapes(labels, lo, hi)
            else:
                body = self.partition(labels, lo, hi, output=True)
            settle = r.choice(
                (f"otherwise {number(lo + (hi - lo) / 4)}", f"otherwise hold initial {number((lo + hi) / 2)}")
            )
            outputs.append(f"y{o}")
            consequents.append(labels)
            lines.append(f"  output y{o} in [{number(lo)}, {number(hi)}]{raw} {{ {body}  {settle} }}")
        if sugeno:
            infer = (
                "and = product, defuzzify = weighted_average" if r.random() < 0.7 else "defuzzify = weighted_average"
            )
            lines.append(f"  infer {{ {infer} }}")
        elif r.random() < 0.2:
            lines.append("  infer { and = product }")
        if spoken:
            lines.append(self.sentences(names, terms, outputs, consequents))
        elif r.random() < 0.3:
            lines.append(self.behaviors(names, terms, outputs, consequents))
        else:
            lines.append(self.table(names, terms, outputs, consequents))
        lines.append("}")
        return "\n".join(lines), names, outputs

    def table(self, names: list[str], terms: list[list[str]], outputs: list[str], consequents: list[list[str]]) -> str:
        def entry() -> str:
            return "/".join(self.random.choice(c) for c in consequents)

        head = f"  table {', '.join(outputs)} by {', '.join(names)} {{"
        if len(names) == 1:
            return "\n".join([head, *(f"    {t}: {entry()}" for t in terms[0]), "  }"])
        rows = [[]]
        for labels in terms[:-1]:
            rows = [[*row, t] for row in rows for t in labels]
        lines = [head, "      " + " ".join(terms[-1])]
        for row in rows:
            label = row[0] if len(row) == 1 else f"({', '.join(row)})"
            lines.append(f"    {label}: " + "  ".join(entry() for _ in terms[-1]))
        return "\n".join([*lines, "  }"])

    def behaviors(
        self, names: list[str], terms: list[list[str]], outputs: list[str], consequents: list[list[str]]
    ) -> str:
        """Rules disjoint within a behavior (by the first input's term), overlapping between them, maybe with holes."""
        blocks = []
        for priority, behavior in ((3, "Dodge"), (2, "Seek"), (1, "Cruise")):
            rules = []
            for t in terms[0]:
                if priority > 1 and self.random.random() < 0.5:
                    continue
                parts = [f"x0 is {t}"]
                for name, labels in zip(names[1:], terms[1:], strict=True):
                    if self.random.random() < 0.5:
                        some = self.random.sample(labels, self.random.randint(1, len(labels)))
                        parts.append(f"{name} is {some[0]}" if len(some) == 1 else f"{name} in {{{', '.join(some)}}}")
                then = ", ".join(f"{o} is {self.random.choice(c)}" for o, c in zip(outputs, consequents, strict=True))
                rules.append(f"    if {' and '.join(parts)} then {then}")
            if rules:
                blocks.append("\n".join([f"  behavior {behavior} priority {priority} {{", *rules, "  }"]))
        return "\n".join(blocks)

    def sentences(
        self, names: list[str], terms: list[list[str]], outputs: list[str], consequents: list[list[str]]
    ) -> str:
        def atom() -> str:
            i = self.random.randrange(len(names))
            kind = self.random.random()
            if kind < 0.2:
                return f"{names[i]} is not {self.random.choice(terms[i])}"
            if kind < 0.4:
                return f"{names[i]} in {{{', '.join(self.random.sample(terms[i], 2))}}}"
            return f"{names[i]} is {self.random.choice(terms[i])}"

        lines = ["  rules {"]
        for _ in range(self.random.randint(3, 9)):
            condition = atom()
            for _ in range(self.random.randint(0, 2)):
                joined = f"{condition} {self.random.choice(('and', 'or'))} {atom()}"
                condition = f"not ({joined})" if self.random.random() < 0.15 else f"({joined})"
            chosen = self.random.sample(range(len(outputs)), self.random.randint(1, len(outputs)))
            then = ", ".join(f"{outputs[o]} is {self.random.choice(consequents[o])}" for o in sorted(chosen))
            weight = f" with {self.random.choice(('0.8', '0.5', '1/3'))}" if self.random.random() < 0.3 else ""
            lines.append(f"    if {condition} then {then}{weight}")
        for output, labels in zip(outputs, consequents, strict=True):
            lines.append(f"    if x0 is {terms[0][0]} then {output} is {labels[0]}")
        return "\n".join([*lines, "  }"])

    def spec(self) -> str:
        r = self.random
        parts = [f"module {self.name}"]
        controllers = [self.controller(f"stage{i}") for i in range(r.choice((1, 1, 2, 3)))]
        parts += [text for text, _, _ in controllers]
        if len(controllers) > 1 or r.random() < 0.4:
            parts.append(self.system(controllers))
        return "\n".join(parts) + "\n"

    def system(self, controllers: list[tuple[str, list[str], list[str]]]) -> str:
        """A chain: each stage takes the outputs of the one before, and arithmetic over inputs and a list."""
        r = self.random
        lines = ["system chain {", "  param gain = 1.7"]
        lines.append(f"  input u in [{number(self.number(-50, 0))}, {number(self.number(1, 80))}]")
        lines.append(f"  input w in [0, {number(self.number(1, 40))}]")
        lists = r.random() < 0.6
        if lists:
            capacity = r.choice((1, 3, 32))
            lines.append(
                f"  input items[{capacity}] {{ size in [0, {number(self.number(1, 9))}], side in [-180, 180] }}"
            )
            if r.random() < 0.5:
                lines += ["  for each o in items {", "    let o.part = max(0, o.size * 3 - w / 7 - 0.2)", "  }"]
                body = "o.part"
            else:
                body = "o.size"
            fold = r.choice(("max", "min", "sum", "count"))
            test = r.choice(("", " if o.side in [-90, 30]", " if o.size > 0.7", " if -20 <= o.side < 41.5"))
            head = "o" if fold == "count" else body
            fallback = "" if fold in ("sum", "count") else r.choice((", otherwise 0", ", otherwise 1.3"))
            lines.append(f"  let seen = {fold}({head} for o in items{test}{fallback})")
        source = ["u", "w"] + (["seen"] if lists else [])
        available = list(source)
        for i, (_, names, outputs) in enumerate(controllers):
            arguments = []
            for name in names:
                arguments.append(f"{name}: {self.expression(available)}")
            lines.append(f"  let c{i} = stage{i}({', '.join(arguments)})")
            available = [f"c{i}.{o}" for o in outputs] + source
        last = len(controllers) - 1
        lines.append(f"  output y = c{last}.{controllers[-1][2][0]}")
        lines.append(f"  output z in [-60, 60] = {self.expression(available)}")
        return "\n".join([*lines, "}"])

    def expression(self, available: list[str]) -> str:
        r = self.random
        a, b = r.choice(available), r.choice(available)
        return r.choice(
            (
                a,
                f"{a} * gain",
                f"{a} - {b} / 3",
                f"max({a}, {b} - 2.5)",
                f"abs({a}) + 0.3",
                f"clamp({a} + {b}, -7, 20.5)",
                f"({a} if u > 0.3 else {b})",
                f"{a} / (w + 0.5)" if r.random() < 0.5 else f"{a} / w otherwise 1",
                f"{a} * {b} / 10",
            )
        )


def number(value: Fraction) -> str:
    """A decimal where it ends soon, else a quotient (constant expressions are exact)."""
    for digits in range(5):
        if (value * 10**digits).denominator == 1:
            whole = int(value * 10**digits)
            sign, whole = ("-" if whole < 0 else ""), abs(whole)
            text = str(whole).rjust(digits + 1, "0")
            return sign + (text if digits == 0 else f"{text[:-digits]}.{text[-digits:]}")
    return f"{value.numerator}/{value.denominator}"


def spec(seed: int) -> str:
    """The spec of a seed."""
    return SpecWriter(seed).spec()
