"""Who wins which cell, and what it sets there."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fuzzyspec.check.behaviors import Block
from fuzzyspec.check.claims import Claim, describe_cell
from fuzzyspec.check.rule_names import RuleNames
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Span
from fuzzyspec.model.account import Account, BehaviorAccount, RuleAccount
from fuzzyspec.model.controller import Behavior, CellRules
from fuzzyspec.syntax import tree

Bools = NDArray[np.bool_]
Ints = NDArray[np.int32]


@dataclass(frozen=True)
class Cells:
    """The space after priorities, as arrays over flat cells.

    ``claimed`` (cells,); ``consequents`` and ``sources`` (outputs, cells): the term that is set and the claim that
    sets it, -1 where unset. ``rules`` and ``account`` are the same as the model keeps it.
    """

    claimed: Bools
    consequents: Ints
    sources: Ints
    rules: CellRules
    account: Account


@dataclass(frozen=True, slots=True)
class Ranking:
    """``behaviors`` by code; ``codes[i]`` is the code of the i-th block, ``table`` that of the tables (0 without
    behaviors).
    """

    behaviors: tuple[Behavior, ...]
    codes: tuple[int, ...]
    table: int


def rank(blocks: tuple[Block, ...], tables: tuple[tree.Table, ...]) -> Ranking:
    """Codes from the highest priority downwards, written order among equals; the tables last, named beside behaviors
    only.
    """
    order = sorted(range(len(blocks)), key=lambda i: -(blocks[i].priority or 0))
    behaviors = [Behavior(blocks[i].name, code, blocks[i].priority, blocks[i].span) for code, i in enumerate(order, 1)]
    codes = tuple(order.index(i) + 1 for i in range(len(blocks)))
    if behaviors and tables:
        header = tables[0].outputs[0].span.to(tables[0].inputs[-1].span)
        behaviors.append(Behavior("table", len(behaviors) + 1, None, header))
    return Ranking(tuple(behaviors), codes, len(behaviors) if tables else 0)


def resolve_cells(claims: tuple[Claim, ...], ranking: Ranking, names: RuleNames) -> Cells:
    """Give every cell to the highest priority that claims it.

    Reports equal priorities that meet, rules of one winner that disagree, tables that meet, rules that never win and
    rules that say nothing new.
    """
    behaviors = ranking.behaviors
    shape = tuple(len(v.terms) for v in names.inputs)
    # Rank 1 is the highest priority; where there are no behaviors, the tables alone are rank 1.
    ranks = [max(1, ranking.table) if c.owner is None else ranking.codes[c.owner] for c in claims]
    started = {rank: np.zeros(shape, dtype=np.bool_) for rank in range(1, max(1, len(behaviors)) + 1)}
    regions = [np.ix_(*claim.box) for claim in claims]
    for rank, region in zip(ranks, regions, strict=True):
        started[rank][region] = True
    winner = np.zeros(shape, dtype=np.int32)
    for rank in sorted(started, reverse=True):
        winner[started[rank]] = rank

    _report_meeting(started, winner, behaviors, names)
    consequents = np.full((len(names.outputs), *shape), -1, dtype=np.int32)
    sources = np.full((len(names.outputs), *shape), -1, dtype=np.int32)
    executed = [0] * len(claims)
    disagreeing: set[tuple[int, int]] = set()
    for index, (claim, rank, region) in enumerate(zip(claims, ranks, regions, strict=True)):
        won = winner[region] == rank
        executed[index] = int(won.sum())
        earlier: Counter[int] = Counter()
        news = False
        for output, term in claim.sets:
            set_so_far = consequents[output][region]
            source = sources[output][region]
            taken = won & (set_so_far != -1)
            clash = taken & ((set_so_far != term) | _other_table(claim, source, claims))
            if clash.any():
                _report_clash(claims, index, output, source, clash, disagreeing, names)
            fresh = won & (set_so_far == -1)
            news = news or bool(fresh.any()) or bool(clash.any())
            earlier.update(source[taken].tolist())
            consequents[output][region] = np.where(fresh, term, set_so_far)
            sources[output][region] = np.where(fresh, index, source)
        if claim.sets and executed[index] and not news:
            _report_nothing_new(claims, index, earlier, names)
    _report_dead(claims, ranks, executed, regions, started, winner, behaviors, names)

    flat = winner.reshape(-1)
    code = {rank: (rank if behaviors else 0) for rank in started}
    outputs = range(len(names.outputs))
    flat_consequents = consequents.reshape(len(outputs), flat.size)
    flat_sources = sources.reshape(len(outputs), flat.size)
    rules = CellRules(
        shape,
        tuple(tuple(flat_consequents[o].tolist()) for o in outputs),
        tuple(flat.tolist()) if behaviors else (0,) * flat.size,
    )
    account = Account(
        cells=flat.size,
        claimed=int((flat != 0).sum()),
        rules=tuple(
            RuleAccount(code[rank], _size(claim), count, claim.span)
            for claim, rank, count in zip(claims, ranks, executed, strict=True)
        ),
        behaviors=tuple(_behavior_account(b, started[b.code], winner) for b in behaviors),
        sources=tuple(tuple(flat_sources[o].tolist()) for o in outputs),
    )
    return Cells(flat != 0, flat_consequents, flat_sources, rules, account)


def _size(claim: Claim) -> int:
    size = 1
    for terms in claim.box:
        size *= len(terms)
    return size


def _behavior_account(behavior: Behavior, started: Bools, winner: Ints) -> BehaviorAccount:
    winners = winner[started]
    lost = tuple((code, int((winners == code).sum())) for code in range(1, behavior.code))
    return BehaviorAccount(
        behavior.code,
        int(started.sum()),
        int((winners == behavior.code).sum()),
        tuple((code, count) for code, count in lost if count),
    )


def _other_table(claim: Claim, source: Ints, claims: tuple[Claim, ...]) -> Bools:
    """Where an entry of another table has already set the output: an error even if both agree."""
    if claim.table is None:
        return np.zeros(source.shape, dtype=np.bool_)
    present = np.unique(source[source >= 0])
    others = [int(i) for i in present if claims[int(i)].table != claim.table]
    return np.isin(source, others)


def _cell_at(region: tuple[NDArray[np.intp], ...], index: tuple[int, ...]) -> tuple[int, ...]:
    """The cell that one element of a claim's region stands for."""
    return tuple(int(axis.reshape(-1)[k]) for axis, k in zip(region, index, strict=True))


