"""Runs the generated C on terms: what a function's statements make of any state at all.

Only the C that fuzzyc prints is understood. What is not, or what cannot be followed (a loop whose end is not known),
raises ``Unclear``, and so does a loop or a call that meets other values than it met before: then nothing is shown.
"""

from __future__ import annotations

import tree_sitter

from tests.mutation.c_mutants import text
from tests.mutation.c_source import Unclear, child, declared, nodes, number
from tests.mutation.c_values import Values
from tests.mutation.c_words import Word

MOST_ROUNDS = 300
"""Rounds of a loop that are followed."""


class Machine(Values):
    """Runs statements."""

    # --- statements -----------------------------------------------------------------------------

    def run(self, node: tree_sitter.Node) -> None:
        """Any statement."""
        match node.type:
            case "compound_statement":
                for child in node.named_children:
                    self.run(child)
            case "declaration":
                self._declare(node)
            case "expression_statement":
                if node.named_children:
                    self._effect(node.named_children[0])
            case "if_statement":
                self._if(node)
            case "for_statement":
                self._for(node)
            case "return_statement":
                if self.guards:
                    raise Unclear("a return on the way")
                self.result = self.value(node.named_children[0])[0]
            case "comment" | ";":
                pass
            case other:
                raise Unclear(other)

    def _declare(self, node: tree_sitter.Node) -> None:
        written = text(child(node, "type"))
        for part in node.children_by_field_name("declarator"):
            name = declared(part)
            value = part.child_by_field_name("value")
            inner = part.child_by_field_name("declarator") if part.type == "init_declarator" else part
            assert inner is not None
            ctype = self.source.true(written)
            if inner.type == "pointer_declarator":
                if value is None or value.type != "pointer_expression":
                    raise Unclear("a pointer")
                self.pointers[name] = self._place(value.named_children[0])
            elif inner.type == "array_declarator":
                if value is not None:
                    raise Unclear("an array with values")
                many = number(text(child(inner, "size")))
                self.ctypes[name] = ctype
                self.state[name] = [self.words.unknown(ctype) for _ in range(many)]
            elif ctype in self.source.structs:
                self.pointers[name] = name
                for member, kind in self.source.structs[ctype].items():
                    self.ctypes[f"{name}.{member}"] = self.source.true(kind)
                    self.state[f"{name}.{member}"] = self.words.unknown(self.source.true(kind))
            else:
                self.ctypes[name] = ctype
                known = self.words.unknown(ctype) if value is None else self.words.cast(self.value(value)[0], ctype)
                self.state[name] = known

    def _if(self, node: tree_sitter.Node) -> None:
        condition = self.words.truth(self.value(child(node, "condition"))[0])
        otherwise = node.child_by_field_name("alternative")
        branches = [child(node, "consequence"), None if otherwise is None else otherwise.named_children[-1]]
        if isinstance(condition, int):
            taken = branches[0 if condition else 1]
            if taken is not None:
                self.run(taken)
            return
        before, ends = self.state, []
        for branch, guard in zip(branches, (condition, self.words.negated(condition)), strict=True):
            self.state = {k: list(v) if isinstance(v, list) else v for k, v in before.items()}
            self.guards.append(guard)
            if branch is not None:
                self.run(branch)
            self.guards.pop()
            ends.append(self.state)
        self.state = {k: self._joined(condition, ends[0][k], ends[1][k]) for k in before}

    def _joined(self, condition: Word, one: Word | list[Word], other: Word | list[Word]) -> Word | list[Word]:
        if isinstance(one, list) and isinstance(other, list):
            return [self.words.chosen(condition, a, b) for a, b in zip(one, other, strict=True)]
        assert not isinstance(one, list) and not isinstance(other, list)
        return self.words.chosen(condition, one, other)

    def _for(self, node: tree_sitter.Node) -> None:
        start = child(node, "initializer")
        before = set(self.state)
        if start.type == "declaration":
            self._declare(start)
        else:
            self._effect(start)
        condition = self.words.truth(self.value(child(node, "condition"))[0])
        if not isinstance(condition, int):
            self._boxed_loop(node)
        while condition and isinstance(condition, int):
            self.rounds += 1
            if self.rounds > MOST_ROUNDS:
                raise Unclear("a long loop")
            self.run(child(node, "body"))
            self._effect(child(node, "update"))
            condition = self.words.truth(self.value(child(node, "condition"))[0])
            if not isinstance(condition, int):
                raise Unclear("a loop's end")
        self.state = {k: v for k, v in self.state.items() if k in before}

    def enter(self, node: tree_sitter.Node) -> None:
        """Any round of a loop: what it writes may hold anything, on both sides the same."""
        start = child(node, "initializer")
        if start.type != "declaration":
            raise Unclear("a loop's beginning")
        self._declare(start)
        written = self._written(node)
        for key in written & set(self.state):
            held, ctype = self.state[key], self.ctypes[key]
            many = len(held) if isinstance(held, list) else 1
            fresh = [self.shared.remembered(("round", node.start_point.row, key, i), ctype) for i in range(many)]
            self.state[key] = fresh if isinstance(held, list) else fresh[0]

    # --- boxes: what is the same on both sides --------------------------------------------------

    def _boxed_loop(self, node: tree_sitter.Node) -> None:
        """All that a loop writes is unknown, and the same for the same of all that it may read."""
        reads = {text(n) for n in nodes(node) if n.type in ("identifier", "field_expression")}
        used = sorted(k for k in self.state if k.split("->")[0].split(".")[0] in {r.split("->")[0] for r in reads})
        writes = self._written(node)
        inputs: list[Word] = []
        for key in used:
            value = self.state[key]
            inputs += value if isinstance(value, list) else [value]
        outputs = {}
        for key in sorted(writes & set(self.state)):
            value = self.state[key]
            for at in range(len(value) if isinstance(value, list) else 1):
                outputs[f"{key}[{at}]"] = self.ctypes[key]
        found = self._box(("loop", text(node)), inputs, outputs)
        for key in sorted(writes & set(self.state)):
            value = self.state[key]
            if isinstance(value, list):
                self.state[key] = [found[f"{key}[{at}]"] for at in range(len(value))]
            else:
                self.state[key] = found[f"{key}[0]"]

    def _written(self, node: tree_sitter.Node) -> set[str]:
        """All that a statement may write."""
        writes = set()
        for part in nodes(node):
            if part.type in ("assignment_expression", "update_expression"):
                writes.add(self._target(part.child_by_field_name("left") or part.named_children[0]))
            elif part.type == "call_expression" and text(child(part, "function")) in self.source.functions:
                writes |= {k for k in self.state if f"&{k.split('.')[0]}" in text(part)}
        return writes

    def _target(self, node: tree_sitter.Node) -> str:
        if node.type == "subscript_expression":
            return self._target(child(node, "argument"))
        return text(node) if node.type == "identifier" else self._member(node)
