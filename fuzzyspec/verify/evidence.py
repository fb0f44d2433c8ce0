"""A verification as a document that a later reader can check again: what was verified, how, and what was shown.

It holds the spec's own text and the hashes of the C and of the tool, and everything that was asked, so that the same
verification can be run once more with nothing else at hand. JSON, with exact numbers as ``p/q`` strings.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, fields
from fractions import Fraction
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any, Literal, get_args

from fuzzyspec.diagnostics.diagnostic import Source
from fuzzyspec.diagnostics.refusal import Refusal
from fuzzyspec.lower.strategy import Goal, Target
from fuzzyspec.machines.machine import Emulators
from fuzzyspec.machines.toolchains import Kind
from fuzzyspec.resources import folder
from fuzzyspec.verify.render import as_json
from fuzzyspec.verify.report import MachineFound, Report
from fuzzyspec.version import __version__

FORMAT = 1

Bounds = Literal["quick", "thorough"]


@dataclass(frozen=True, slots=True)
class Asked:
    """What a verification was asked for, as plain data. None stands for the default.

    ``bounds`` to ``tolerance`` are what the C was compiled with, the last as ``p/q`` percent; ``targets`` to
    ``target_cases`` are the builds on other machines; ``exhaustive``: whether every input is swept.
    """

    seed: int | None = None
    cases: int | None = None
    only: tuple[str, ...] = ()
    sanitize: bool = True
    worst: bool = False
    bounds: Bounds = "quick"
    optimize: Goal = "balanced"
    chosen_for: Target = "generic"
    tolerance: str | None = None
    targets: tuple[str, ...] = ()
    levels: tuple[str, ...] | None = None
    compiler: Kind | None = None
    emulator: Emulators | None = None
    target_cases: int | None = None
    exhaustive: bool = False


@dataclass(frozen=True, slots=True)
class Verified:
    """What a verification was of: the spec, and the C by file name. ``theirs``: C that a user had."""

    source: Source
    c: Mapping[str, bytes]
    theirs: bool = False


def document(verified: Verified, asked: Asked, report: Report) -> dict[str, Any]:
    """The certificate of a verification, as plain data."""
    source = verified.source
    return {
        "certificate": FORMAT,
        "ok": report.ok,
        "tool": {"name": "fuzzyc", "version": __version__, "sha256": tool_hash()},
        "spec": {"name": source.name, "sha256": source.sha256, "text": source.text},
        "c": {
            name: {"sha256": hashlib.sha256(content).hexdigest()}
            | ({"text": content.decode("utf-8", "surrogateescape")} if verified.theirs else {})
            for name, content in sorted(verified.c.items())
        },
        "asked": {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(asked).items()},
        "shown": list(_shown(report, asked)),
        "found": as_json(report),
    }


def opened(found: Any) -> tuple[Verified, Asked]:
    """What a certificate is of. Refusal where it is none, or has been altered."""
    if not isinstance(found, dict) or found.get("certificate") != FORMAT:
        raise Refusal(
            f"this is no certificate of format {FORMAT}", "write one by `fuzzyc verify FILE.fz --certificate`"
        )
    try:
        spec, c = found["spec"], found["c"]
        texts = {name: entry["text"].encode("utf-8", "surrogateescape") for name, entry in c.items() if "text" in entry}
        asked = {f.name: found["asked"][f.name] for f in fields(Asked)}
        asked |= {k: tuple(v) for k, v in asked.items() if isinstance(v, list)}
        verified = Verified(Source(spec["name"], spec["text"]), texts, theirs=bool(texts))
        whole = verified.source.sha256 == spec["sha256"] and all(
            hashlib.sha256(content).hexdigest() == c[name]["sha256"] for name, content in texts.items()
        )
    except (KeyError, TypeError, AttributeError) as error:
        raise Refusal(f"the certificate lacks what it needs to be checked ({error})") from error
    if not whole:
        raise Refusal("the certificate was altered: a text in it does not have the hash that it gives")
    if not _sound(asked):
        raise Refusal("the certificate was altered: it asks for what no verification can be asked for")
    return verified, Asked(**asked)


def _sound(asked: Mapping[str, Any]) -> bool:
    """Whether values read from a file are of their types."""
    words = {"bounds": Bounds, "optimize": Goal, "chosen_for": Target}
    return (
        all(asked[name] in get_args(kinds) for name, kinds in words.items())
        and asked["compiler"] in (None, *get_args(Kind))
        and asked["emulator"] in (None, *get_args(Emulators))
        and all(
            asked[k] is None or (type(asked[k]) is int and asked[k] >= 0) for k in ("seed", "cases", "target_cases")
        )
        and all(type(asked[k]) is bool for k in ("sanitize", "worst", "exhaustive"))
        and all(_words(asked[k]) for k in ("only", "targets", "levels"))
        and (asked["tolerance"] is None or re.fullmatch(r"\d{1,30}(/\d{1,30})?", str(asked["tolerance"])) is not None)
    )


def _natural(found: Any) -> bool:
    return found is None or (type(found) is int and found >= 0)


def _words(found: Any) -> bool:
    return found is None or (isinstance(found, tuple) and all(isinstance(word, str) for word in found))


def differences(before: Mapping[str, Any], after: Mapping[str, Any]) -> tuple[list[str], list[str]]:
    """Claims of a certificate that do not hold any more, and what else is other than it was.

    ``after`` is the certificate of the same verification, run again. Each claim must be made again, as strong.
    """
    broken: list[str] = []
    notes: list[str] = []
    for name in sorted({*before["c"], *after["c"]}):
        was, now = (side["c"].get(name, {}).get("sha256") for side in (before, after))
        if was != now:
            broken.append(f"{name} is not what was verified: sha256 {now or 'of no such file'} instead of {was}")
    again = {_key(claim): claim for claim in after["shown"]}
    for claim in before["shown"]:
        found = again.get(_key(claim))
        if found is None:
            broken.append(f"not shown again: {_told(claim)}")
        elif found["cases"] < claim["cases"]:
            broken.append(f"shown over fewer cases ({found['cases']:,} for {claim['cases']:,}): {_told(claim)}")
        elif claim["bound"] is not None and Fraction(found["bound"]) > Fraction(claim["bound"]):
            broken.append(f"shown with the bound {found['bound']}, not {claim['bound']}: {_told(claim)}")
    if not after["ok"]:
        broken += [f"the verification fails: {failure['message']}" for failure in after["found"]["failures"]]
    if before["tool"]["sha256"] != after["tool"]["sha256"]:
        notes.append(f"written by another fuzzyc ({before['tool']['version']}); this is {after['tool']['version']}")
    if before["found"]["compiler"] != after["found"]["compiler"]:
        notes.append(f"verified with {before['found']['compiler']}; now with {after['found']['compiler']}")
    return broken, notes


def tool_hash() -> str:
    """SHA-256 over the compiler's own files, by name: its Python, its data, the grammar and the templates."""
    whole = hashlib.sha256()
    roots = {"fuzzyspec": files("fuzzyspec"), "grammar": folder("grammar"), "templates": folder("templates")}
    for name, content in sorted(found for prefix, root in roots.items() for found in _files(root, prefix)):
        whole.update(f"{len(name)} {name} {len(content)} ".encode())
        whole.update(content)
    return whole.hexdigest()


