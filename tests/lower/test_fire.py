"""Degrees to levels: every cell and every sentence, one by one."""

from __future__ import annotations

import itertools
import random
from collections.abc import Mapping
from fractions import Fraction

import numpy as np
import pytest

from fuzzyspec.fixed.program import Const, Expr, Stmt
from fuzzyspec.lower.fire import Firing, fire
from fuzzyspec.lower.fuzzify import fuzzify
from fuzzyspec.lower.lines import DEGREE_ONE
from fuzzyspec.lower.minors import applies, fire_minors
from fuzzyspec.lower.scope import Scope
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
from fuzzyspec.model.term import PiecewiseLinear, Singleton
from fuzzyspec.model.units import ONE
from fuzzyspec.model.variable import Raw, Variable
from tests.lower.lower_models import NOWHERE, input_of, output_of, partition, terms
from tests.lower.lower_running import given as reading
from tests.lower.lower_running import outcome

F = Fraction
CASES = 60


def variable(name: str) -> Variable:
    """Bytes from 0 to 1."""
    return Variable(name, F(0), F(1), ONE, Raw("uint8", F(1, 255), F(0), 0, 255), NOWHERE)


def an_input(dice: random.Random, name: str) -> Input:
    """A strong partition, or shapes of which several overlap."""
    own = variable(name)
    if dice.random() < 0.6:
        inner = sorted(dice.sample(range(1, 20), dice.randint(0, 3)))
        return input_of(own, [F(0), *(F(k, 20) for k in inner), F(1)])
    shapes = [
        PiecewiseLinear(tuple((F(x, 8), F(dice.choice((0, 1, 2, 2)), 2)) for x in sorted(dice.choices(range(9), k=4))))
        for _ in range(dice.randint(2, 4))
    ]
    return Input(own, terms(shapes), None)


def an_output(dice: random.Random, name: str, singletons: bool) -> Output:
    """Two to five terms."""
    count = dice.randint(2, 5)
    at = [F(k, count - 1) for k in range(count)]
    shapes = [Singleton(p) for p in at] if singletons else list(partition(at))
    return output_of(variable(name), shapes, Fallback(F(0), False))


def antecedent(dice: random.Random, inputs: list[Input], depth: int) -> Antecedent:
    """Any condition."""
    kind = dice.randrange(4) if depth else 0
    if kind == 0:
        i = dice.randrange(len(inputs))
        count = len(inputs[i].terms)
        return Is(i, tuple(sorted(dice.sample(range(count), dice.randint(1, min(2, count))))))
    if kind == 1:
        return Not(antecedent(dice, inputs, depth - 1))
    operands = tuple(antecedent(dice, inputs, depth - 1) for _ in range(dice.randint(2, 3)))
    return And(operands) if kind == 2 else Or(operands)


def a_controller(seed: int) -> Controller:
    """Random rules over random inputs, with every combination of norms."""
    dice = random.Random(seed)
    singletons = dice.random() < 0.4
    inputs = [an_input(dice, f"x{i}") for i in range(dice.randint(1, 3))]
    outputs = [an_output(dice, f"y{o}", singletons) for o in range(dice.randint(1, 2))]
    infer = Inference(
        and_=dice.choice(("min", "product")),
        or_=dice.choice(("max", "probsum")),
        aggregate=dice.choice(("max", "sum")) if singletons else "max",
        defuzzify="weighted_average" if singletons else "centroid",
    )
    cells, sentences, behaviors = None, (), ()
    if dice.random() < 0.5:
        shape = tuple(len(i.terms) for i in inputs)
        count = int(np.prod(shape))
        low = dice.choice((0, -1))
        consequents = tuple(tuple(dice.randint(low, len(o.terms) - 1) for _ in range(count)) for o in outputs)
        owner = tuple(0 for _ in range(count))
        if dice.random() < 0.6:
            owner = tuple(dice.randint(0, 3) for _ in range(count))
            behaviors = tuple(Behavior(f"B{k}", k, 9 - k, NOWHERE) for k in (1, 2, 3))
        cells = CellRules(shape, consequents, owner)
    else:
        sentences = tuple(
            SentenceRule(
                antecedent(dice, inputs, 2),
                tuple((o, dice.randrange(len(out.terms))) for o, out in enumerate(outputs) if dice.random() < 0.8)
                or ((0, 0),),
                dice.choice((F(1), F(1), F(4, 5), F(1, 3))),
                NOWHERE,
            )
            for _ in range(dice.randint(1, 5))
        )
    return Controller(
        "c",
        tuple(inputs),
        tuple(outputs),
        infer,
        F(1, 64),
        cells,
        sentences,
        behaviors,
        tuple(False for _ in outputs),
        NOWHERE,
    )