def _first(mask: Bools) -> tuple[int, ...]:
    return tuple(int(k) for k in np.unravel_index(int(np.argmax(mask)), mask.shape))


def _report_meeting(started: dict[int, Bools], winner: Ints, behaviors: tuple[Behavior, ...], names: RuleNames) -> None:
    for code, behavior in enumerate(behaviors, start=1):
        first = _first_of_priority(behavior, behaviors)
        if behavior.priority is None or first == code:
            continue
        # Where a higher priority takes the cell, it does not matter that these two meet.
        own = started[code] & (winner >= first)
        for other_code in range(first, code):
            other = behaviors[other_code - 1]
            met = started[other_code] & own
            if met.any():
                cell = describe_cell(_first(met), names.inputs)
                names.tell(
                    Diagnostic(
                        "FZ304",
                        f"behaviors `{other.name}` and `{behavior.name}` have one priority and meet in "
                        f"{_cells(int(met.sum()))}",
                        max(behavior.span, other.span),
                        label=f"priority {behavior.priority}",
                        labels=(Label(min(behavior.span, other.span), f"priority {behavior.priority} too"),),
                        help="give one of them the higher priority",
                        notes=(f"both claim: {cell}",),
                    )
                )


def _first_of_priority(behavior: Behavior, behaviors: tuple[Behavior, ...]) -> int:
    return min(b.code for b in behaviors if b.priority == behavior.priority)


