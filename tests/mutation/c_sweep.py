"""Mutants that are shown to compute the same by trying every input: those of a function with at most 2^32 of them.

Original and mutant are linked into one program, the mutant so that it stops where it does what C leaves undefined.
"""

from __future__ import annotations

import math
import os
import subprocess
from pathlib import Path

from fuzzyspec.emit.names import FunctionNames, name_module
from fuzzyspec.native.workspace import PRODUCT
from fuzzyspec.verify.draw import c_limits
from fuzzyspec.verify.exhaust import LIMIT
from fuzzyspec.verify.subject import Subject
from tests.mutation.c_mutants import Mutant
from tests.mutation.c_trial import Trial

UNDEFINED = ("-fsanitize=undefined", "-fsanitize-undefined-trap-on-error")


def swept_equal(trial: Trial, mutant: Mutant) -> bool:
    """Whether every input of the changed function was tried, on all processors, and none came out otherwise.

    For a changed helper or table it takes every input of every function. One that keeps a state or takes lists is not
    swept.
    """
    at = trial.functions.get(mutant.function)
    swept = range(len(trial.subjects)) if at is None else [at]
    return all(sweepable(trial.subjects[k]) for k in swept) and all(_agree(trial, mutant, k) for k in swept)


def _agree(trial: Trial, mutant: Mutant, at: int) -> bool:
    folder = trial.folder / "sweep"
    folder.mkdir(exist_ok=True)
    program = trial.spec.lowered.program
    names = name_module(program)
    public = [n for f in names.functions.values() for n in (f.function, f.init) if n]
    renamed = [f"-D{n}=mutant_{n}" for n in public]
    own = names.functions[program.functions[at].name]
    (folder / "mutant.c").write_bytes(mutant.of(trial.source))
    (folder / "original.c").write_bytes(trial.source)
    (folder / "sweep.c").write_text(_main(trial.subjects[at], own, names.status_t))
    product = trial.folder / PRODUCT
    _built(product, folder / "mutant.c", *renamed, *UNDEFINED)
    _built(product, folder / "original.c")
    _built(product, folder / "sweep.c", f'-DHEADER="{names.header}"')
    objects = [str(folder / f"{n}.o") for n in ("mutant", "original", "sweep")]
    subprocess.run(["gcc", "-o", str(folder / "sweep"), *objects], check=True, capture_output=True)
    parts = os.cpu_count() or 1
    # Each takes every so many-th value of the first input.
    running = [subprocess.Popen([str(folder / "sweep"), str(k), str(parts)]) for k in range(parts)]
    return [r.wait() for r in running] == [0] * parts


def sweepable(subject: Subject) -> bool:
    """Whether a function has at most 2^32 inputs, and nothing but these."""
    spans = [high - low + 1 for low, high in (c_limits(p) for p in subject.ports.values())]
    return bool(spans) and not subject.lists and not subject.state and math.prod(spans) <= LIMIT


def _built(include: Path, source: Path, *flags: str) -> None:
    command = ["gcc", "-std=c99", "-O2", "-w", "-I", str(include), *flags, "-c", str(source)]
    subprocess.run([*command, "-o", str(source.with_suffix(".o"))], check=True, capture_output=True)


def _main(subject: Subject, c: FunctionNames, status_t: str) -> str:
    """The sweep's C: 0 where all outputs and the status agree for every input, 1 where any does not."""
    opened = []
    for at, (key, port) in enumerate(subject.ports.items()):
        low, high = c_limits(port)
        begin, step = (f"{low} + first", "parts") if at == 0 else (str(low), "1")
        opened.append(f"for (long i{at} = {begin}; i{at} <= {high}; i{at} += {step}) {{ in.{c.inputs[key]} = i{at};")
    outs = [c.outputs[p.name] for p in subject.function.outputs]
    lines = [
        "#include <stdlib.h>",
        "#include HEADER",
        f"{status_t} mutant_{c.function}(const {c.input_t} *in, {c.output_t} *out);",
        "int main(int argc, char **argv)",
        "{",
        f"const long first = atol(argv[1]), parts = atol(argv[2]); {c.input_t} in; {c.output_t} one, other;",
        *opened,
        f"const {status_t} status = {c.function}(&in, &one);",
        # What the mutant leaves unwritten must not look right.
        *(f"other.{o} = ~one.{o};" for o in outs),
        f"if (mutant_{c.function}(&in, &other) != status) return 1;",
        *(f"if (other.{o} != one.{o}) return 1;" for o in outs),
        "}" * len(opened),
        "return argc != 3;",
        "}",
    ]
    return "\n".join(lines)
