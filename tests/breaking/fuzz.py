"""Coverage-guided fuzzing of parser and checker: libFuzzer, through atheris, over the bytecode of both.

    python -m tests.breaking.fuzz --runs 1000000 --seed 1

Starts from the examples, the workloads, the fixtures and some random specs. An input at which something is raised, an
invariant of ``oracle.checked`` does not hold, or nothing is answered in time is left under ``out/``. The same seed
tries the same inputs.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import random
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from tests.random_specs.generator import spec

ROOT = Path(__file__).resolve().parents[2]
SOUND = (
    "examples/*.fz",
    "benchmarks/*.fz",
    "tests/regressions/*.fz",
    "tests/fixtures/*.fz",
    "tests/fixtures/slips/*.fz",
)
PIECE = re.compile(rb"#[^\n]*|\d+(?:\.\d+)?|\w+|\s+|<=|>=|==|!=|\.\.|[^\w\s]")
DECLARATION = re.compile(r"^(?=(?:controller|system|param|unit)\b)", re.MULTILINE)
LONG = 8192
"""Bytes of an input at most, in the last of a job's processes."""
SHORT = (160, 160, 320)
"""In the others, by turns: in what is read quickly there are as many ways to go wrong."""
TINY = (
    "controller c{input x in[0,1]{partition A B}output y in[0,1]{partition C D}table y by x{A:C B:D}}",
    "controller c{input x,z in[0,1]{partition A B}output y in[0,1]{singletons C D}table y by x,z{A B A:C D B:D C}}",
    "controller c{input x in[0,1]raw int8{partition A at 0,B at 1}output y in[0,1]{partition C D full}"
    "rules{if x is A or not x is B then y is C with 0.5}}",
    "controller c{input x in[0,9]m{partition A B}output y in[0,1]{partition C D otherwise hold initial 0}"
    "behavior P priority 1{if x is A then y is C}}",
    "controller c{input x in[0,9]raw uint8 9..0{term A=points((0,1),(9,0))term B=ramp_up(1,9)}"
    "output y in[0,1]{partition C D otherwise 0}fires at 1/9 rules{if x in{A}then y is C}}",
    "system s{input x in[0,1]output y=x if x>1/2 else 0}",
    "system s{input x in[0,1]m input l[3]{a in[0,1]m}for each o in l{let o.b=o.a*2}"
    "output y=max(o.b for o in l if o.a<x,otherwise 0)}",
    "unit u=2 m param p=3 u system s{input x in[-1,1]m output y in[0,1]raw int8=x/abs(x)otherwise p/p}",
    "system s{input x in[0,1]input l[2]{a in[0,1]}let a=clamp(x,0,1)output y=min(a,x)-count(o for o in l)"
    "budget{ram<=0 B}}",
)


def small(text: str) -> bytes:
    """A declaration as a file of its own."""
    return f"module m {' '.join(text.split())}".encode()


RANDOM = 60
"""Random specs among what is mutated."""
CHUNK = 50_000
"""Inputs of one process."""
SECONDS = 120
"""In which any input must be answered, on however slow a machine, instrumented."""
TURNING = ("fuzzyspec.syntax.machine", "fuzzyspec.syntax.table")
"""Inner loops that turn alike whatever the text: to count them tells nothing, and takes most of the time."""


@dataclass(frozen=True)
class Chunk:
    """What one process tries."""

    runs: int
    seed: int
    longest: int


def sound_texts() -> list[bytes]:
    """What mutation starts from: whole specs, and single declarations on one line."""
    texts = [path.read_bytes() for pattern in SOUND for path in sorted(ROOT.glob(pattern))]
    texts += [spec(seed).encode() for seed in range(RANDOM)]
    bare = (re.sub(r"#[^\n]*", "", text.decode("utf-8", errors="replace")) for text in texts)
    parts = {small(part) for text in bare for part in DECLARATION.split(text)}
    return sorted({*texts, *parts, *map(small, TINY)})


def pieces_of(text: bytes) -> list[bytes]:
    """Words, marks and what is between them."""
    return PIECE.findall(text)


def dictionary(texts: list[bytes]) -> str:
    """All words and marks of the texts, as libFuzzer reads them."""
    soup = {p for text in texts for p in pieces_of(text) if p.strip() and not p.startswith(b"#") and len(p) < 40}
    quoted = ("".join(chr(b) if b < 128 and chr(b).isalnum() else f"\\x{b:02x}" for b in word) for word in sorted(soup))
    return "".join(f'"{word}"\n' for word in quoted)


