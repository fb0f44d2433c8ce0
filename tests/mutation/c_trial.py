"""What ``fuzzyc verify --c FILE`` would say of a mutated file, without doing all of it anew for each.

Verify's batches, and what the integer program makes of them, are written down once, the sanitized part of each batch
apart, and the hashes of its bulk. A mutant is compiled as verify compiles, linked with the harness, and run over that.
"""

from __future__ import annotations

import struct
import subprocess
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from fuzzyspec.api import Spec
from fuzzyspec.emit.names import name_module
from fuzzyspec.lower import Options
from fuzzyspec.native import NativeModule
from fuzzyspec.native.layout import DTYPES, layout_of, out_types, pack
from fuzzyspec.native.toolchain import SANITIZERS
from fuzzyspec.native.workspace import HARNESS, PRODUCT, Workspace
from fuzzyspec.verify import DEFAULT_SEED
from fuzzyspec.verify.bench import BLOCK, SANITIZED
from fuzzyspec.verify.cases import DEFAULT_CASES, batches, bulk
from fuzzyspec.verify.subject import Arrays, Subject
from tests.mutation.c_mutants import Mutant, mutants

SECONDS = 5
"""For one batch. Verify waits longer, but for an endless loop in vain."""

Verdict = Literal["no C", "self-test", "case", "bulk", "death", "sanitizers", "same object", "survived"]
"""How a mutant ended: not compiled, found by which of verify's means, of the same machine code, or not found."""
FOUND: tuple[Verdict, ...] = ("self-test", "case", "bulk", "death", "sanitizers")
_CODES: Mapping[int, Verdict] = {0: "survived", 10: "self-test", 11: "case", 12: "bulk"}


@dataclass(frozen=True)
class Judged:
    """A mutant and its end."""

    mutant: Mutant
    verdict: Verdict


