"""Who wins which cell, against an oracle that walks the cells one by one."""

from __future__ import annotations

import itertools
from collections import Counter

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.check_rules.specs import EXAMPLES, from_file, from_text

TERMS = ("S", "M", "B")


# --- the oracle: plain dictionaries over the generator's own data ------------------------------


def claims_on(cell, rules):
    """The rules whose sets of terms hold a cell."""
    return [rule for rule in rules if all(term in asked for term, asked in zip(cell, rule["box"], strict=True))]


def oracle(case):
    """Codes of the errors to expect and, by cell, the winner and what it sets."""
    errors = set()
    won = {}
    for cell in itertools.product(*(TERMS[:n] for n in case["inputs"])):
        claimants = [(b["priority"], b["name"]) for b in case["behaviors"] if claims_on(cell, b["rules"])]
        entries = claims_on(cell, case["table"])
        if not claimants and not entries:
            won[cell] = (None, {})
        elif not claimants:
            won[cell] = ("table" if case["behaviors"] else None, dict(entries[0]["sets"]))
        else:
            top = max(priority for priority, _ in claimants)
            names = [name for priority, name in claimants if priority == top]
            if len(names) > 1:
                errors.add("FZ304")
            # With one priority the earlier block is taken, so that the rest can be looked at.
            (winner,) = [b for b in case["behaviors"] if b["name"] == names[0]]
            said = {}
            for rule in claims_on(cell, winner["rules"]):
                for output, term in rule["sets"].items():
                    if said.setdefault(output, term) != term:
                        errors.add("FZ303")
            won[cell] = (winner["name"], said)
    for output, fallback in enumerate(case["fallbacks"]):
        unset = [cell for cell, (_, sets) in won.items() if output not in sets]
        if len(unset) == len(won):
            # Never set at all: told once, instead of cell by cell.
            errors.add("FZ323")
        elif not fallback:
            errors |= {"FZ302" if any(claims_on(cell, r) for r in everything(case)) else "FZ301" for cell in unset}
    return errors, won


def everything(case):
    """The rules of each behavior, and those of the table."""
    return [*(b["rules"] for b in case["behaviors"]), case["table"]]


# --- random cases ------------------------------------------------------------------------------


@st.composite
def cases(draw):
    """One to three inputs, one or two outputs, up to three behaviors, perhaps a table below."""
    inputs = draw(st.lists(st.integers(2, 3), min_size=1, max_size=3))
    outputs = draw(st.integers(1, 2))

    def a_rule():
        box = [tuple(sorted(draw(st.sets(st.sampled_from(TERMS[:n]), min_size=1)))) for n in inputs]
        sets = {o: draw(st.sampled_from(TERMS)) for o in range(outputs) if o == 0 or draw(st.integers(0, 3))}
        return {"box": box, "sets": sets}

    behaviors = [
        {
            "name": f"B{k}",
            "priority": draw(st.integers(1, 3)),
            "rules": [a_rule() for _ in range(draw(st.integers(1, 4)))],
        }
        for k in range(draw(st.integers(0, 3)))
    ]
    table = []
    if not behaviors or draw(st.booleans()):
        skipped = draw(st.sets(st.sampled_from(TERMS[: inputs[0]]), max_size=1 if behaviors else 0))
        for term in TERMS[: inputs[0]]:
            if term not in skipped:
                box = [(term,), *(TERMS[:n] for n in inputs[1:])]
                table.append({"box": box, "sets": {o: draw(st.sampled_from(TERMS)) for o in range(outputs)}})
    fallbacks = [draw(st.booleans()) for _ in range(outputs)]
    return {"inputs": inputs, "behaviors": behaviors, "table": table, "fallbacks": fallbacks}


def as_text(case):
    """The case as a spec."""
    lines = ["controller c {"]
    for i, n in enumerate(case["inputs"]):
        lines.append(f"    input x{i} in [0, 1] {{ partition {' '.join(TERMS[:n])} }}")
    for o, fallback in enumerate(case["fallbacks"]):
        lines.append(f"    output y{o} in [0, 1] {{ partition S M B {'otherwise 0' if fallback else ''} }}")
    for b in case["behaviors"]:
        lines.append(f"    behavior {b['name']} priority {b['priority']} {{")
        for rule in b["rules"]:
            asked = " and ".join(f"x{i} in {{{', '.join(terms)}}}" for i, terms in enumerate(rule["box"]))
            said = ", ".join(f"y{o} is {term}" for o, term in rule["sets"].items())
            lines.append(f"        if {asked} then {said}")
        lines.append("    }")
    if case["table"]:
        outputs = ", ".join(f"y{o}" for o in range(len(case["fallbacks"])))
        lines.append(f"    table {outputs} by x0 {{")
        for entry in case["table"]:
            lines.append(f"        {entry['box'][0][0]}: {'/'.join(entry['sets'].values())}")
        lines.append("    }")
    return "\n".join([*lines, "}"])


@settings(max_examples=150)
@given(cases())
def test_resolution_is_the_oracles(case):
    """Errors, owners, consequents and accounts are what a walk over the cells by the definitions gives."""
    errors, won = oracle(case)
    model, found = from_text(as_text(case))
    assert {d.code for d in found if d.severity == "error"} == errors
    if model is None:
        assert errors
        return
    (controller,) = model.controllers
    codes = {None: 0} | {b.name: b.code for b in controller.behaviors}
    for flat, (owner, sets) in enumerate(won.values()):
        assert controller.cells.owner[flat] == codes[owner]
        for o, output in enumerate(controller.outputs):
            term = controller.cells.consequents[o][flat]
            assert (None if term < 0 else output.terms[term].name) == sets.get(o)
    assert_account(case, won, controller)


