"""Names inside rules and tables: inputs, outputs and their terms, looked up with a report where they are not known."""

from __future__ import annotations

from collections.abc import Callable

from fuzzyspec.check.similar import did_you_mean, listing
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label
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
        self._full = _full_partitions(decl)
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
            help = did_you_mean(name.text, self._input_index) or f"its inputs are {listing(self._input_index)}"
            if ("output", name.text) in self._declared:
                help = (
                    f"`{name.text}` is an output; a condition asks inputs. The inputs are {listing(self._input_index)}"
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
            help = did_you_mean(name.text, self._output_index) or f"its outputs are {listing(self._output_index)}"
            if ("input", name.text) in self._declared:
                help = f"`{name.text}` is an input; rules set outputs. The outputs are {listing(self._output_index)}"
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

    def input_terms(self, index: int, written: tuple[tree.Name, ...]) -> tuple[int, ...] | None:
        """Indices of the terms in a condition, in the input's order; None where one is unknown or stands twice."""
        first: dict[str, tree.Name] = {}
        for name in written:
            earlier = first.setdefault(name.text, name)
            if earlier is not name:
                self.error(
                    Diagnostic(
                        "FZ314",
                        f"the condition names term `{name.text}` twice",
                        name.span,
                        label="named again",
                        labels=(Label(earlier.span, "first here"),),
                        help="name it once; perhaps another term was meant",
                    )
                )
        found = {self.input_term(index, name) for name in written}
        known = tuple(sorted(t for t in found if t is not None))
        return known if len(known) == len(written) else None

    def output_term(self, index: int, name: tree.Name) -> int | None:
        """Index of a term of an output."""
        return self._term("output", self.outputs[index], name)

    def _known(self, kind: str) -> dict[str, int]:
        return self._input_index if kind == "input" else self._output_index

    def _term(self, kind: str, variable: Input | Output, name: tree.Name) -> int | None:
        for index, term in enumerate(variable.terms):
            if term.name == name.text:
                return index
        if name.text in self._declared.get((kind, variable.name), ()):
            self.broken = True
            return None
        known = self._declared.get((kind, variable.name)) or tuple(t.name for t in variable.terms)
        if not known:
            self.broken = True
            return None
        self.error(
            Diagnostic(
                "FZ313",
                f"{kind} `{variable.name}` has no term `{name.text}`",
                name.span,
                label="no such term",
                labels=(Label(variable.variable.span, "declared here"),),
                help=self._way_out(kind, variable.name, name.text, known),
            )
        )
        return None

    def _way_out(self, kind: str, variable: str, wrong: str, known: tuple[str, ...]) -> str:
        """The help of an unknown term."""
        if wrong == "full" and (kind, variable) in self._full:
            return "`full` at the end of a partition is a keyword: give the term another name"
        others = [v for (_, v), terms in self._declared.items() if wrong in terms]
        listed = f"its terms are {listing(known)}"
        if others:
            return f"{listed}; `{wrong}` is a term of {listing(others)}"
        return did_you_mean(wrong, known) or listed


def _declared_terms(decl: tree.ControllerDecl) -> dict[tuple[str, str], tuple[str, ...]]:
    """(kind, variable) to the names of all terms written for it, checked or not."""
    found: dict[tuple[str, str], tuple[str, ...]] = {}
    for item in decl.items:
        if isinstance(item, tree.VariableDecl):
            terms: list[str] = []
            for member in item.members:
                match member:
                    case tree.Partition(placed) | tree.Singletons(placed):
                        terms += [t.name.text for t in placed]
                    case tree.TermDecl(name):
                        terms.append(name.text)
                    case tree.OtherwiseClause():
                        pass
            for name in item.names:
                found[(item.kind, name.text)] = tuple(dict.fromkeys(terms))
    return found


def _full_partitions(decl: tree.ControllerDecl) -> frozenset[tuple[str, str]]:
    """(kind, variable) of all that have a partition with the keyword `full`."""
    return frozenset(
        (item.kind, name.text)
        for item in decl.items
        if isinstance(item, tree.VariableDecl)
        for name in item.names
        if any(isinstance(m, tree.Partition) and m.full for m in item.members)
    )