def _files(place: Traversable, name: str) -> Iterator[tuple[str, bytes]]:
    for inner in place.iterdir():
        if inner.is_dir() and inner.name not in ("__pycache__", "_data"):
            yield from _files(inner, f"{name}/{inner.name}")
        elif inner.is_file() and not inner.name.startswith("."):
            yield f"{name}/{inner.name}", inner.read_bytes()


def _shown(report: Report, asked: Asked) -> Iterator[dict[str, Any]]:
    """Every claim and how it was shown: over how many cases, or (then 0) by derivation, for all inputs."""
    if not report.ok:
        return
    derived = f"derived from the lemmas of docs/numbers.md ({asked.bounds}), and held over all cases"
    for found in report.functions:
        name = found.function
        compared = f"compared over random and aimed inputs, built by {report.compiler}"
        yield _claim(name, "the C returns what the integer program says, bit for bit", compared, found.cases)
        if every := found.kinds.get("every input", 0):
            claim = "the C returns what the integer program says for every input there is"
            yield _claim(name, claim, "every input was tried", every)
        if found.sanitized:
            run = f"run under the {' and '.join(report.sanitizers)} sanitizers"
            yield _claim(name, "the C runs without undefined behaviour", run, found.sanitized)
        for output in found.outputs:
            if output.bound is not None:
                claim = f"|C - exact| of {output.output} is at most the bound, for every input"
                yield _claim(name, claim, derived, 0, output.bound, output.unit)
        for decision in found.decisions:
            claim = f"the exact meaning decides {decision.key} alike where its operands differ by more than the bound"
            yield _claim(name, claim, derived, 0, decision.band or Fraction(0))
    for machine in report.machines:
        yield from _on(machine)


def _on(machine: MachineFound) -> Iterator[dict[str, Any]]:
    run = f"run by {machine.emulator}" if machine.emulator else "run by this machine"
    compiler = machine.build.compiler.split()[0]
    for function in machine.functions:
        if function.cases:
            claim = f"built by {compiler} -{machine.build.level} for {machine.build.target} it returns the same"
            yield _claim(function.function, claim, run, function.cases)


def _claim(
    function: str, claim: str, how: str, cases: int, bound: Fraction | None = None, unit: str = ""
) -> dict[str, Any]:
    exact = None if bound is None else str(bound)
    return {"function": function, "claim": claim, "how": how, "cases": cases, "bound": exact, "unit": unit}


def _key(claim: Mapping[str, Any]) -> tuple[str, str]:
    return claim["function"], claim["claim"]


def _told(claim: Mapping[str, Any]) -> str:
    return f"{claim['function']}: {claim['claim']}"
