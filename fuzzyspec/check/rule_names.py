"""Names inside rules and tables: inputs, outputs and their terms, looked up with a report where they are not known."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from fuzzyspec.check.similar import did_you_mean
from fuzzyspec.diagnostics.diagnostic import Diagnostic
from fuzzyspec.model.controller import Input, Output
from fuzzyspec.syntax import tree

Report = Callable[[Diagnostic], None]


class RuleNames:
    """The names that the rules of one controller may use.

    What was declared but did not survive its own check (so that it is no part of ``inputs`` or ``outputs``) is passed
    over in silence: its own diagnostic says enough. ``broken`` tells that some name could not be resolved, so the
    rules are not all there and nothing should be concluded from what is missing.
    """

    def __init__(
        self, decl: tree.ControllerDecl, inputs: tuple[Input, ...], outputs: tuple[Output, ...], report: Report
    ) -> None:
        self.controller = decl.name.text
        self.inputs = inputs
        self.outputs = outputs
        self._report = report
        self._input_index = {v.name: i for i, v in enumerate(inputs)}
        self._output_index = {v.name: i for i, v in enumerate(outputs)}
        self._declared = _declared_terms(decl)
        self.broken = any(name not in self._known(kind) for kind, name in self._declared)

    def error(self, diagnostic: Diagnostic) -> None:
        """Report something that leaves the rules incomplete."""
        self.broken = True
        self._report(diagnostic)

    def tell(self, diagnostic: Diagnostic) -> None:
        """Report something that leaves the rules complete, be it an error or a warning."""
        self._report(diagnostic)

    def input(self, name: tree.Name) -> int | None:
        """Index of an input."""
        found = self._input_index.get(name.text)
        if found is None and ("input", name.text) not in self._declared:
            help = did_you_mean(name.text, self._input_index) or _listed("its inputs are", self._input_index)
            if ("output", name.text) in self._declared:
                help = f"`{name.text}` is an output; a condition asks inputs. " + _listed(
                    "The inputs are", self._input_index
                )
            self.error(
                Diagnostic(
                    "FZ311",
                    f"controller `{self.controller}` has no input `{name.text}`",
                    name.span,
                    label="not an input",
                    help=help,
                )
            )
        return found

    def output(self, name: tree.Name) -> int | None:
        """Index of an output."""
        found = self._output_index.get(name.text)
        if found is None and ("output", name.text) not in self._declared:
            help = did_you_mean(name.text, self._output_index) or _listed("its outputs are", self._output_index)
            if ("input", name.text) in self._declared:
                help = f"`{name.text}` is an input; rules set outputs. " + _listed(
                    "The outputs are", self._output_index
                )
            self.error(
                Diagnostic(
                    "FZ312",
                    f"controller `{self.controller}` has no output `{name.text}`",
                    name.span,
                    label="not an output",
                    help=help,
                )
            )
        return found

    def input_term(self, index: int, name: tree.Name) -> int | None:
        """Index of a term of an input."""
        return self._term("input", self.inputs[index], name)

    def output_term(self, index: int, name: tree.Name) -> int | None:
        """Index of a term of an output."""
        return self._term("output", self.outputs[index], name)

    def _known(self, kind: str) -> dict[str, int]:
        return self._input_index if kind == "input" else self._output_index

    def _term(self, kind: str, variable: Input | Output, name: tree.Name) -> int | None:
        for index, term in enumerate(variable.terms):
            if term.name == name.text:
                return index
        if name.text in self._declared.get((kind, variable.name), frozenset()):
            self.broken = True
            return None
        known = [t.name for t in variable.terms]
        everything: tuple[Input | Output, ...] = (*self.inputs, *self.outputs)
        others = [v.name for v in everything if name.text in [t.name for t in v.terms]]
        help = did_you_mean(name.text, known) or _listed("its terms are", known)
        if others and did_you_mean(name.text, known) is None:
            help += f"; `{name.text}` is a term of {_quoted(others)}"
        self.error(
            Diagnostic(
                "FZ313",
                f"{kind} `{variable.name}` has no term `{name.text}`",
                name.span,
                label="no such term",
                help=help,
            )
        )
        return None


def _declared_terms(decl: tree.ControllerDecl) -> dict[tuple[str, str], frozenset[str]]:
    """(kind, variable) to the names of all terms written for it, checked or not."""
    found: dict[tuple[str, str], frozenset[str]] = {}
    for item in decl.items:
        if isinstance(item, tree.VariableDecl):
            terms: set[str] = set()
            for member in item.members:
                match member:
                    case tree.Partition(placed) | tree.Singletons(placed):
                        terms.update(t.name.text for t in placed)
                    case tree.TermDecl(name):
                        terms.add(name.text)
                    case tree.OtherwiseClause():
                        pass
            for name in item.names:
                found[(item.kind, name.text)] = frozenset(terms)
    return found


def _quoted(names: Iterable[str]) -> str:
    return ", ".join(f"`{n}`" for n in names)


def _listed(start: str, names: Iterable[str]) -> str:
    return f"{start} {_quoted(names)}"
