"""Proves what the analyser could not see, from the C's own assignments and conditions, for all values at once."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzyspec.prove.exhaustion import MOST, Exhaustion
from fuzzyspec.prove.lemma import Expr, Facts, Obligation, Op, Var, Wide, around, variables
from fuzzyspec.prove.numbers import Numbers
from fuzzyspec.prove.ranges import Unbounded
from fuzzyspec.prove.words import Words

DEPTHS = (1, 2, 3, 5, 8, 64)
"""How many definitions back are looked at, one after the other."""
EFFORT = {Exhaustion: MOST, Numbers: 20_000_000, Words: 20_000}
"""What one question may cost: z3 counts its steps, bitwuzla milliseconds."""


NAMES = {Exhaustion: "every value", Numbers: "z3", Words: "bitwuzla"}


def discharged(facts: Facts, at: int) -> str | None:
    """How obligation ``at`` was proved: by which solver. None where it was not."""
    obligation = facts.obligations[at]
    if obligation.claim is None:
        return None
    earlier = [o for o in facts.obligations[:at] if o.claim is not None and o.path == obligation.path[: len(o.path)]]
    return entailed(facts, obligation.claim, obligation.path, tuple(_claim(o) for o in earlier))


def _claim(obligation: Obligation) -> Expr:
    assert obligation.claim is not None
    return obligation.claim


def entailed(facts: Facts, claim: Expr, path: tuple[Expr, ...], known: tuple[Expr, ...] = ()) -> str | None:
    """How ``claim`` was proved where all of ``path`` hold."""
    before: set[str] | None = None
    for depth in DEPTHS:
        seeds = variables(claim).union(*(variables(c) for c in path)) if path else variables(claim)
        seen, defined = around(facts, seeds, depth)
        if defined == before:
            break
        before = defined
        hypotheses = list(_hypotheses(facts, path, seen, defined, known))
        for solver in (Exhaustion, Numbers, Words):
            if _follows(solver, facts, claim, hypotheses):
                return NAMES[solver]
    return None


def _hypotheses(
    facts: Facts, path: tuple[Expr, ...], seen: set[str], defined: set[str], known: tuple[Expr, ...]
) -> Iterator[Expr]:
    yield from path
    for claim in known:
        if variables(claim) <= seen:
            yield claim
    for name in sorted(defined):
        version = facts.versions[name]
        assert version.definition is not None
        holds: Expr = Op("==", (Var(name), version.definition))
        if version.guard != path[: len(version.guard)]:
            for condition in version.guard:
                holds = Op("||", (Op("!", (condition,)), holds))
        yield holds


def _follows(
    kind: type[Exhaustion] | type[Numbers] | type[Words], facts: Facts, claim: Expr, hypotheses: list[Expr]
) -> bool:
    ranges = _Ranges(facts)
    try:
        solver = kind(ranges, EFFORT[kind])
        for hypothesis in hypotheses:
            solver.assume(hypothesis)
        solver.assume(Op("!", (claim,)))
    except Unbounded:
        return False
    return solver.impossible()


class _Ranges(dict[str, Wide]):
    """The ranges of a function's values."""

    def __init__(self, facts: Facts) -> None:
        super().__init__({name: version.range for name, version in facts.versions.items()})
