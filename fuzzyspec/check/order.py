"""What depends on what among a system's params and lets: cycles, found before anything is evaluated."""

from __future__ import annotations

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
            case tree.SystemInput() | tree.ListInput() | tree.SystemOutput():
                pass
            case _:
                assert_never(item)
    return found


def report_cycles(items: tuple[tree.SystemItem, ...], report: Report) -> frozenset[Key]:
    """Report each cycle once; the names that stand on one."""
    defined = definitions(items)
    reads = {key: [r for r in references(value, loop) if r in defined] for key, (_, value, loop) in defined.items()}
    on_cycle: set[Key] = set()
    for start in defined:
        if start in on_cycle:
            continue
        cycle = _cycle_from(start, reads)
        if cycle is None or on_cycle & set(cycle):
            on_cycle.update(cycle or ())
            continue
        on_cycle.update(cycle)
        labels = tuple(Label(defined[k][0], f"which needs `{_text(k)}`") for k in (*cycle[1:], start)[:-1])
        way = " needs ".join(f"`{_text(k)}`" for k in (*cycle, start))
        report(
            Diagnostic(
                "FZ240",
                f"`{_text(start)}` is defined by itself" if len(cycle) == 1 else f"definitions go in a circle: {way}",
                defined[start][0],
                label="cannot be computed",
                labels=labels if len(cycle) > 1 else (),
                help="a step computes forward; to remember a value, let an output `hold`",
            )
        )
    return frozenset(on_cycle)


def _cycle_from(start: Key, reads: Mapping[Key, list[Key]]) -> list[Key] | None:
    """A shortest way from ``start`` back to itself."""
    ways: list[list[Key]] = [[start]]
    seen: set[Key] = set()
    while ways:
        way = ways.pop(0)
        for after in reads[way[-1]]:
            if after == start:
                return way
            if after not in seen:
                seen.add(after)
                ways.append([*way, after])
    return None


def _text(key: Key) -> str:
    return key[1] if key[0] is None else f"{key[0]}.{key[1]}"