class Reference:
    """The rules word by word, in rationals, over degrees that are given."""

    def __init__(self, controller: Controller, degrees: list[list[F]]) -> None:
        self.controller = controller
        self.degrees = degrees

    def both(self, parts: list[F]) -> F:
        """``and``."""
        return min(parts) if self.controller.infer.and_ == "min" else F(np.prod([*parts, F(1)], dtype=object))

    def either(self, parts: list[F]) -> F:
        """``or``."""
        if self.controller.infer.or_ == "max":
            return max(parts)
        return 1 - F(np.prod([1 - p for p in parts], dtype=object))

    def truth(self, node: Antecedent) -> F:
        """Of a condition."""
        match node:
            case Is(i, chosen):
                return self.either([self.degrees[i][t] for t in chosen])
            case Not(operand):
                return 1 - self.truth(operand)
            case And(operands):
                return self.both([self.truth(o) for o in operands])
            case Or(operands):
                return self.either([self.truth(o) for o in operands])

    def rules(self) -> list[tuple[F, Mapping[int, int], int]]:
        """Strength, output to term, owner; of every cell and sentence."""
        c = self.controller
        found: list[tuple[F, Mapping[int, int], int]] = []
        if c.cells is not None:
            for number, cell in enumerate(itertools.product(*(range(n) for n in c.cells.shape))):
                strength = self.both([d[t] for d, t in zip(self.degrees, cell, strict=True)])
                then = {o: row[number] for o, row in enumerate(c.cells.consequents) if row[number] >= 0}
                found.append((strength, then, c.cells.owner[number]))
        for rule in c.sentences:
            found += [(rule.weight * self.truth(rule.antecedent), {o: t}, 0) for o, t in rule.consequents]
        return found

    def level(self, output: int, term: int) -> F:
        """The strongest rule of a term, or the sum of all."""
        strengths = [s for s, then, _ in self.rules() if then.get(output) == term]
        return sum(strengths, F(0)) if self.controller.infer.aggregate == "sum" else max(strengths, default=F(0))

    def strongest(self, output: int) -> F:
        """The strongest rule that sets an output."""
        return max((s for s, then, _ in self.rules() if output in then), default=F(0))

    def acting(self) -> int:
        """Owner of the strongest owned cell, the smallest code on equal strength, 0 where none is above 0."""
        return min(((-s, owner) for s, _, owner in self.rules() if owner and s > 0), default=(F(0), 0))[1]


def fired(controller: Controller, seed: int, minors: bool) -> tuple[dict[str, np.ndarray], Firing, list[np.ndarray]]:
    """Levels, strongest strengths and acting of random raws; and the integer degrees there (terms, cases)."""
    scope, body = Scope(), list[Stmt]()
    degrees, given = [], []
    for item in controller.inputs:
        define, raw = reading(item.name, "uint8", 0, 255)
        scope.name(item.name)
        steps, found = fuzzify(item, raw, scope, bool(controller.sentences), minors)
        body += [define, *steps]
        degrees.append(found)
    firing = fire(controller, degrees, scope, fire_minors if minors else None)
    results: dict[str, Expr] = {}
    for o, output in enumerate(controller.outputs):
        results |= {f"level_{o}_{t}": firing.level(o, Const(t)) for t in range(len(output.terms))}
        results[f"strongest_{o}"] = firing.strongest[o]
    if firing.acting is not None:
        results["acting"] = firing.acting
    dice = np.random.default_rng(seed)
    raws = {i.name: dice.integers(0, 256, CASES) for i in controller.inputs}
    seen = outcome([*body, *firing.body], results, raws, firing.tables)
    for item in controller.inputs:
        define, raw = reading(item.name, "uint8", 0, 255)
        steps, found = fuzzify(item, raw, Scope({item.name}), True, False)
        slots = {str(t): found.slot(Const(t)) for t in range(found.slots)}
        given.append(np.stack(list(outcome([define, *steps], slots, {item.name: raws[item.name]}).values())))
    return seen, firing, given


SEEDS = range(50)
OF_MINORS = [seed for seed in range(900) if applies(a_controller(seed))][:20]


@pytest.mark.parametrize(
    ("seed", "minors"),
    [*((s, False) for s in SEEDS), *((s, True) for s in OF_MINORS)],
    ids=[*(f"loops-{s}" for s in SEEDS), *(f"minors-{s}" for s in OF_MINORS)],
)
def test_levels_are_those_of_every_rule(seed: int, minors: bool) -> None:
    """Levels, strongest strengths and acting are the rules' own: exactly with min and max, else within the error."""
    controller = a_controller(seed)
    seen, firing, degrees = fired(controller, seed, minors)
    one = firing.one
    infer = controller.infer
    exact = infer.and_ == "min" and infer.or_ == "max" and all(r.weight == 1 for r in controller.sentences)
    per_rule = max([firing.cell_error, *firing.sentence_errors.values()], default=F(0))
    assert (per_rule == 0) or not exact
    for case in range(CASES):
        reference = Reference(controller, [[F(int(y), DEGREE_ONE) for y in d[:, case]] for d in degrees])
        rules = len(reference.rules()) if infer.aggregate == "sum" else 1
        for o, output in enumerate(controller.outputs):
            off = abs(F(int(seen[f"strongest_{o}"][case]), one) - reference.strongest(o))
            assert off <= per_rule
            for t in range(len(output.terms)):
                off = abs(F(int(seen[f"level_{o}_{t}"][case]), one) - reference.level(o, t))
                assert off <= per_rule * rules
        if controller.behaviors and exact:
            assert int(seen["acting"][case]) == reference.acting()


def test_the_controllers_differ() -> None:
    """The random controllers above have holes, sums, weights, products, behaviors and several outputs among them."""
    made = [a_controller(seed) for seed in SEEDS]
    assert any(c.cells is not None and any(-1 in row for row in c.cells.consequents) for c in made)
    assert {c.infer.aggregate for c in made} == {"max", "sum"}
    assert {c.infer.and_ for c in made} == {"min", "product"} and {c.infer.or_ for c in made} == {"max", "probsum"}
    assert any(c.behaviors for c in made) and any(len(c.outputs) == 2 for c in made)
    assert len(OF_MINORS) == 20
