"""Writes ``table.json``, the LALR(1) table of ``grammar/fuzzy.lark``: ``python -m fuzzyspec.syntax.generate``.

Lark builds the table, in strict mode, so that a conflict stops us here. The parser reads the file instead of asking
lark each time: that takes milliseconds where lark takes a third of a second. A test holds the file to the grammar.
States are renumbered in breadth-first order, so that the same grammar gives the same bytes.
"""

from __future__ import annotations

import json
from collections import deque
from pathlib import Path
from typing import Any

from fuzzyspec.resources import read_text


def table_text() -> str:
    """The table as JSON text; raises lark's ``GrammarError`` where the grammar has a conflict."""
    from lark import Lark
    from lark.lexer import PatternStr
    from lark.parsers.lalr_analysis import Shift

    lark = Lark(read_text("grammar", "fuzzy.lark"), parser="lalr", strict=True, maybe_placeholders=False)
    parse_table: Any = lark.parse_interactive("").parser_state.parse_conf.parse_table
    actions: dict[Any, dict[str, Any]] = parse_table.states

    order: dict[Any, int] = {}
    queue = deque([parse_table.start_states["start"]])
    while queue:
        state = queue.popleft()
        if state in order:
            continue
        order[state] = len(order)
        queue.extend(actions[state][s][1] for s in sorted(actions[state]) if actions[state][s][0] is Shift)

    rules = sorted({a[1] for row in actions.values() for a in row.values() if a[0] is not Shift}, key=_rule_key)
    numbers = {rule: i for i, rule in enumerate(rules)}
    states = [
        " ".join(
            f"{symbol}>{order[target]}" if kind is Shift else f"{symbol}<{numbers[target]}"
            for symbol, (kind, target) in sorted(actions[state].items())
        )
        for state in order
    ]
    data = {
        "terminals": {t.name: t.pattern.value for t in lark.terminals if isinstance(t.pattern, PatternStr)},
        "end": order[parse_table.end_states["start"]],
        "rules": [_rule_data(rule) for rule in rules],
        "states": states,
    }
    return json.dumps(data, indent=0, sort_keys=True) + "\n"


def _rule_key(rule: Any) -> tuple[str, str, tuple[str, ...]]:
    return (rule.origin.name, rule.alias or "", tuple(s.name for s in rule.expansion))


def _rule_data(rule: Any) -> str:
    """``origin = action symbols``.

    The action is the builder's function, ``^`` where a single child stands for the whole, ``*`` where the children join
    the list that the rule is part of. Symbols in parentheses are dropped.
    """
    origin = rule.origin.name
    if origin.startswith("_"):
        action = "*"
    elif rule.options.expand1 and rule.alias is None:
        action = "^"
    else:
        action = rule.alias or origin
    symbols = (f"({s.name})" if s.is_term and s.filter_out else s.name for s in rule.expansion)
    return " ".join([origin, "=", action, *symbols])


if __name__ == "__main__":
    Path(__file__).with_name("table.json").write_text(table_text(), encoding="utf-8", newline="\n")
