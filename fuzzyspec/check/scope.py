"""The names of a system as its statements see them, and what the statements come to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from fuzzyspec.check.arithmetic import Value
from fuzzyspec.check.controller import CheckedController
from fuzzyspec.check.findings import Findings
from fuzzyspec.check.names import too_early
from fuzzyspec.check.order import Key
from fuzzyspec.check.similar import hint
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Span
from fuzzyspec.model.interval import Intervals
from fuzzyspec.model.system import Call, CallOutput, Fold, Let
from fuzzyspec.syntax import tree


@dataclass(frozen=True, slots=True)
class Known:
    """A name that stands for a number; ``value`` is None where its definition failed and was reported."""

    value: Value | None


@dataclass(frozen=True, slots=True)
class Record:
    """A name (or a call itself) that stands for what a controller returned; ``call`` is the call's id."""

    call: str
    callee: CheckedController


@dataclass(frozen=True, slots=True)
class List:
    """A list of records."""

    name: str


Entry = Known | Record | List


@dataclass
class Context:
    """Where a statement stands: the loop variable and its list, and the block that calls are hoisted into."""

    block: list[Let | Call]
    items: dict[str, str] = field(default_factory=dict)
    loop: str | None = None
    fold: bool = False


class SystemScope:
    """Looks names up and reports those that mean nothing; keeps what was read, for unused ones."""

    def __init__(
        self,
        controllers: Mapping[str, CheckedController],
        findings: Findings,
        later: Mapping[Key, Span],
    ) -> None:
        self.controllers = controllers
        self.entries: dict[str, Entry] = {}
        self.fields: dict[Key, Value | None] = {}
        self.intervals = Intervals()
        self.context = Context([])
        self.read: set[Key] = set()
        self._report = findings.report
        self._later = later
        self._keys: dict[str, int] = {}

    def key(self, kind: str) -> str:
        """``test_1``, ``ratio_1``, ..: decisions in the order of the text."""
        self._keys[kind] = self._keys.get(kind, 0) + 1
        return f"{kind}_{self._keys[kind]}"

    def callables(self) -> Sequence[str]:
        return tuple(self.controllers)

    # --- names -------------------------------------------------------------------------------

    def name(self, ref: tree.Ref) -> Value | None:
        """The number that a name stands for, or None with a diagnostic."""
        first = ref.parts[0]
        if len(ref.parts) == 1:
            found = self._plain(first)
        elif first.text in self.context.items:
            found = self._field(self.context.items[first.text], ref.parts[1], ref)
        else:
            found = self._part(first, ref.parts[1])
        return None if found is None else replace(found, span=ref.span)

    def entry(self, name: tree.Name) -> Entry | None:
        """What a name stands for; reports it where it is unknown or comes later."""
        found = self.entries.get(name.text)
        self.read.add((None, name.text))
        if found is None:
            self._unknown(name)
        return found

    def _plain(self, name: tree.Name) -> Value | None:
        if name.text in self.context.items:
            self._say(
                "FZ243",
                f"`{name.text}` is a whole element, not a number",
                name.span,
                "has fields",
                f"name one: `{name.text}.{self._example(self.context.items[name.text])}`",
            )
            return None
        match self.entry(name):
            case None:
                return None
            case Known(value=value):
                return value
            case Record(callee=callee):
                outputs = [o.name for o in callee.controller.outputs]
                self._say(
                    "FZ246",
                    f"`{name.text}` is all that `{callee.name.text}` returned, not a number",
                    name.span,
                    "has outputs",
                    f"name one: `{name.text}.{outputs[0]}`" if outputs else None,
                )
            case List():
                self._say(
                    "FZ243",
                    f"`{name.text}` is a list, not a number",
                    name.span,
                    "has many elements",
                    f"fold it, as in `max(o.{self._example(name.text)} for o in {name.text}, otherwise ..)`",
                )
        return None

    def _part(self, first: tree.Name, part: tree.Name) -> Value | None:
        match self.entry(first):
            case None:
                return None
            case Known(value=value):
                if value is not None:
                    self._say("FZ203", f"`{first.text}` is a number and has no fields", part.span, "no such field")
            case Record() as record:
                return self.output(record, part)
            case List(name=name):
                if part.text == "count":
                    return Value(Fold("count", name, None, None, None), (), first.span.to(part.span))
                self._say(
                    "FZ243",
                    f"`{first.text}` is a list; a field belongs to one of its elements",
                    first.span.to(part.span),
                    "of which element?",
                    f"go over them: `for each o in {first.text} {{ .. o.{part.text} .. }}`, or fold",
                )
        return None

    def _field(self, over: str, part: tree.Name, ref: tree.Ref) -> Value | None:
        key = over, part.text
        self.read.add(key)
        if key in self.fields:
            return self.fields[key]
        if key in self._later:
            self._too_early(f"{ref.parts[0].text}.{part.text}", part.span, self._later[key])
        else:
            known = [name for listed, name in self.fields if listed == over]
            self._say(
                "FZ203",
                f"the elements of `{over}` have no field `{part.text}`",
                part.span,
                "no such field",
                hint(part.text, known, "fields"),
            )
        return None

    def output(self, record: Record, part: tree.Name) -> Value | None:
        """An output of what a controller returned."""
        controller = record.callee.controller
        found = next((o for o in controller.outputs if o.name == part.text), None)
        if found is not None:
            return Value(CallOutput(record.call, found.name), found.variable.unit.dims, part.span)
        if part.text in record.callee.vague:
            return None
        if part.text == "acting":
            self.not_acting(record, part)
        else:
            self._say(
                "FZ203",
                f"controller `{record.callee.name.text}` has no output `{part.text}`",
                part.span,
                "no such output",
                hint(part.text, [o.name for o in controller.outputs], "outputs"),
            )
        return None

    def not_acting(self, record: Record, part: tree.Name) -> None:
        """``acting`` where it cannot stand."""
        if record.callee.controller.behaviors:
            message = "`acting` is the code of a behavior, not a number to compute with"
            way_out = "hand it on: `output acting = drive.acting`"
        elif not record.callee.sound:
            return
        else:
            message = f"controller `{record.callee.name.text}` has no behaviors, so none is acting"
            way_out = None
        self._say("FZ245", message, part.span, "cannot stand here", way_out)

    # -----------------------------------------------------------------------------------------

    def _unknown(self, name: tree.Name) -> None:
        if (None, name.text) in self._later:
            self._too_early(name.text, name.span, self._later[None, name.text])
            return
        known = [*self.entries, *self.context.items]
        if name.text in self.controllers:
            way_out: str | None = f"`{name.text}` is a controller: call it, as in `{name.text}(..)`"
        else:
            way_out = hint(name.text, known, "names")
            owners = [over for over, field_ in self.fields if field_ == name.text and over is not None]
            if owners and "did you mean" not in way_out:
                way_out = (
                    f"`{name.text}` is a field of the elements of `{owners[0]}`: `o.{name.text}` in a loop over it"
                )
        self._say("FZ201", f"unknown name `{name.text}`", name.span, "not defined here", way_out)

    def _too_early(self, text: str, span: Span, defined: Span) -> None:
        self._report(too_early("name", text, span, defined))

    def _example(self, over: str) -> str:
        return next((name for listed, name in self.fields if listed == over), "field")

    def _say(self, code: str, message: str, span: Span, label: str = "", help: str | None = None) -> None:
        self._report(Diagnostic(code, message, span, label=label, help=help))
