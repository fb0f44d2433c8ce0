"""How much one controller may hold: far more than a microcontroller would run, and few enough to check quickly."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Span
from fuzzyspec.syntax import tree

MOST_VARIABLES = 32
MOST_TERMS = 255
MOST_POINTS = 255
MOST_BEHAVIORS = 64
MOST_SENTENCES = 1_000
MOST_CELL_RULES = 4_096


def oversized(decl: tree.ControllerDecl) -> list[Diagnostic]:
    """What a controller has too many of, each pointed at where the limit is passed."""
    variables = [i for i in decl.items if isinstance(i, tree.VariableDecl)]
    behaviors = [i for i in decl.items if isinstance(i, tree.BehaviorDecl)]
    sentences = [r.span for i in decl.items if isinstance(i, tree.RulesBlock) for r in i.rules]
    owner = f"controller `{decl.name.text}`"
    counted = [
        _Counted(owner, "inputs", [n.span for v in variables if v.kind == "input" for n in v.names], MOST_VARIABLES),
        _Counted(owner, "outputs", [n.span for v in variables if v.kind == "output" for n in v.names], MOST_VARIABLES),
        *(count for v in variables for count in _of_terms(v)),
        _Counted(owner, "behaviors", [b.name.span for b in behaviors], MOST_BEHAVIORS),
        _Counted(owner, "rules in behaviors", [r.span for b in behaviors for r in b.rules], MOST_CELL_RULES),
        _Counted(owner, "sentence rules", sentences, MOST_SENTENCES),
    ]
    return [_too_many(count) for count in counted if len(count.spans) > count.most]


@dataclass(frozen=True, slots=True)
class _Counted:
    """Things that ``owner`` has, by where they stand, and how many it may have."""

    owner: str
    what: str
    spans: list[Span]
    most: int


def _of_terms(variable: tree.VariableDecl) -> Iterator[_Counted]:
    terms: list[Span] = []
    for member in variable.members:
        match member:
            case tree.Partition(placed) | tree.Singletons(placed):
                terms += [t.name.span for t in placed]
            case tree.TermDecl(name, shape, arguments):
                terms.append(name.span)
                if shape.text == "points":
                    yield _Counted(f"term `{name.text}`", "points", [a.span for a in arguments[::2]], MOST_POINTS)
            case tree.OtherwiseClause():
                pass
    yield _Counted(f"{variable.kind} `{variable.names[0].text}`", "terms", terms, MOST_TERMS)


def _too_many(count: _Counted) -> Diagnostic:
    return Diagnostic(
        "FZ330",
        f"{count.owner} has {len(count.spans):,} {count.what}",
        count.spans[count.most],
        label=f"{count.most:,} are the most",
        help="write it in fewer, or split the controller in layers",
    )
