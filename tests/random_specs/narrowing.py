"""A controller without one of its variables or terms: declarations, tables, rules and calls with one axis less."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass

from fuzzyspec.diagnostics.diagnostic import Span
from fuzzyspec.syntax import tree

Cells = dict[tuple[str, ...], tuple[str, ...]]
"""What a table says: terms of its inputs, and of its outputs."""


@dataclass(frozen=True)
class Gone:
    """A variable, or one of its terms."""

    variable: str
    term: str | None


def narrowed(text: str, module: tree.Module, c: tree.ControllerDecl, gone: Gone) -> str:
    """The text without that. Where an output loses a term, its rules and cells take another one."""
    edits: list[tuple[Span, str]] = []
    for item in c.items:
        match item:
            case tree.VariableDecl(names=names) if gone.variable in (n.text for n in names):
                edits.append((item.span, _declaration(text, item, gone)))
            case tree.Table():
                edits.append((item.span, _table(item, c, gone)))
            case tree.BehaviorDecl() | tree.RulesBlock():
                edits += [(rule.span, _rule(text, rule, c, gone)) for rule in item.rules]
            case _:
                pass
    if gone.term is None:
        for call in _calls(module, c.name.text):
            kept = [a for a in call.arguments if a.name is None or a.name.text != gone.variable]
            inside = ", ".join(text[a.span.start : a.span.end] for a in kept)
            edits.append((call.span, f"{c.name.text}({inside}){'' if call.field is None else f'.{call.field.text}'}"))
    for span, new in sorted(edits, reverse=True):
        text = text[: span.start] + new + text[span.end :]
    return text


def _declaration(text: str, item: tree.VariableDecl, gone: Gone) -> str:
    names = [n.text for n in item.names if gone.term is not None or n.text != gone.variable]
    if not names:
        return ""
    said = text[item.span.start : item.span.end]
    head = f"{item.kind} {', '.join(names)}"
    body = text[item.names[-1].span.end : item.span.end]
    if gone.term is None:
        return head + body
    for member in item.members:
        match member:
            case tree.Partition(terms=terms) | tree.Singletons(terms=terms):
                kept = [t for t in terms if t.name.text != gone.term]
                at = [f" at {text[t.peak.span.start : t.peak.span.end]}" if t.peak else "" for t in kept]
                listed = (", " if terms[0].peak else " ").join(t.name.text + a for t, a in zip(kept, at, strict=True))
                word = "singletons" if isinstance(member, tree.Singletons) else "partition"
                full = " full" if isinstance(member, tree.Partition) and member.full else ""
                old = text[member.span.start : member.span.end]
                said = said.replace(old, f"{word} {listed}{full}", 1)
            case tree.TermDecl(name=name) if name.text == gone.term:
                said = said.replace(text[member.span.start : member.span.end], "", 1)
            case _:
                pass
    return said


def _table(table: tree.Table, c: tree.ControllerDecl, gone: Gone) -> str:
    inputs, outputs = [n.text for n in table.inputs], [n.text for n in table.outputs]
    cells = _cells(table)
    if gone.variable in inputs:
        axis = inputs.index(gone.variable)
        if gone.term is None:
            first = next(iter(cells))[axis]
            cells = {k[:axis] + k[axis + 1 :]: v for k, v in cells.items() if k[axis] == first}
            inputs = inputs[:axis] + inputs[axis + 1 :]
        else:
            cells = {k: v for k, v in cells.items() if k[axis] != gone.term}
    elif gone.variable in outputs:
        axis = outputs.index(gone.variable)
        if gone.term is None:
            cells = {k: v[:axis] + v[axis + 1 :] for k, v in cells.items()}
            outputs = outputs[:axis] + outputs[axis + 1 :]
        else:
            other = _another(c, gone)
            cells = {
                k: tuple(other if i == axis and t == gone.term else t for i, t in enumerate(v))
                for k, v in cells.items()
            }
    if not inputs or not outputs or not cells:
        return ""
    head = f"table {', '.join(outputs)} by {', '.join(inputs)} {{"
    if len(inputs) == 1:
        single = (f"{k[0]}: {'/'.join(v)}" for k, v in cells.items())
        return "\n".join([head, *single, "}"])
    columns = list(dict.fromkeys(k[-1] for k in cells))
    rows = []
    for row in dict.fromkeys(k[:-1] for k in cells):
        label = row[0] if len(row) == 1 else f"({', '.join(row)})"
        rows.append(f"{label}: " + " ".join("/".join(cells[(*row, column)]) for column in columns))
    return "\n".join([head, " ".join(columns), *rows, "}"])


def _cells(table: tree.Table) -> Cells:
    columns = [(n.text,) for n in table.columns] or [()]
    return {
        (*(n.text for n in row.labels), *column): tuple(n.text for n in entry)
        for row in table.rows
        for column, entry in zip(columns, row.entries, strict=False)
    }


def _rule(text: str, rule: tree.Rule, c: tree.ControllerDecl, gone: Gone) -> str:
    condition = _condition(rule.condition, gone)
    consequents = []
    for part in rule.consequents:
        output, term = part.output.text, part.term.text
        if output == gone.variable and gone.term is None:
            continue
        consequents.append(f"{output} is {_another(c, gone) if (output, term) == (gone.variable, gone.term) else term}")
    if condition is None or not consequents:
        return ""
    weight = "" if rule.weight is None else f" with {text[rule.weight.span.start : rule.weight.span.end]}"
    return f"if {condition} then {', '.join(consequents)}{weight}"


def _condition(condition: tree.Condition, gone: Gone) -> str | None:
    match condition:
        case tree.Is(variable=variable, terms=terms, negated=negated):
            ours = variable.text == gone.variable
            kept = [t.text for t in terms if not (ours and gone.term in (None, t.text))]
            if not kept:
                return None
            if len(terms) == 1:
                return f"{variable.text} is {'not ' if negated else ''}{kept[0]}"
            return f"{variable.text} {'not ' if negated else ''}in {{{', '.join(kept)}}}"
        case tree.Antecedent(op=op, operands=operands):
            parts = [p for p in (_condition(o, gone) for o in operands) if p is not None]
            if not parts:
                return None
            if op == "not":
                return f"not ({parts[0]})"
            joined = f" {op} ".join(parts)
            return joined if len(parts) == 1 or op == "and" else f"({joined})"


def _another(c: tree.ControllerDecl, gone: Gone) -> str:
    """A term of the variable that stays."""
    for item in c.items:
        if isinstance(item, tree.VariableDecl) and gone.variable in (n.text for n in item.names):
            for member in item.members:
                placed = member.terms if isinstance(member, tree.Partition | tree.Singletons) else ()
                names = [t.name.text for t in placed] + (
                    [member.name.text] if isinstance(member, tree.TermDecl) else []
                )
                for name in names:
                    if name != gone.term:
                        return name
    return ""


def _calls(node: object, callee: str) -> Iterator[tree.Call]:
    """Calls of a controller, none of them within another."""
    if isinstance(node, tuple):
        for part in node:
            yield from _calls(part, callee)
    elif isinstance(node, tree.Call) and node.callee.text == callee:
        yield node
    elif is_dataclass(node):
        for f in fields(node):
            yield from _calls(getattr(node, f.name), callee)
