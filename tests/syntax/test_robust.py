"""No text whatever makes the parser raise, hang or tell nonsense."""

from __future__ import annotations

import re
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzyspec.check import check
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source
from fuzzyspec.diagnostics.render import render
from fuzzyspec.syntax import limits, parse, source_from_bytes
from tests.breaking.oracle import checked
from tests.syntax.specs import EVERYTHING, SOUND

TEXTS = [EVERYTHING, *(p.read_text(encoding="utf-8") for p in SOUND)]
PIECES = [re.findall(r"\w+|\s+|[^\w\s]", text) for text in TEXTS]
SOUP = sorted({piece for pieces in PIECES for piece in pieces if not piece.isspace()})


def found(text: str) -> tuple[Diagnostic, ...]:
    """Parses, checks and renders a text, and holds what is told to the rules that every diagnostic keeps."""
    _, told = checked(Source("spec.fz", text))
    syntax = tuple(d for d in told if d.code.startswith("FZ1"))
    for d in syntax:
        said = re.sub(r"`[^`]*`|U\+\w+", "", d.message)
        assert not re.search(r"[A-Z]{2}|__|None|Token", said.replace("UTF", "").replace("NUL", "")), d.message
    return syntax


@given(st.text())
@settings(max_examples=300)
def test_any_text(text: str) -> None:
    """Random characters end in diagnostics: none is a spec."""
    assert any(d.severity == "error" for d in found(text))


@given(st.binary())
def test_any_bytes(data: bytes) -> None:
    """Random bytes become a text, or are told of."""
    source, told = source_from_bytes("spec.fz", data)
    assert "\r" not in source.text and "\0" not in source.text
    try:
        plain = data.decode("utf-8").isprintable()
    except UnicodeDecodeError:
        plain = False
    assert not (plain and told)
    found(source.text)


@given(st.lists(st.sampled_from(SOUP), max_size=60))
@settings(max_examples=400)
def test_any_tokens(pieces: list[str]) -> None:
    """Words and marks of the language in any order."""
    found("module soup\n" + " ".join(pieces))


@given(st.data())
@settings(max_examples=400)
def test_any_change_of_a_sound_spec(data: st.DataObject) -> None:
    """Sound specs with pieces left out, doubled, swapped or put in are read to their end."""
    pieces = list(data.draw(st.sampled_from(PIECES)))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(pieces) - 1))
        match data.draw(st.sampled_from(["drop", "double", "swap", "insert", "cut"])):
            case "drop":
                del pieces[at : at + data.draw(st.integers(1, 4))]
            case "double":
                pieces[at:at] = pieces[at : at + 3]
            case "swap":
                other = data.draw(st.integers(0, len(pieces) - 1))
                pieces[at], pieces[other] = pieces[other], pieces[at]
            case "insert":
                pieces.insert(at, data.draw(st.sampled_from(SOUP)))
            case "cut":
                pieces[at + 1 :] = []
        pieces = pieces or ["x"]
    found("".join(pieces))


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("(" * 100_000, "FZ121"),
        ("module m system s { let x = " + "(" * 33 + "1" + ")" * 33 + "}", "FZ121"),
        ("module m system s { let x = " + "-" * 5_000 + "1 }", "FZ121"),
        ("module m system s { let x = " + "not " * 5_000 + "a }", "FZ121"),
        ("module m system s { let x = " + "a + " * 5_000 + "a }", "FZ121"),
        ("module m system s { let x = " + "a if b else " * 5_000 + "c }", "FZ121"),
        ("module m system s { let x = " + "a otherwise " * 5_000 + "c }", "FZ121"),
        ("module m controller c { rules { if " + "not " * 5_000 + "a is A then b is B } }", "FZ121"),
        ("module m param x = " + "9" * 100_000, "FZ122"),
        ("module m param x = 1." + "9" * 5_000, "FZ122"),
        ("module m param x = 1e999999999", "FZ108"),
        ("module m param x = 0x" + "f" * 100_000, "FZ108"),
        ("module m param x = 1 m^99999999999", "FZ108"),
        ("module " + "m" * 100_000, "FZ213"),
        ("e{*", "FZ101"),
        ("module m\n" + "}\n" * 10_000, "FZ106"),
        ("module m\n" + '"' * 100_000, "FZ107"),
        ("# " + "x" * limits.MAX_CHARACTERS, "FZ120"),
    ],
    ids=lambda v: v[:40] if isinstance(v, str) else None,
)
def test_extremes_are_told_of(text: str, code: str) -> None:
    """Deep nesting, long chains, endless numbers and names, and large files end in a diagnostic."""
    source = Source("spec.fz", text)
    module, told = parse(source)
    _, more = check(module, source, told)
    assert code in {d.code for d in (*told, *more)}
    assert max(len(line) for line in render((*told, *more), source).splitlines()) < 400


def test_a_large_file_is_read_in_little_time() -> None:
    """A long sound text takes seconds: no step is worse than linear in the number of items."""
    rules = "        if a is A then b is B\n" * 12_000
    text = f"module m\ncontroller c {{\n    rules {{\n{rules}    }}\n}}\n"
    begin = time.process_time()
    module, told = parse(Source("spec.fz", text))
    assert told == () and len(module.items) == 1
    assert time.process_time() - begin < 30


def test_columns_are_counted_in_characters() -> None:
    """Byte order marks, carriage returns and tabs shift no position."""
    plain, _ = source_from_bytes("a.fz", b"module m\nparam\tx = $ 1\n")
    odd, told = source_from_bytes("a.fz", b"\xef\xbb\xbfmodule m\r\nparam\tx = $ 1\r\n")
    assert told == () and odd.text == plain.text
    (stray,) = parse(odd)[1]
    assert odd.position(stray.span.start) == (2, 11)
