"""Bytes of a file to a source text."""

from __future__ import annotations

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source, Span
from fuzzyspec.syntax import strays


def source_from_bytes(name: str, data: bytes) -> tuple[Source, tuple[Diagnostic, ...]]:
    """The text of a file under the name it is reported by, and what was wrong with its encoding.

    A byte order mark is dropped and lines end in ``\\n``, so that the same spec is the same text from any editor. Bytes
    that are no UTF-8 become replacement characters, NUL bytes become spaces, and each is told of once.
    """
    data = data.removeprefix(b"\xef\xbb\xbf")
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        wide = data.decode("utf-16", errors="replace").replace("\r\n", "\n").replace("\r", "\n").replace("\0", " ")
        return Source(name, wide), (Diagnostic("FZ130", "the file is UTF-16", Span(0, 0), help="save it as UTF-8"),)
    text = data.decode("utf-8", errors="replace").replace("\r\n", "\n").replace("\r", "\n")
    valid = _is_utf8(data)
    found: list[Diagnostic] = []
    if not valid:
        found.append(strays.not_utf8(text.find(strays.BYTE)))
    if "\0" in text:
        at = text.find("\0")
        found.append(
            Diagnostic(
                "FZ131",
                "the file holds NUL bytes",
                Span(at, at + 1),
                "the first one",
                help="is this a text file? fuzzyc reads specs as plain text",
            )
        )
    return Source(name, text.replace("\0", " ") if "\0" in text else text), tuple(found)


def _is_utf8(data: bytes) -> bool:
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True
