"""Controllers of random specs: inputs, outputs, tables, behaviors, sentences, inference."""

from __future__ import annotations

import itertools
import random
from dataclasses import dataclass
from fractions import Fraction

from tests.random_specs.spec_numbers import Numbers, Ranged, number
from tests.random_specs.spec_terms import Terms

NAMES = ("k", "at", "cell", "area", "degree", "t", "row", "strength", "level", "u")
"""Input names that the compiler may want for its own locals."""


@dataclass(frozen=True)
class Written:
    """A controller's text and what a system needs to know to call it."""

    name: str
    text: str
    inputs: dict[str, Ranged]
    outputs: dict[str, Ranged]
    behaviors: bool
    holds: bool


@dataclass(frozen=True)
class _Out:
    name: str
    terms: list[str]


class Controllers:
    """Draws controllers."""

    def __init__(self, dice: random.Random) -> None:
        self.dice = dice
        self.numbers = Numbers(dice)
        self.terms = Terms(dice)

    def controller(self, name: str) -> Written:
        """One controller."""
        r = self.dice
        sugeno, spoken = r.random() < 0.25, r.random() < 0.35
        count = r.choice((1, 2, 2, 3, 3, 4)) if r.random() < 0.95 else 5
        most = {1: 7, 2: 7, 3: 5, 4: 3, 5: 3}[count]
        names = r.sample(NAMES, count) if r.random() < 0.2 else [f"x{i}" for i in range(count)]
        lines: list[str] = []
        inputs: dict[str, Ranged] = {}
        labels: dict[str, list[str]] = {}
        strong = True
        alike = count > 1 and r.random() < 0.15
        for i, n in enumerate(names):
            if i == 1 and alike:
                inputs[n], labels[n] = inputs[names[0]], labels[names[0]]
                lines[0] = lines[0].replace(f"input {names[0]} in", f"input {names[0]}, {n} in", 1)
                continue
            inputs[n] = self.numbers.ranged()
            labels[n] = [f"{'ABCDE'[i]}{k}" for k in range(r.randint(2, most))]
            text, is_strong = self.terms.of_input(labels[n], inputs[n], 0.4 if spoken else 0.15)
            strong &= is_strong
            lines.append(f"  input {n} in {inputs[n]} {{ {text} }}")
        settings, product = self.inference(sugeno)
        fires = r.choice((None, None, None, Fraction(1, 10), Fraction(1, 3), Fraction(1, 200)))
        rules_all = not spoken and r.random() < 0.5
        floor = Fraction(1, 2**count) if product else Fraction(1, 2)
        sure = rules_all and strong and (fires or Fraction(1, 64)) <= floor
        outputs: dict[str, Ranged] = {}
        made: list[_Out] = []
        holds = False
        for o in range(r.choice((1, 1, 1, 2, 2, 3))):
            out = _Out(f"y{o}", [f"{'YZW'[o]}{k}" for k in range(r.randint(2, 7))])
            outputs[out.name] = over = self.numbers.ranged()
            text = self.terms.of_output(out.terms, over, sugeno)
            if "term" in text and not sugeno:
                out = _Out(out.name, out.terms[:5])
            settle = "" if sure and r.random() < 0.6 else self.otherwise(over)
            holds |= "hold" in settle
            made.append(out)
            lines.append(f"  output {out.name} in {over} {{ {text} {settle} }}")
        lines += settings
        if fires is not None:
            lines.append(f"  fires at {number(fires)}")
        behaviors = False
        if rules_all:
            lines.append(self.table(labels, made))
        elif spoken:
            lines.append(self.sentences(labels, made))
        elif r.random() < 0.6:
            lines.append(self.behaviors(labels, made))
            behaviors = True
        else:
            lines += [self.table(self.some(labels), [o]) for o in made]
        if not spoken and not behaviors and r.random() < 0.04:
            lines.append("  rules { }")
        text = "\n".join([f"controller {name} {{", *lines, "}"])
        return Written(name, text, inputs, outputs, behaviors, holds)

    def inference(self, sugeno: bool) -> tuple[list[str], bool]:
        """An ``infer`` line or none, and whether ``and`` is the product."""
        settings: dict[str, str] = {}
        if self.dice.random() < (0.6 if sugeno else 0.3):
            settings["and"] = "product"
        if self.dice.random() < 0.25:
            settings["or"] = "probsum"
        if sugeno:
            if self.dice.random() < 0.4:
                settings["aggregate"] = self.dice.choice(("max", "sum"))
            if self.dice.random() < 0.3:
                settings["implies"] = "product"
            if self.dice.random() < 0.5:
                settings["defuzzify"] = "weighted_average"
        if not settings:
            return [], False
        comma = self.dice.choice(("", "", ","))
        return [f"  infer {{ {', '.join(f'{k} = {v}' for k, v in settings.items())}{comma} }}"], "and" in settings

    def otherwise(self, over: Ranged) -> str:
        """What an output is when nothing fires; an end of the range often."""
        at = over.lo + over.span * self.dice.choice(
            (Fraction(0), Fraction(1, 4), Fraction(1, 2), Fraction(1), Fraction(2, 7))
        )
        return f"otherwise {'hold initial ' if self.dice.random() < 0.4 else ''}{number(at)}"

    def some(self, labels: dict[str, list[str]]) -> dict[str, list[str]]:
        """Some of the inputs, in order; the others stand for all their terms."""
        kept = sorted(self.dice.sample(range(len(labels)), self.dice.randint(1, len(labels))))
        return {n: t for i, (n, t) in enumerate(labels.items()) if i in kept}

    # --- rules ------------------------------------------------------------------------------------

    def table(self, labels: dict[str, list[str]], outputs: list[_Out]) -> str:
        """A full table over these inputs."""

        def entry() -> str:
            return "/".join(self.dice.choice(o.terms) for o in outputs)

        head = f"  table {', '.join(o.name for o in outputs)} by {', '.join(labels)} {{"
        *others, last = labels.values()
        if not others:
            return "\n".join([head, *(f"    {t}: {entry()}" for t in last), "  }"])
        lines = [head, "      " + " ".join(last)]
        for row in itertools.product(*others):
            label = row[0] if len(row) == 1 else f"({', '.join(row)})"
            lines.append(f"    {label}: " + "  ".join(entry() for _ in last))
        return "\n".join([*lines, "  }"])

    def behaviors(self, labels: dict[str, list[str]], outputs: list[_Out]) -> str:
        """Rules of a behavior differ in the first input's term, behaviors overlap; a table below them now and then."""
        first, *others = labels
        blocks: list[str] = []
        for priority, behavior in ((30, "Dodge"), (2, "Seek"), (1, "Cruise")):
            rules = []
            for t in labels[first]:
                if priority > 1 and self.dice.random() < 0.5:
                    continue
                parts = [f"{first} is {t}"] + [self.cells(n, labels[n]) for n in others if self.dice.random() < 0.5]
                set_ = outputs if self.dice.random() < 0.8 else [self.dice.choice(outputs)]
                rules.append(f"    if {' and '.join(parts)} then {self.consequents(set_)}")
            if rules:
                blocks.append("\n".join([f"  behavior {behavior} priority {priority} {{", *rules, "  }"]))
        if self.dice.random() < 0.3:
            blocks.append(self.table(self.some(labels), outputs))
        return "\n".join(blocks)

    def cells(self, name: str, terms: list[str]) -> str:
        """A condition on cells."""
        if self.dice.random() < 0.2 and len(terms) > 1:
            return f"{name} is not {self.dice.choice(terms)}"
        chosen = self.dice.sample(terms, self.dice.randint(1, len(terms)))
        return f"{name} is {chosen[0]}" if len(chosen) == 1 else f"{name} in {{{', '.join(chosen)}}}"

    def consequents(self, outputs: list[_Out]) -> str:
        """What follows ``then``."""
        return ", ".join(f"{o.name} is {self.dice.choice(o.terms)}" for o in outputs)

    def sentences(self, labels: dict[str, list[str]], outputs: list[_Out]) -> str:
        """Sentence rules, each output set by one at least."""
        lines = ["  rules {"]
        for _ in range(self.dice.randint(2, 9)):
            chosen = sorted(self.dice.sample(range(len(outputs)), self.dice.randint(1, len(outputs))))
            then = self.consequents([outputs[o] for o in chosen])
            weight = ""
            if self.dice.random() < 0.3:
                weight = f" with {self.dice.choice(('0.8', '0.5', '1/3', 'third', '0.01', '1'))}"
            lines.append(f"    if {self.condition(labels, 3)} then {then}{weight}")
        first = next(iter(labels))
        lines += [f"    if {first} is {labels[first][0]} then {o.name} is {o.terms[0]}" for o in outputs]
        return "\n".join([*lines, "  }"])

    def condition(self, labels: dict[str, list[str]], depth: int) -> str:
        """Any condition of a sentence."""
        if depth == 0 or self.dice.random() < 0.4:
            name = self.dice.choice(list(labels))
            terms = labels[name]
            some = ", ".join(self.dice.sample(terms, 2))
            one = self.dice.choice(terms)
            forms = (f"is {one}", f"is {one}", f"is not {one}", f"in {{{some}}}", f"not in {{{some}}}")
            return f"{name} {self.dice.choice(forms)}"
        if self.dice.random() < 0.2:
            return f"not ({self.condition(labels, depth - 1)})"
        parts = [self.condition(labels, depth - 1) for _ in range(self.dice.randint(2, 3))]
        joint = self.dice.choice((" and ", " or "))
        return f"({joint.join(parts)})"
