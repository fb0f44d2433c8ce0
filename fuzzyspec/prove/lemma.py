"""What is to be proved of one point of the C: integers, what is known of them, and what must hold."""

from __future__ import annotations

from dataclasses import dataclass, field

Wide = tuple[int, int]
"""The least and the greatest value."""
ANY: Wide = (-(2**31), 2**32 - 1)


@dataclass(frozen=True, slots=True)
class Num:
    """A constant."""

    value: int


@dataclass(frozen=True, slots=True)
class Var:
    """A value: a variable of the C between two assignments, or what is not looked into."""

    name: str


@dataclass(frozen=True, slots=True)
class Op:
    """An operator of C over integers of any length; ``?`` chooses, ``wrapN`` and ``signN`` cast."""

    op: str
    args: tuple[Expr, ...]


Expr = Num | Var | Op


@dataclass(frozen=True, slots=True)
class Version:
    """One value of a variable. ``definition`` holds wherever ``guard`` does."""

    name: str
    range: Wide
    definition: Expr | None
    guard: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Obligation:
    """``claim`` must hold wherever all of ``path`` do; None where the claim speaks of more than integers."""

    function: str
    kind: str
    text: str
    claim: Expr | None
    path: tuple[Expr, ...]


@dataclass
class Facts:
    """What is known of the values of one function. Mutable while it is read."""

    versions: dict[str, Version] = field(default_factory=dict)
    obligations: list[Obligation] = field(default_factory=list)


def variables(expr: Expr) -> set[str]:
    """The values that an expression speaks of."""
    match expr:
        case Num():
            return set()
        case Var(name):
            return {name}
        case Op(_, args):
            return set().union(*(variables(a) for a in args))


def around(facts: Facts, seeds: set[str], depth: int) -> tuple[set[str], set[str]]:
    """The values within ``depth`` definitions of ``seeds``, and those among them whose definition counts."""
    seen, defined, edge = set(seeds), set[str](), set(seeds)
    for _ in range(depth):
        following: set[str] = set()
        for name in edge:
            version = facts.versions[name]
            if version.definition is None:
                continue
            defined.add(name)
            following |= variables(version.definition)
            for condition in version.guard:
                following |= variables(condition)
        edge = following - seen
        seen |= edge
        if not edge:
            break
    return seen, defined
