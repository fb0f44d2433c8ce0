"""Shows by abstract interpretation that the C has no undefined behaviour and no wrap-around, whatever it is given.

Frama-C's EVA follows all values through the C. What it cannot see, being about two values at once, is taken out of its
C as a lemma and proved for all values by solvers; what neither proves is an alarm.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

from fuzzyspec.diagnostics.refusal import MissingTool
from fuzzyspec.emit.names import name_module
from fuzzyspec.emit.statements import Ranges, ranges_of
from fuzzyspec.fixed.program import Program

__all__ = ["WIDTHS", "Alarm", "Proof", "prove"]

WIDTHS = (32, 16)
"""The widths of ``int`` that the C is proved for."""
GIVEN_UP = 40
"""Claims that cannot be proved before it is left at that."""


@dataclass(frozen=True, slots=True)
class Alarm:
    """What may go wrong: ``kind`` in the analyser's words, ``text`` what was not shown to hold."""

    function: str
    kind: str
    text: str


@dataclass(frozen=True, slots=True)
class Proof:
    """One module on a machine whose ``int`` has ``bits``.

    ``seen``: what EVA showed by itself of the claims put to it. ``proved``: lemmas by what proved them.
    ``given_up``: intervals of the compiler that were not proved, and are not needed for the rest.
    ``kept``: states hold what the module says they do before a call, and it was shown that they do so after.
    ``reached`` of the ``statements`` of the C, as the analyser counts them, are executed for some input.
    """

    bits: int
    seen: int
    proved: Mapping[str, int]
    given_up: int
    reached: int
    statements: int
    alarms: tuple[Alarm, ...]
    kept: bool = False

    @property
    def ok(self) -> bool:
        """Whether no alarm is left."""
        return not self.alarms


Progress = Callable[[int, int, str], None]


def prove(program: Program, files: Mapping[str, bytes], bits: int, progress: Progress | None = None) -> Proof:
    """Prove the C of ``program`` in ``files`` where ``int`` has ``bits``.

    The intervals that the compiler has derived are claims, to be proved like what the analyser asks for, and what later
    steps may build on. One that is not proved is given up, and all is done again without it. Where states of any value
    leave an alarm, all is done again with states in their ranges, and it is to be shown that they stay there.

    ``progress`` is called with lemmas done, lemmas to do and the function's name. Raises MissingTool where Frama-C or a
    solver is not installed, ``eva.AnalyserFailed`` where the C cannot be analysed.
    """
    needed()
    proof = _with_states(program, files, bits, progress, False)
    if proof.ok or not any(f.state or f.nested for f in program.functions):
        return proof
    return _with_states(program, files, bits, progress, True)


def _with_states(
    program: Program, files: Mapping[str, bytes], bits: int, progress: Progress | None, kept: bool
) -> Proof:
    from fuzzyspec.prove import eva
    from fuzzyspec.prove.driver import print_driver
    from fuzzyspec.prove.hints import hints_of

    names = name_module(program)
    ranges = {names.functions[f.name].function: ranges_of(program, f, names) for f in program.functions}
    ranges |= {name: Ranges({}, {}) for name in (*names.dividers.values(), names.mul_high)}
    results = dict.fromkeys(names.dividers.values(), (0, 2**16))
    hints = {name: hints_of(kernel) for kernel, name in names.dividers.items()}
    given_up: frozenset[str] = frozenset()
    with tempfile.TemporaryDirectory(prefix="fuzzyc-") as created:
        folder = Path(created).resolve()
        for name, content in files.items():
            (folder / name).write_bytes(content)
        (folder / "fuzzyc_driver.c").write_text(print_driver(program, kept), encoding="utf-8")
        normal = eva.normalised(folder, [names.source, "fuzzyc_driver.c"], bits)
        while True:
            looks = eva.instrumented(normal, ranges, results, hints, given_up)
            (folder / "fuzzyc_seen.c").write_text(looks, encoding="utf-8")
            proof, unproved = _proved(*eva.analysed(folder, "fuzzyc_seen.c", bits), bits, progress)
            if not unproved or len(given_up) > GIVEN_UP:
                return replace(proof, given_up=len(given_up), kept=kept)
            given_up |= unproved


def _proved(found: str, said: str, bits: int, progress: Progress | None) -> tuple[Proof, frozenset[str]]:
    """What one analysis comes to, and the claims of ours that were not proved."""
    from fuzzyspec.prove import eva
    from fuzzyspec.prove.annotated import LABEL, OWN, TOTAL
    from fuzzyspec.prove.discharge import discharged
    from fuzzyspec.prove.reading import obligations

    undecided = eva.undecided(said)
    facts = obligations(found, eva.shown(said))
    every = [(f, at, o) for f in facts for at, o in enumerate(f.obligations)]
    ours = {o.kind for _, _, o in every if o.kind.startswith((LABEL, OWN))}
    open_ = [(f, at, o) for f, at, o in every if o.kind not in ours or o.kind in undecided]
    proved: Counter[str] = Counter()
    alarms: list[Alarm] = []
    unproved: set[str] = set()
    for done, (f, at, obligation) in enumerate(open_):
        if progress is not None:
            progress(done, len(open_), obligation.function)
        by = discharged(f, at)
        if by is not None:
            proved[by] += 1
            continue
        ghost = re.search(TOTAL + r"\w+", obligation.text)
        if obligation.kind.startswith(LABEL):
            unproved.add(obligation.kind)
        elif ghost is not None:
            unproved.add(ghost[0])
        kind = "range" if obligation.kind.startswith(LABEL) else obligation.kind
        alarms.append(Alarm(obligation.function, kind, obligation.text))
    unread = eva.alarms_said(said) - sum(o.kind not in ours for _, _, o in every)
    if unread > 0:
        alarms.append(Alarm("", "unread", f"{unread} alarms of the analyser that its C does not show"))
    proof = Proof(bits, len(ours - undecided), dict(proved), 0, *eva.reached(said), tuple(alarms))
    return proof, frozenset(unproved)


def needed() -> None:
    """Refuse where Frama-C or a solver is missing."""
    if shutil.which("frama-c") is None:
        raise MissingTool("frama-c was not found", "install it (Debian, Ubuntu: apt install frama-c-base)")
    for module, package in (("z3", "z3-solver"), ("bitwuzla", "bitwuzla")):
        if find_spec(module) is None:
            raise MissingTool(f"the {package} package was not found", "run `pip install 'fuzzyc[prove]'`")
