"""What depends on what among a system's params and lets: cycles, found before anything is evaluated."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from typing import assert_never

from fuzzyspec.check.findings import Report
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Span
from fuzzyspec.syntax import tree

Key = tuple[str | None, str]
"""A name: the list whose elements it belongs to (None outside of loops), and itself."""


def references(expr: tree.Expr, items: Mapping[str, str]) -> Iterator[Key]:
    """Every name that an expression reads; ``items`` are the loop variables in scope with their lists."""
    match expr:
        case tree.Number():
            pass
        case tree.Ref(parts=parts):
            if len(parts) > 1 and parts[0].text in items:
                yield items[parts[0].text], parts[1].text
            elif parts:
                yield None, parts[0].text
        case tree.Unary(operand=operand):
            yield from references(operand, items)
        case tree.Binary(left=left, right=right):
            yield from references(left, items)
            yield from references(right, items)
        case tree.Compare(operands=operands) | tree.Logic(operands=operands):
            for o in operands:
                yield from references(o, items)
        case tree.InRange(value=value, lo=lo, hi=hi):
            for o in (value, lo, hi):
                yield from references(o, items)
        case tree.Conditional(test=test, then=then, other=other):
            for o in (test, then, other):
                yield from references(o, items)
        case tree.Otherwise(value=value, fallback=fallback):
            yield from references(value, items)
            yield from references(fallback, items)
        case tree.Call(arguments=arguments):
            for a in arguments:
                yield from references(a.value, items)
        case tree.Fold():
            inner = {**items, expr.item.text: expr.over.text}
            for part in (expr.body, expr.test):
                if part is not None:
                    yield from references(part, inner)
            if expr.fallback is not None:
                yield from references(expr.fallback, items)
        case _:
            assert_never(expr)


def definitions(items: tuple[tree.SystemItem, ...]) -> dict[Key, tuple[Span, tree.Expr, dict[str, str]]]:
    """Every param and let (the first of a name): its name's span, its expression, the loop variables around it."""
    found: dict[Key, tuple[Span, tree.Expr, dict[str, str]]] = {}
    for item in items:
        match item:
            case tree.Param(name=name, value=value):
                found.setdefault((None, name.text), (name.span, value, {}))
            case tree.Let(target=target, value=value):
                if len(target.parts) == 1:
                    found.setdefault((None, target.parts[0].text), (target.span, value, {}))
            case tree.ForEach(item=loop, over=over, body=body):
                for let in body:
                    if len(let.target.parts) == 2:
                        key = over.text, let.target.parts[1].text
                        found.setdefault(key, (let.target.span, let.value, {loop.text: over.text}))
            case tree.SystemInput() | tree.ListInput() | tree.SystemOutput() | tree.BudgetBlock():
                pass
            case _:
                assert_never(item)
    return found


def report_cycles(items: tuple[tree.SystemItem, ...], report: Report) -> frozenset[Key]:
    """Report one cycle of each knot of definitions; every name that is part of a knot."""
    defined = definitions(items)
    reads = {key: [r for r in references(value, loop) if r in defined] for key, (_, value, loop) in defined.items()}
    knots = _knots(reads)
    for knot in knots:
        cycle = _shortest_cycle(next(key for key in defined if key in knot), knot, reads)
        needed = [*cycle[1:], cycle[0]]
        way = " needs ".join(
            f"`{_text(k)}`" for k in (cycle[0], *(needed if len(cycle) <= _SHOWN else needed[:_SHOWN]))
        )
        more = "" if len(cycle) <= _SHOWN else f" and so on, over {len(cycle)} definitions"
        alone = len(cycle) == 1
        report(
            Diagnostic(
                "FZ240",
                f"`{_text(cycle[0])}` is defined by itself" if alone else f"definitions go in a circle: {way}{more}",
                defined[cycle[0]][0],
                label="cannot be computed" if alone else f"needs `{_text(needed[0])}`",
                labels=tuple(
                    Label(defined[at][0], f"which needs `{_text(after)}`")
                    for at, after in list(zip(cycle, needed, strict=True))[1:_SHOWN]
                ),
                help="a step computes forward; to remember a value, let an output `hold`",
            )
        )
    return frozenset().union(*knots)


_SHOWN = 6
"""Definitions of one cycle that are spelt out."""


def _knots(reads: Mapping[Key, list[Key]]) -> list[set[Key]]:
    """Sets of definitions that all need each other, or one that needs itself, by position (Kosaraju, no recursion)."""
    needed_by: dict[Key, list[Key]] = {key: [] for key in reads}
    for key, needs in reads.items():
        for other in needs:
            needed_by[other].append(key)
    finished = list(_postorder(list(reads), reads, set()))
    seen: set[Key] = set()
    found = [set(_postorder([key], needed_by, seen)) for key in reversed(finished) if key not in seen]
    place = {key: i for i, key in enumerate(reads)}
    tied = [knot for knot in found if len(knot) > 1 or any(key in reads[key] for key in knot)]
    return sorted(tied, key=lambda knot: min(place[key] for key in knot))


def _postorder(starts: list[Key], after: Mapping[Key, list[Key]], seen: set[Key]) -> Iterator[Key]:
    """Depth first from each start that was not seen, those that lie behind a key before it."""
    for start in starts:
        if start in seen:
            continue
        seen.add(start)
        way = [(start, iter(after[start]))]
        while way:
            _, ahead = way[-1]
            found = next((k for k in ahead if k not in seen), None)
            if found is None:
                yield way.pop()[0]
            else:
                seen.add(found)
                way.append((found, iter(after[found])))


def _shortest_cycle(start: Key, knot: set[Key], reads: Mapping[Key, list[Key]]) -> list[Key]:
    """A shortest way from ``start`` back to itself within its knot, ``start`` first."""
    came_from: dict[Key, Key] = {}
    front = deque([start])
    while start not in came_from:
        key = front.popleft()
        for after in reads[key]:
            if after in knot and after not in came_from:
                came_from[after] = key
                front.append(after)
    way = [came_from[start]]
    while way[-1] != start:
        way.append(came_from[way[-1]])
    return way[::-1]


def _text(key: Key) -> str:
    return key[1] if key[0] is None else f"{key[0]}.{key[1]}"
