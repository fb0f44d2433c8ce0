# ruff: noqa: RUF001  (letters that look like ours are the point here)
"""Letters and digits beyond ASCII: what a name or number that is written in them becomes."""

from __future__ import annotations

import re
import unicodedata

_INVISIBLE = "\u00ad\u200b-\u200d\u2060-\u2064\ufeff"
WORD = re.compile(rf"[^\W\d][\w\u0300-\u036f\ufffd{_INVISIBLE}]*")
"""A word, with the accents and invisible characters that an editor may have put inside."""

_SPELT = {
    "ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ß": "ss", "æ": "ae", "Æ": "Ae", "ø": "oe",
    "Ø": "Oe", "œ": "oe", "Œ": "Oe", "ł": "l", "Ł": "L", "đ": "d", "Đ": "D", "ı": "i", "ð": "d", "þ": "th",
}  # fmt: skip
_ALIKE = str.maketrans("аеорсухіјѕԁАВЕКМНОРСТХІЈЅΑΒΕΖΗΙΚΜΝΟΡΤΥΧο", "aeopcyxijsdABEKMHOPCTXIJSABEZHIKMNOPTYXo")
"""Cyrillic and Greek letters that look like ours."""

_GREEK = re.compile(r"GREEK (SMALL|CAPITAL) LETTER (?:FINAL )?([A-Z]+)(?: WITH .*)?")


def invisible(name: str) -> str:
    """The first character of a name that cannot be seen, or empty."""
    return next((c for c in name if unicodedata.category(c) == "Cf"), "")


def plain(name: str) -> str:
    """A name in ASCII, to go on with and to propose: ``groesse``, ``theta``; ``x`` for what cannot be guessed."""
    return "".join(_plain(c) for c in unicodedata.normalize("NFC", name))


def guessed(name: str) -> bool:
    """Whether every letter of a name has a spelling in ASCII."""
    return all(_plain(c) != "x" or c in "xх" for c in unicodedata.normalize("NFC", name))


def _plain(char: str) -> str:
    char = char.translate(_ALIKE)
    if char.isascii():
        return char
    if char in _SPELT:
        return _SPELT[char]
    if greek := _GREEK.fullmatch(unicodedata.name(char, "")):
        letter = {"LAMDA": "lambda"}.get(greek[2], greek[2].lower())
        return letter if greek[1] == "SMALL" else letter.capitalize()
    parts = unicodedata.normalize("NFKD", char)
    kept = "".join(c for c in parts if c.isascii() and (c.isalnum() or c == "_"))
    return kept if kept or unicodedata.category(char)[0] in "MC" else "x"


def digits(text: str) -> str:
    """Decimal digits of any script as ours."""
    return "".join(str(unicodedata.decimal(c)) if c.isdecimal() else c for c in text)


def mark(char: str) -> str:
    """The mark of ours that a full-width one stands for, or empty."""
    ours = unicodedata.normalize("NFKC", char)
    return ours if not char.isascii() and len(ours) == 1 and ours in "()[]{},:=+-*/<>%." else ""


def told(char: str) -> tuple[str, str | None]:
    """What to call a character that has no place in a spec, and what to do about it."""
    if unicodedata.category(char) in ("Cf", "Cc", "Mn", "Co", "Cn"):
        return f"an invisible character U+{ord(char):04X}", "delete it"
    ours = unicodedata.normalize("NFKC", char).replace("\N{FRACTION SLASH}", "/")
    return f"an unknown character `{char}`", f"write `{ours}`" if ours != char and ours.isascii() else "take it out"