def _report_clash(
    claims: tuple[Claim, ...],
    index: int,
    output: int,
    source: Ints,
    clash: Bools,
    disagreeing: set[tuple[int, int]],
    names: RuleNames,
) -> None:
    """One report for each pair of rules, at the first cell where they clash."""
    claim = claims[index]
    place = _first(clash)
    other_index = int(source[place])
    if (other_index, index) in disagreeing:
        return
    disagreeing.add((other_index, index))
    other = claims[other_index]
    cell = describe_cell(_cell_at(np.ix_(*claim.box), place), names.inputs)
    variable = names.outputs[output]
    said = variable.terms[dict(claim.sets)[output]].name
    before = variable.terms[dict(other.sets)[output]].name
    if claim.table is not None:
        names.tell(
            Diagnostic(
                "FZ305",
                f"two tables set output `{variable.name}` in one cell",
                claim.span,
                label=f"sets {variable.name} to {said}",
                labels=(Label(other.span, f"sets {variable.name} to {before}"),),
                help="let every cell of an output stand in one table",
                notes=(f"the cell: {cell}",),
            )
        )
        return
    names.tell(
        Diagnostic(
            "FZ303",
            f"two rules disagree on output `{variable.name}`",
            claim.span,
            label=f"says {variable.name} is {said}",
            labels=(Label(other.span, f"says {variable.name} is {before}"),),
            help="narrow one of the rules, or move it to a behavior of higher priority",
            notes=(f"both hold in the cell: {cell}",),
        )
    )


def _report_nothing_new(claims: tuple[Claim, ...], index: int, earlier: Counter[int], names: RuleNames) -> None:
    other = claims[min(earlier)]
    same = len(earlier) == 1 and other.box == claims[index].box
    names.tell(
        Diagnostic(
            "FZ307",
            "this rule is written twice" if same else "this rule says nothing new",
            claims[index].span,
            label="again here" if same else "already said in every cell that it wins",
            labels=(
                Label(other.span, "first here" if same else "said here" + (" and later" if len(earlier) > 1 else "")),
            ),
            help="remove it",
            severity="warning",
        )
    )


def _report_dead(
    claims: tuple[Claim, ...],
    ranks: list[int],
    executed: list[int],
    regions: list[tuple[NDArray[np.intp], ...]],
    started: dict[int, Bools],
    winner: Ints,
    behaviors: tuple[Behavior, ...],
    names: RuleNames,
) -> None:
    """Warn of rules that never win; of a behavior or of the tables as a whole where all of theirs never do."""
    for behavior in behaviors:
        own = [i for i, rank in enumerate(ranks) if rank == behavior.code]
        if not own:
            continue
        dead = [i for i in own if not executed[i]]
        if len(dead) == len(own):
            takers = Counter(winner[started[behavior.code]].tolist())
            what = "the table" if behavior.priority is None else f"behavior `{behavior.name}`"
            _warn_dead(f"{what} never wins a cell", behavior.span, behavior, takers, behaviors, names)
        elif behavior.priority is not None:
            # A table below behaviors is there to fill what they leave: its lost entries are no news.
            for i in dead:
                takers = Counter(winner[regions[i]].reshape(-1).tolist())
                _warn_dead("this rule never wins a cell", claims[i].span, behavior, takers, behaviors, names)


def _warn_dead(
    message: str, span: Span, own: Behavior, takers: Counter[int], behaviors: tuple[Behavior, ...], names: RuleNames
) -> None:
    beaten = [(behaviors[code - 1], count) for code, count in sorted(takers.items())]
    if any(b.priority == own.priority for b, _ in beaten):
        return  # they meet with one priority, which is reported as such
    names.tell(
        Diagnostic(
            "FZ306",
            message,
            span,
            label="lost to " + ", ".join(f"{b.name} ({_cells(count)})" for b, count in beaten),
            labels=tuple(Label(b.span, f"priority {b.priority}") for b, _ in beaten if b.priority is not None),
            help="remove it, or give its behavior a higher priority",
            severity="warning",
        )
    )


def _cells(count: int) -> str:
    return f"{count} cell" if count == 1 else f"{count} cells"