class Trial:
    """One spec's C, compiled with some options. ``close`` (or the end of ``with``) removes what was made."""

    def __init__(self, spec: Spec, options: Options, cases: int = DEFAULT_CASES) -> None:
        self.spec = spec
        self.subjects = spec._subjects
        self.cases = cases
        self.files = dict(spec.compile(options).files)
        program = spec.lowered.program
        self.name = f"{program.name}.c"
        self.source = self.files[self.name]
        self.workspace = Workspace(program, self.files)
        self.folder = self.workspace.path
        names = name_module(program)
        self.functions = {names.functions[f.name].function: i for i, f in enumerate(program.functions)}
        (self.folder / HARNESS / "judge.c").write_text((Path(__file__).parent / "judge.c").read_text())
        self._plain = self._others("plain", ())
        self._objects = {name: self._compiled(name, self.source) for name in ("gcc", "clang")}
        self._write_cases()

    def __enter__(self) -> Trial:
        return self

    def __exit__(self, *_: object) -> None:
        self.workspace.close()

    # --- one mutant -----------------------------------------------------------------------------

    @cached_property
    def mutants(self) -> list[Mutant]:
        """Every mutant of the C."""
        return mutants(self.source)

    def judged(self, mutant: Mutant) -> Judged:
        """A mutant and its end."""
        return Judged(mutant, self.verdict(mutant))

    def verdict(self, mutant: Mutant) -> Verdict:
        """How a mutant ends."""
        source = mutant.of(self.source)
        made = self._compiled("gcc", source)
        if made is None:
            return "no C"
        if made == self._objects["gcc"] and self._compiled("clang", source) == self._objects["clang"]:
            return "same object"
        self._link("mutant", [*self._plain, "gcc.o"], ())
        found = self._run("mutant", "cases.bin", mutant)
        if found != "survived":
            return found
        flags = SANITIZERS[0]
        if self._call("gcc", "-std=c99", "-O2", "-w", *flags, "-c", f"{PRODUCT}/mutant.c", "-o", "checked.o"):
            self._link("checked", [*self._checked, "checked.o"], flags)
            if self._run("checked", "thin.bin", mutant) != "survived":
                return "sanitizers"
        return "survived"

    def _run(self, program: str, cases: str, mutant: Mutant) -> Verdict:
        own = self.functions.get(mutant.function)
        order = range(len(self.functions)) if own is None else [own]
        done = subprocess.run(
            [f"./{program}", cases, str(SECONDS), *(str(i) for i in order)],
            cwd=self.folder,
            env={"ASAN_OPTIONS": "detect_leaks=0"},
            capture_output=True,
            check=False,
        )
        assert done.returncode != 3, "the judge was not given what it needs"
        return _CODES.get(done.returncode, "death")

    # --- builds ---------------------------------------------------------------------------------

    def _compiled(self, compiler: str, source: bytes) -> bytes | None:
        """The object that verify's flags give; None where there is none. The file's name is always the same."""
        (self.folder / PRODUCT / "mutant.c").write_bytes(source)
        target = f"{compiler}.o"
        made = self._call(compiler, "-std=c99", "-O2", "-w", "-c", f"{PRODUCT}/mutant.c", "-o", target)
        return (self.folder / target).read_bytes() if made else None

    @cached_property
    def _checked(self) -> list[str]:
        return self._others("checked", SANITIZERS[0])

    def _others(self, tag: str, flags: tuple[str, ...]) -> list[str]:
        """Objects of everything but the product's own file."""
        selftest = next(n for n in self.files if n.endswith("_selftest.c"))
        sources = [f"{PRODUCT}/{selftest}", *(f"{HARNESS}/{n}" for n in ("harness.c", "bulk.c", "judge.c"))]
        made = []
        for source in sources:
            target = f"{tag}_{Path(source).stem}.o"
            assert self._call("gcc", "-std=c99", "-O2", "-w", *flags, "-c", source, "-o", target), source
            made.append(target)
        return made

    def _link(self, target: str, objects: list[str], flags: tuple[str, ...]) -> None:
        assert self._call("gcc", *flags, "-o", target, *objects)

    def _call(self, *command: str) -> bool:
        return subprocess.run(command, cwd=self.folder, capture_output=True, check=False).returncode == 0

    # --- what is known ----------------------------------------------------------------------------

    def _write_cases(self) -> None:
        """``cases.bin``: everything; ``thin.bin``: what goes through the sanitizers."""
        program = self.spec.lowered.program
        with (self.folder / "cases.bin").open("wb") as whole, (self.folder / "thin.bin").open("wb") as thin:
            many = 0
            whole.write(struct.pack("=Q", many))
            thin.write(struct.pack("=Q", many))
            for index, subject in enumerate(self.subjects):
                for inputs, state, outs in _with_results(subject, self.cases):
                    step = max(1, len(outs[0]) // SANITIZED)
                    layout = layout_of(program, subject.function, name_module(program))
                    for file, every in ((whole, 1), (thin, step)):
                        kept = [{k: v[::every] for k, v in arrays.items()} for arrays in (inputs, state)]
                        packed = pack(layout, *kept)
                        wanted = [
                            np.ascontiguousarray(o[::every], dtype=DTYPES[t])
                            for o, t in zip(outs, out_types(layout), strict=True)
                        ]
                        words = [index, packed.n, len(packed.widths), len(packed.arrays), len(wanted), *packed.widths]
                        arrays = [*packed.arrays, *wanted]
                        words += [a.nbytes for a in arrays]
                        file.write(struct.pack(f"={len(words)}Q", *words))
                        for array in arrays:
                            file.write(array.tobytes() + bytes(-array.nbytes % 8))
                    many += 1
            with NativeModule(program, dict(self.spec.compile().files)) as reference:
                for subject in self.subjects:
                    blocks = range(bulk(subject, self.cases) // BLOCK)
                    hashes = reference.hashes(subject.name, DEFAULT_SEED, blocks, BLOCK)
                    whole.write(struct.pack(f"={3 + len(hashes)}Q", len(hashes), DEFAULT_SEED, BLOCK, *hashes))
                    thin.write(struct.pack("=3Q", 0, 0, 0))
            for file in (whole, thin):
                file.seek(0)
                file.write(struct.pack("=Q", many))


def _with_results(subject: Subject, cases: int) -> Iterator[tuple[Arrays, Arrays, list[npt.NDArray[np.int64]]]]:
    """Verify's batches of one function: inputs, states, and what the integer program returns, in the layout's order."""
    last: Arrays = {}
    for batch in batches(subject, DEFAULT_SEED, cases):
        state = last if batch.follow else batch.state
        run = subject.fixed(batch.inputs, state)
        last = run.state
        ports = [run.outputs[p.name] for p in subject.function.outputs]
        yield batch.inputs, state, [*ports, run.status, *(run.state[k] for k in subject.state)]
