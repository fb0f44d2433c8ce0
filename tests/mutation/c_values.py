"""Expressions of the generated C on terms: values, places, calls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import tree_sitter

from tests.mutation.c_mutants import text
from tests.mutation.c_source import Source, Unclear, child, number, parameters
from tests.mutation.c_words import WIDTHS, Word, Words

State = dict[str, "Word | list[Word]"]
"""Values by name: locals, arrays, members (``in->x``, ``obstacle->distance``)."""


@dataclass
class Shared:
    """What both sides of a comparison have in common: unknown values by what they are of, and where they may lie."""

    words: Words
    ranges: Mapping[str, Mapping[str, tuple[int, int]]]
    """By function and member of its result."""
    memory: dict[tuple[object, ...], Word] = field(default_factory=dict)
    facts: list[Word] = field(default_factory=list)
    boxes: dict[tuple[str, str], list[tuple[list[Word], dict[str, Word]]]] = field(default_factory=dict)

    def remembered(self, key: tuple[object, ...], ctype: str) -> Word:
        """The same unknown for the same key."""
        if key not in self.memory:
            self.memory[key] = self.words.unknown(ctype)
        return self.memory[key]


@dataclass
class Values:
    """What expressions come to; ``wrong`` collects ways to undefined behaviour, each under its path's condition."""

    source: Source
    shared: Shared
    inline: bool
    """Whether static functions with a result are followed, rather than taken as boxes that answer alike to the same."""
    state: State = field(default_factory=dict)
    ctypes: dict[str, str] = field(default_factory=dict)
    pointers: dict[str, str] = field(default_factory=dict)
    wrong: list[Word] = field(default_factory=list)
    guards: list[Word] = field(default_factory=list)
    result: Word | None = None
    rounds: int = 0
    watched: tuple[str, int] | None = None
    """An entry of a table, of which ``reads`` collects when it is read."""
    reads: list[Word] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.words = self.shared.words

    def run(self, node: tree_sitter.Node) -> None:
        """Any statement."""
        raise NotImplementedError

    def _box(self, key: tuple[str, str], inputs: list[Word], outputs: Mapping[str, str]) -> dict[str, Word]:
        """The outputs of something that was met before with the same inputs, else new unknowns."""
        known = self.shared.boxes.setdefault(key, [])
        for before, answers in known:
            claims = [self.words.differ(a, b) for a, b in zip(before, inputs, strict=True)]
            if self.words.impossible([*self.shared.facts, *self.guards, self.words.any(claims)], 3):
                return answers
        if self.guards and known:
            raise Unclear(f"{key[0]} met with other values")
        answers = {k: self.words.unknown(t) for k, t in outputs.items()}
        known.append((inputs, answers))
        return answers

    # --- expressions ----------------------------------------------------------------------------

    def _effect(self, node: tree_sitter.Node) -> None:
        """An expression that stands as a statement."""
        match node.type:
            case "assignment_expression" if text(child(node, "operator")) == "=":
                value = self.value(child(node, "right"))[0]
                self._store(child(node, "left"), value)
            case "update_expression":
                target = node.named_children[0]
                value, sign = self.value(target)
                by = "+" if "++" in text(node) else "-"
                self._store(target, self.words.binary(by, value, 1, sign))
            case "cast_expression" if text(child(node, "type")) == "void":
                self.value(child(node, "value"))
            case "call_expression":
                self.value(node)
            case other:
                raise Unclear(other)

    def _store(self, target: tree_sitter.Node, value: Word) -> None:
        if target.type == "subscript_expression":
            name = text(child(target, "argument"))
            index = self.value(child(target, "index"))[0]
            items = self.state[name]
            if not isinstance(items, list):
                raise Unclear("an index into no array")
            value = self.words.cast(value, self.ctypes[name])
            self._within(index, len(items))
            hits = [self.words.binary("==", index, i, False) for i in range(len(items))]
            self.state[name] = [self.words.chosen(h, value, old) for h, old in zip(hits, items, strict=True)]
            return
        name = text(target) if target.type == "identifier" else self._member(target)
        if name not in self.ctypes:
            raise Unclear(f"a value for {name}")
        self.state[name] = self.words.cast(value, self.ctypes[name])

    def _within(self, index: Word, many: int) -> None:
        self._forbid(self.words.binary(">=", index, many, False))

    def _forbid(self, claim: Word) -> None:
        if not (isinstance(claim, int) and claim == 0):
            self.wrong.append(self.words.every([*self.guards, claim]))

    def _member(self, node: tree_sitter.Node) -> str:
        return f"{self._place(child(node, 'argument'))}.{text(child(node, 'field'))}"

    def _place(self, node: tree_sitter.Node) -> str:
        """What a pointer points to, as a name."""
        match node.type:
            case "identifier":
                return self.pointers.get(text(node), text(node))
            case "field_expression":
                return self._member(node)
            case "subscript_expression":
                index = self.value(child(node, "index"))[0]
                number = index if isinstance(index, int) else index.id()
                return f"{self._place(child(node, 'argument'))}[{number}]"
            case _:
                raise Unclear(f"a place: {text(node)}")

    def value(self, node: tree_sitter.Node) -> tuple[Word, bool]:
        """An expression's value, and whether its type has a sign."""
        match node.type:
            case "number_literal":
                return number(text(node)), "U" not in text(node).upper()
            case "parenthesized_expression":
                return self.value(node.named_children[0])
            case "identifier":
                name = text(node)
                held = self.state.get(name)
                if held is None or isinstance(held, list):
                    raise Unclear(f"the value of {name}")
                return held, WIDTHS[self.ctypes[name]][0] < 32 or WIDTHS[self.ctypes[name]][1]
            case "field_expression":
                return self._field(node)
            case "subscript_expression":
                return self._item(node)
            case "cast_expression":
                return self._cast(text(child(node, "type")), child(node, "value"))
            case "unary_expression":
                return self._unary(node)
            case "conditional_expression":
                return self._conditional(node)
            case "binary_expression":
                return self._binary(node)
            case "call_expression":
                return self._call(node)
            case other:
                raise Unclear(other)

    def _field(self, node: tree_sitter.Node) -> tuple[Word, bool]:
        name = self._member(node)
        if name not in self.state:
            struct = next((m for m in self.source.structs.values() if text(child(node, "field")) in m), None)
            if not name.startswith("in.") or struct is None:
                raise Unclear(f"the value of {name}")
            member = name.rpartition(".")[2]
            kinds = {t for m in self.source.structs.values() for k, t in m.items() if k == member}
            if len(kinds) != 1:
                raise Unclear(f"the type of {name}")
            ctype = self.source.true(kinds.pop())
            return self.shared.remembered(("memory", name), ctype), WIDTHS[ctype][0] < 32 or WIDTHS[ctype][1]
        held = self.state[name]
        assert not isinstance(held, list)
        ctype = self.ctypes[name]
        return held, WIDTHS[ctype][0] < 32 or WIDTHS[ctype][1]

    def _item(self, node: tree_sitter.Node) -> tuple[Word, bool]:
        name = text(child(node, "argument")).strip("()")
        index = self.value(child(node, "index"))[0]
        if name in self.source.tables:
            ctype, numbers = self.source.tables[name]
            if self.watched is not None and self.watched[0] == name:
                hit = self.words.binary("==", index, self.watched[1], False)
                self.reads.append(self.words.every([*self.guards, hit]))
            items: list[Word] = list(numbers)
        else:
            ctype = self.ctypes.get(name, "")
            held = self.state.get(name)
            if not isinstance(held, list):
                raise Unclear(f"an item of {name}")
            items = held
        self._within(index, len(items))
        sign = WIDTHS[ctype][0] < 32 or WIDTHS[ctype][1]
        if isinstance(index, int):
            return (items[index] if 0 <= index < len(items) else self.words.unknown(ctype)), sign
        found = items[-1]
        for at in range(len(items) - 2, -1, -1):
            found = self.words.chosen(self.words.binary("==", index, at, False), items[at], found)
        return found, sign

    def _cast(self, written: str, node: tree_sitter.Node) -> tuple[Word, bool]:
        ctype = self.source.true(written)
        return self.words.cast(self.value(node)[0], ctype), WIDTHS[ctype][0] < 32 or WIDTHS[ctype][1]

    def _unary(self, node: tree_sitter.Node) -> tuple[Word, bool]:
        value, sign = self.value(child(node, "argument"))
        match text(child(node, "operator")):
            case "-":
                return self.words.binary("-", 0, value, sign), sign
            case "~":
                return self.words.binary("^", value, 0xFFFF_FFFF, sign), sign
            case "!":
                return self.words.negated(value), True
            case other:
                raise Unclear(other)

    def _conditional(self, node: tree_sitter.Node) -> tuple[Word, bool]:
        condition = self.value(child(node, "condition"))[0]
        both = []
        for name, guard in (("consequence", condition), ("alternative", self.words.negated(condition))):
            self.guards.append(self.words.truth(guard))
            both.append(self.value(child(node, name)))
            self.guards.pop()
        return self.words.chosen(condition, both[0][0], both[1][0]), both[0][1] and both[1][1]

    def _binary(self, node: tree_sitter.Node) -> tuple[Word, bool]:
        operator = text(child(node, "operator"))
        left, left_sign = self.value(child(node, "left"))
        if operator in ("&&", "||"):
            self.guards.append(self.words.truth(left) if operator == "&&" else self.words.negated(left))
            right = self.value(child(node, "right"))[0]
            self.guards.pop()
            return (self.words.every if operator == "&&" else self.words.any)([left, right]), True
        right, right_sign = self.value(child(node, "right"))
        sign = left_sign if operator in ("<<", ">>") else left_sign and right_sign
        self._forbid(self.words.undefined(operator, left, right, sign))
        result = self.words.binary(operator, left, right, sign)
        return result, sign or operator in ("<", "<=", ">", ">=", "==", "!=")

    def _call(self, node: tree_sitter.Node) -> tuple[Word, bool]:
        name = text(child(node, "function"))
        callee = self.source.functions.get(name)
        arguments = child(node, "arguments").named_children
        if name.strip("()") in self.source.types or name.strip("()") in WIDTHS:
            # A cast of something in parentheses, which only a compiler can tell from a call.
            return self._cast(name.strip("()"), arguments[0])
        if callee is None:
            raise Unclear(f"a call of {name}")
        if any(a.type == "pointer_expression" for a in arguments):
            return self._called(name, [self._place(a.named_children[0]) for a in arguments]), False
        values = [self.value(a)[0] for a in arguments]
        ctype = self.source.true(text(child(callee, "type")))
        sign = WIDTHS[ctype][0] < 32 or WIDTHS[ctype][1]
        if not self.inline:
            return self._box(("call", name), values, {"": ctype})[""], sign
        inner = type(self)(self.source, self.shared, True)
        for parameter, value in zip(parameters(callee), values, strict=True):
            inner.ctypes[parameter[0]] = self.source.true(parameter[1])
            inner.state[parameter[0]] = self.words.cast(value, self.source.true(parameter[1]))
        inner.run(child(callee, "body"))
        for claim in inner.wrong:
            self._forbid(claim)
        if inner.result is None:
            raise Unclear(f"no result of {name}")
        return self.words.cast(inner.result, ctype), sign

    def _called(self, name: str, places: list[str]) -> Word:
        """A controller's own function: a box, whose results lie where its program says."""
        *reads, out = places
        if self.inline:
            return self._entered(name, places)
        inputs: list[Word] = []
        for key in sorted(k for k in self.state if any(k.startswith(f"{p}.") for p in reads)):
            value = self.state[key]
            assert not isinstance(value, list)
            inputs.append(value)
        written = sorted(k for k in self.state if k.startswith(f"{out}."))
        written += sorted(k for k in self.state if len(reads) > 1 and k.startswith(f"{reads[0]}."))
        answers = self._box(("call", name), inputs, {"": "uint32_t", **{k: self.ctypes[k] for k in written}})
        for key in written:
            self.state[key] = answers[key]
            low, high = self.shared.ranges.get(name, {}).get(key.rpartition(".")[2], (None, None))
            if low is not None and high is not None:
                sign = WIDTHS[self.ctypes[key]][1]
                self.shared.facts.append(self.words.binary(">=", answers[key], low & 0xFFFF_FFFF, sign))
                self.shared.facts.append(self.words.binary("<=", answers[key], high & 0xFFFF_FFFF, sign))
        return answers[""]

    def _entered(self, name: str, places: list[str]) -> Word:
        """The same, followed."""
        callee = self.source.functions[name]
        inner = type(self)(self.source, self.shared, True)
        taken = [p for p, _ in parameters(callee)]
        for mine, theirs in zip(places, taken, strict=True):
            for key in [k for k in self.state if k.startswith(f"{mine}.")]:
                inner.state[theirs + key[len(mine) :]] = self.state[key]
                inner.ctypes[theirs + key[len(mine) :]] = self.ctypes[key]
        inner.run(child(callee, "body"))
        for claim in inner.wrong:
            self._forbid(claim)
        for mine, theirs in zip(places, taken, strict=True):
            for key in [k for k in self.state if k.startswith(f"{mine}.")]:
                self.state[key] = inner.state[theirs + key[len(mine) :]]
        if inner.result is None:
            raise Unclear(f"no result of {name}")
        return inner.result
