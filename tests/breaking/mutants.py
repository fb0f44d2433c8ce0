"""Sound specs with random damage: tokens dropped, doubled, swapped or replaced, and numbers changed."""

from __future__ import annotations

import random
import re
from pathlib import Path

from tests.random_specs.generator import spec

ROOT = Path(__file__).resolve().parents[2]
SOUND = [
    path.read_text(encoding="utf-8")
    for pattern in ("examples/*.fz", "benchmarks/*.fz", "tests/fixtures/ok_*.fz")
    for path in sorted(ROOT.glob(pattern))
]
_PIECE = re.compile(r"#[^\n]*|\d+(?:\.\d+)?|\w+|\s+|<=|>=|==|!=|\.\.|[^\w\s]")
_NUMBERS = [
    "0",
    "1",
    "2",
    "-1",
    "0.5",
    "1.2",
    "3",
    "7",
    "100",
    "255",
    "256",
    "65535",
    "65536",
    "1000000",
    "0.001",
    "1/3",
    "99999999999",
    "0.0000001",
    "999999999999999999",
    "0.000000000000000001",
    "1/999983",
]
_MARKS = ["{", "}", "(", ")", "[", "]", ",", ":", "/", "otherwise", "full", "not", "-", "in"]


def mutant(seed: int, numbers: float) -> str:
    """A damaged spec; ``numbers`` is the share of edits that only change a number."""
    r = random.Random(seed)
    text = r.choice(SOUND) if r.random() < 0.6 else spec(r.randrange(400))
    pieces = _PIECE.findall(text)
    for _ in range(r.choice((1, 1, 1, 2, 3))):
        words = [i for i, piece in enumerate(pieces) if piece.strip() and not piece.startswith("#")]
        digits = [i for i in words if pieces[i][0].isdigit()]
        if digits and r.random() < numbers:
            pieces[r.choice(digits)] = r.choice(_NUMBERS)
        else:
            _damage(r, pieces, words)
    return "".join(pieces)


def _damage(r: random.Random, pieces: list[str], words: list[int]) -> None:
    at, other = r.choice(words), r.choice(words)
    match r.randrange(5):
        case 0:
            pieces[at] = ""
        case 1:
            pieces[at] += " " + pieces[at]
        case 2:
            pieces[at], pieces[other] = pieces[other], pieces[at]
        case 3:
            pieces[at] = pieces[other]
        case _:
            pieces[at] = r.choice(_MARKS)
