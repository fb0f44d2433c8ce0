"""Files far larger than specs are: what they cost, and how much is said of them."""

from __future__ import annotations

import time

import pytest

from fuzzyspec.check import check, findings, sizes
from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.diagnostics.render import render
from fuzzyspec.syntax import limits, parse
from tests.breaking.slips_rules import BEH, RULES
from tests.breaking.slips_systems import SYS
from tests.breaking.slips_tables import FAN

SIZE = 60_000


def repeated(base: str, at: str, line: str) -> str:
    """A spec with a line put in before ``at`` until it has its size; ``#`` in the line is a running number."""
    count = SIZE // len(line)
    return base.replace(at, "".join(line.replace("#", str(i)) for i in range(count)) + at, 1)


LARGE = {
    "rules about nothing": repeated(RULES, "        if error is Z", "        if error is Q# then duty is OFF\n"),
    "rules alike": repeated(RULES, "        if error is Z", "        if error is N then duty is OFF\n"),
    "rows alike": repeated(FAN, "        Z:", "        Z: OFF HALF HALF\n"),
    "a row without end": FAN.replace("Z:", "Z: " + "OFF " * (SIZE // 4)),
    "a header without end": FAN.replace("DOWN FLAT UP\n", "DOWN FLAT UP " * (SIZE // 13) + "\n"),
    "terms without end": FAN.replace("N Z P", " ".join(f"T{i}" for i in range(SIZE // 6))),
    "inputs without end": FAN.replace("error in", ", ".join(f"i{i}" for i in range(SIZE // 7)) + " in"),
    "arguments without end": SYS.replace("gap: x", ", ".join(f"g{i}: x" for i in range(SIZE // 9))),
    "names of nothing": SYS.replace("y = worst", "y = max(" + ", ".join(f"n{i}" for i in range(SIZE // 7)) + ")"),
    "params of nothing": repeated(SYS, "    output y", "    param p# = q#\n"),
    "lets in the wrong order": repeated(SYS, "    output y", "    let a# = b# + x\n    let b# = x\n"),
    "lets in a circle": repeated(SYS, "    output y", "    let a# = b# + x\n    let b# = a# - x\n"),
    "behaviors": repeated(BEH, "    behavior GO", "    behavior B# priority 2 { if left is B then v is Z }\n"),
    "numbers of other kinds": repeated(SYS, "    output y", "    param p# = 1e3\n"),
    "closing braces": FAN + "}\n" * (SIZE // 2),
    "quotation marks": '"' * SIZE,
    "one long word": "module " + "m" * SIZE,
    "controllers": "module m\n" + "controller c { }\n" * (SIZE // 17),
}  # fmt: skip


@pytest.mark.parametrize("text", LARGE.values(), ids=LARGE.keys())
def test_a_large_file_is_answered_soon_and_briefly(text: str) -> None:
    """Much of the same gives an answer within seconds, no longer than the file, and a model in no case."""
    source = Source("large.fz", text)
    begin = time.process_time()
    tree, torn = parse(source)
    model, found = check(tree, source, torn)
    told = (*torn, *found)
    shown = render(told, source)
    assert time.process_time() - begin < 10
    assert model is None
    assert len(told) <= 2 * findings.MOST
    assert len(shown) < 1_000 * len(told)


def test_the_longest_circle_is_not_spelt_out() -> None:
    """A cycle over thousands of definitions is one diagnostic that names a few of them."""
    count = 3_000
    lets = "".join(f"    let a{i} = a{(i + 1) % count} + x\n" for i in range(count))
    source = Source("circle.fz", f"module m\nsystem s {{\n    input x in [0, 1]\n{lets}    output y = a0\n}}\n")
    tree, torn = parse(source)
    _, (cycle,) = check(tree, source, torn)
    assert cycle.code == "FZ240"
    assert f"over {count} definitions" in cycle.message
    assert len(cycle.message) < 200 and len(cycle.labels) < 10


def test_a_controller_at_its_limit_is_looked_into() -> None:
    """As many sentence rules as a controller holds are checked; of one more it is told, and nothing else."""

    def rules(count: int) -> str:
        terms = " ".join(f"T{i}" for i in range(40))
        lines = "".join(f"        if x is T{i % 40} then y is A\n" for i in range(count))
        return (
            f"module m\ncontroller c {{\n    input x in [0, 1] {{ partition {terms} }}\n"
            f"    output y in [0, 1] {{ partition A B }}\n    rules {{\n{lines}    }}\n}}\n"
        )

    for count, code in ((sizes.MOST_SENTENCES, "FZ307"), (sizes.MOST_SENTENCES + 1, "FZ330")):
        source = Source("limit.fz", rules(count))
        tree, torn = parse(source)
        _, found = check(tree, source, torn)
        assert not torn and {d.code for d in found} == {code}


def test_a_file_beyond_the_limit_is_not_read() -> None:
    """Ten megabytes cost nothing but a look at their length."""
    text = FAN + "# " + "x" * 10_000_000
    begin = time.process_time()
    tree, (found,) = parse(Source("huge.fz", text))
    assert found.code == "FZ120" and f"{limits.MAX_CHARACTERS}" in f"{found.help}"
    assert tree.items == () and time.process_time() - begin < 1
