"""What is shown of C that is not what the integer program says: a smallest case, and what came of it."""

from __future__ import annotations

from fuzzyspec.fixed.run import Run
from fuzzyspec.model.variable import Variable
from fuzzyspec.native import Death, Result
from fuzzyspec.verify.cases import Batch
from fuzzyspec.verify.example import example_at, single, spoken
from fuzzyspec.verify.report import Build, Difference, Failure
from fuzzyspec.verify.runner import Runner, any_of, differing
from fuzzyspec.verify.shrink import shrink
from fuzzyspec.verify.subject import Subject


def difference(subject: Subject, case: Batch, runner: Runner, where: str = "", on: Build | None = None) -> Failure:
    """Shrink a case, a batch of one, at which C and model differ."""

    def fails(candidates: Batch) -> int | None:
        got = runner.run(subject.name, candidates.inputs, candidates.state)
        if isinstance(got, Death):
            return None
        run = subject.fixed(candidates.inputs, candidates.state)
        differs = any_of(differing(got, run), candidates.n)
        return int(differs.argmax()) if differs.any() else None

    small = shrink(subject, case, fails)
    got = runner.run(subject.name, small.inputs, small.state)
    assert isinstance(got, Result)
    found = _differences(subject, got, subject.fixed(small.inputs, small.state))
    message = f"the C differs from the integer program{where}"
    return Failure("c", subject.name, message, example_at(subject, small, 0), found, on=on)


def death(
    subject: Subject, batch: Batch, died: Death, runner: Runner, where: str = "", on: Build | None = None
) -> Failure:
    """Shrink the case at which C died. A hang is shown as found: each try would cost its time limit."""
    case = single(batch, died.case)

    def fails(candidates: Batch) -> int | None:
        got = runner.run(subject.name, candidates.inputs, candidates.state)
        return got.case if isinstance(got, Death) else None

    small = case if "no end" in died.what or fails(case) is None else shrink(subject, case, fails)
    message = f"the C did not return{where}: {died.what}"
    return Failure("death", subject.name, message, example_at(subject, small, 0), (), died.output, on=on)


def _differences(subject: Subject, got: Result, run: Run) -> tuple[Difference, ...]:
    """What differs at the first case, with values where there are some."""
    found: list[Difference] = []
    variables = {p.name: p.variable for p in subject.function.outputs}
    for name, wanted in run.outputs.items():
        if got.outputs[name][0] != wanted[0]:
            variable = variables[name]
            found.append(Difference(name, *(_told(variable, int(r)) for r in (wanted[0], got.outputs[name][0]))))
    if got.status[0] != run.status[0]:
        bits = [b.name for b in subject.function.status]
        found.append(Difference("status", *(_bits(bits, int(s)) for s in (run.status[0], got.status[0]))))
    for key in got.state:
        if got.state[key][0] != run.state[key][0]:
            variable = subject.state[key].variable
            both = (run.state[key][0], got.state[key][0])
            found.append(Difference(f"state {key}", *(_told(variable, int(r)) for r in both)))
    return tuple(found)


def _told(variable: Variable | None, raw: int) -> str:
    return f"{raw}" if variable is None else f"{raw} ({spoken(variable, raw)})"


def _bits(names: list[str], status: int) -> str:
    """A status word by the names of its bits."""
    known = [name for i, name in enumerate(names) if status >> i & 1]
    return " | ".join(known or ["OK"]) if status >> len(names) == 0 else f"{status:#x}"