def assert_account(case, won, controller):
    """Started, executed and lost by behavior, counted again."""
    names = {b.code: b.name for b in controller.behaviors}
    rules = {b["name"]: b["rules"] for b in case["behaviors"]} | {"table": case["table"]}
    for counted in controller.account.behaviors:
        name = names[counted.code]
        started = [cell for cell in won if claims_on(cell, rules[name])]
        owners = Counter(won[cell][0] for cell in started)
        assert counted.started == len(started)
        assert counted.executed == owners.pop(name, 0)
        assert {names[code]: count for code, count in counted.lost} == owners
    claimed = [cell for cell in won if any(claims_on(cell, r) for r in everything(case))]
    assert controller.account.claimed == len(claimed)


@settings(max_examples=60)
@given(cases())
def test_unclaimed_points_are_unclaimed(case):
    """The input that a report of unclaimed cells shows lies at the peaks of a cell in which the output is unset."""
    _, won = oracle(case)
    peaks = {2: {"0": "S", "1": "M"}, 3: {"0": "S", "0.5": "M", "1": "B"}}
    for diagnostic in from_text(as_text(case))[1]:
        if diagnostic.code in ("FZ301", "FZ302"):
            shown = [diagnostic.point[f"x{i}"] for i in range(len(case["inputs"]))]
            cell = tuple(peaks[n][value] for n, value in zip(case["inputs"], shown, strict=True))
            open_outputs = {o for o, fallback in enumerate(case["fallbacks"]) if not fallback}
            assert open_outputs - set(won[cell][1])


# --- by hand -----------------------------------------------------------------------------------


def test_accounts_of_the_papers_behaviors():
    """FO, AO and MG of nav.fz start 54, 48 and 27 cells and share 81 of them as 54, 16 and 11."""
    model, found, _ = from_file(EXAMPLES / "nav.fz")
    assert found == ()
    velocity = next(c for c in model.controllers if c.name == "velocity")
    assert [b.name for b in velocity.behaviors] == ["FO", "AO", "MG"]
    assert [(b.started, b.executed, b.lost) for b in velocity.account.behaviors] == [
        (54, 54, ()),
        (48, 16, ((1, 32),)),
        (27, 11, ((1, 12), (2, 4))),
    ]
    assert (velocity.account.cells, velocity.account.claimed) == (81, 81)
    assert velocity.always_fires == (True, True)


def test_negation_inside_a_behavior_is_the_other_terms():
    """`x is not S` claims the cells of all other terms, and `not x is not S` those of S."""
    model, found = from_text(
        "controller c { input x in [0, 1] { partition S M B } output y in [0, 1] { partition S M B }\n"
        "behavior A priority 1 { if x is not S then y is B  if not (x is not S) then y is S } }"
    )
    assert found == ()
    assert model.controllers[0].cells.consequents == ((0, 2, 2),)


def test_repeated_input_narrows():
    """Two conditions on one input leave the terms that both name."""
    model, found = from_text(
        "controller c { input x in [0, 1] { partition S M B } output y in [0, 1] { partition S M B otherwise 0 }\n"
        "behavior A priority 1 { if x in {S, M} and x in {M, B} then y is B } }"
    )
    assert found == ()
    assert model.controllers[0].cells.consequents == ((-1, 2, -1),)


def test_cells_are_row_major_with_the_last_input_fastest():
    """A table by other than the declared order puts its entries where the declared order says."""
    model, _ = from_text(
        "controller c { input a in [0, 1] { partition S B } input b in [0, 1] { partition S M B }\n"
        "output y in [0, 1] { partition S M B }\n"
        "table y by b, a {  S B\n S: S M\n M: B S\n B: M B } }"
    )
    cells = model.controllers[0].cells
    assert cells.shape == (2, 3)
    assert cells.consequents == ((0, 2, 1, 1, 0, 2),)


def test_weights_are_kept_exactly():
    """A weight of 2/3 is the rational."""
    model, _ = from_text(
        "controller c { input a in [0, 1] { partition S B } output y in [0, 1] { partition S B otherwise 0 }\n"
        "rules { if a is S then y is S with 2/3 } }"
    )
    weight = model.controllers[0].sentences[0].weight
    assert (weight.numerator, weight.denominator) == (2, 3)


@pytest.mark.parametrize("terms", [4, 16])
def test_large_tables_resolve_completely(terms):
    """Four inputs of 16 terms are 65,536 cells, all of which a behavior can claim and share."""
    names = " ".join(f"T{k}" for k in range(terms))
    model, found = from_text(
        f"controller c {{ input a, b, c, d in [0, 1] {{ partition {names} }} output y in [0, 1] {{ partition S B }}\n"
        "behavior A priority 2 { if a is T0 then y is S }\n"
        "behavior B priority 1 { if d is not T0 then y is B  if d is T0 then y is S } }"
    )
    assert found == ()
    first, second = model.controllers[0].account.behaviors
    assert (first.started, first.executed) == (terms**3, terms**3)
    assert (second.started, second.executed, second.lost) == (terms**4, terms**4 - terms**3, ((1, terms**3),))