def recombined(data: bytes, other: bytes, dice: random.Random) -> bytes:
    """Some tokens of a text dropped, doubled, moved, or replaced by a stretch of another text."""
    pieces, theirs = pieces_of(data), pieces_of(other)
    if not pieces or not theirs:
        return data
    for _ in range(dice.choice((1, 1, 2, 4))):
        at, length = dice.randrange(len(pieces) + 1), dice.choice((1, 1, 2, 3, 8, 30))
        start = dice.randrange(len(theirs))
        match dice.randrange(4):
            case 0:
                del pieces[at : at + length]
            case 1:
                pieces[at:at] = pieces[at : at + length]
            case 2:
                pieces[at : at + length] = theirs[start : start + length]
            case _:
                pieces[at:at] = theirs[start : start + length]
    return b"".join(pieces)


def fuzz(chunk: Chunk, folder: Path) -> None:
    """Try the inputs, and add what reached new code to the folder's corpus.

    Does not return: libFuzzer ends the process, with status 0 where nothing was found.
    """
    import atheris

    with atheris.instrument_imports(include=["fuzzyspec.syntax", "fuzzyspec.check"], exclude=list(TURNING)):
        from fuzzyspec.syntax import source_from_bytes
        from tests.breaking.oracle import checked

    start = folder / f"start{chunk.longest}"
    texts = [path.read_bytes() for path in sorted((folder / f"start{LONG}").iterdir())]

    def one(data: bytes) -> None:
        checked(source_from_bytes("fuzz.fz", data)[0])

    def mutated(data: bytes, longest: int, number: int) -> bytes:
        dice = random.Random(number)
        if dice.random() < 0.5:
            return bytes(atheris.Mutate(data, longest))
        return recombined(data, dice.choice(texts), dice)[:longest]

    options = {
        "runs": chunk.runs,
        "seed": chunk.seed,
        "max_len": chunk.longest,
        "timeout": SECONDS,
        "rss_limit_mb": 4096,
        "dict": folder / "words",
        "artifact_prefix": f"{ROOT / 'out'}/fuzz-",
    }
    folders = [str(folder / "grown"), str(start)]
    atheris.Setup([sys.argv[0], *(f"-{k}={v}" for k, v in options.items()), *folders], one, custom_mutator=mutated)
    atheris.Fuzz()


def prepared(folder: Path) -> None:
    """Write what mutation starts from."""
    texts = sound_texts()
    for name in ("grown", *(f"start{longest}" for longest in {*SHORT, LONG})):
        (folder / name).mkdir(parents=True)
    for number, text in enumerate(texts):
        for longest in {*SHORT, LONG}:
            if len(text) <= longest:
                (folder / f"start{longest}" / f"{number:04}.fz").write_bytes(text)
    (folder / "words").write_text(dictionary(texts), encoding="ascii")


def chunks(runs: int, seed: int) -> Iterator[Chunk]:
    """The processes of a job, one after the other; the last takes long inputs, a twentieth of all."""
    few = runs // 20
    starts = range(0, runs - few, CHUNK)
    for turn, at in enumerate(starts):
        yield Chunk(min(CHUNK, runs - few - at), seed + turn, SHORT[turn % len(SHORT)])
    yield Chunk(few, seed + len(starts), LONG)


def job(runs: int, seed: int) -> bool:
    """One process after the other, up to the first that finds something; whether none did."""
    with tempfile.TemporaryDirectory(prefix="fuzzyc-") as name:
        prepared(Path(name) / "corpus")
        for chunk in chunks(runs, seed):
            words = [str(chunk.runs), str(chunk.seed), str(chunk.longest), f"{name}/corpus"]
            command = [sys.executable, "-m", "tests.breaking.fuzz", "--chunk", *words]
            done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
            said = done.stdout.decode(errors="replace")
            found = "nothing found" if done.returncode == 0 else f"FOUND\n{said[-6000:]}"
            covered = (re.findall(r" cov: (\d+)", said) or ["?"])[-1]
            print(f"seed {chunk.seed}: {chunk.runs} inputs of {chunk.longest} B, {covered} edges: {found}", flush=True)
            if done.returncode != 0:
                return False
    return True


def main() -> int:
    """Read the command line; 1 where something was found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=1_000_000, help="inputs to try (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="the first; each process takes the next (default: 1)")
    parser.add_argument("--jobs", type=int, default=1, help="processes at a time (default: %(default)s)")
    parser.add_argument("--chunk", nargs=4, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    (ROOT / "out").mkdir(exist_ok=True)
    if chosen.chunk:
        runs, seed, longest, folder = chosen.chunk
        fuzz(Chunk(int(runs), int(seed), int(longest)), Path(folder))
    if importlib.util.find_spec("atheris") is None:
        print("not fuzzed: the package atheris is not installed (there are builds of it for Linux)")
        return int(os.environ.get("FUZZYC_TOOLS") == "required")
    seeds = [chosen.seed + 1000 * i for i in range(chosen.jobs)]
    with ThreadPoolExecutor(chosen.jobs) as pool:
        sound = list(pool.map(lambda seed: job(chosen.runs // chosen.jobs, seed), seeds))
    return 0 if all(sound) else 1


if __name__ == "__main__":
    sys.exit(main())
