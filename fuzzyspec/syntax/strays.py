# ruff: noqa: RUF001  (characters that look like ours are the point here)
"""What engineers write by habit of other languages or editors: what it probably means, and what to write."""

from __future__ import annotations

import re
import unicodedata
from typing import NamedTuple

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Span
from fuzzyspec.syntax import letters


class Stray(NamedTuple):
    """A text that is no token. ``means`` is the token taken in its place, or empty."""

    end: int
    message: str
    help: str | None
    means: str = ""


_MEANT = {
    "&&": "and", "||": "or", "!": "not", "&": "and", "|": "or",
    ":=": "=", "<>": "!=", "=<": "<=", "=>": ">=",
    "≤": "<=", "≥": ">=", "≠": "!=",
    "−": "-", "–": "-", "—": "-", "‐": "-", "‑": "-",
    "×": "*", "·": "*", "⋅": "*", "÷": "/", "∕": "/", "…": "..",
    "°": "deg", "℃": "degC", "″": "", "′": "",
}  # fmt: skip

COMBINED = re.compile(r"&&|\|\||:=|<>|=<|=>|//|/\*|\*\*")
"""Marks of other languages that begin with one of ours."""

_UNITS = {"µ": "u", "μ": "u", "Ω": "ohm", "℃": "degC", "²": "^2", "³": "^3"}
_QUOTES = "\"'`“”„‘’‚«»"
_POWER = re.compile(r"\^[ \t]*-?[0-9]*")
_SPACES = re.compile(r"[^\S\n]+")


BYTE = "\N{REPLACEMENT CHARACTER}"
"""Stands in a text where the file had a byte that is not UTF-8."""


def not_utf8(at: int) -> Diagnostic:
    """Tells of the first such byte."""
    where = Span(at, at + 1)
    help_ = "save it as UTF-8 in your editor"
    return Diagnostic("FZ130", "the file is not UTF-8", where, "the first byte that is not", help=help_)


def find(text: str, at: int, after_number: bool) -> Stray:
    """Says what the text at ``at``, which begins no token, may be."""
    if text.startswith("//", at):
        return Stray(_line_end(text, at), "`//` does not begin a comment", "a comment begins with `#`")
    if text.startswith("/*", at):
        close = text.find("*/", at + 2)
        end = _line_end(text, at) if close < 0 else close + 2
        return Stray(end, "`/*` does not begin a comment", "a comment begins with `#` and ends with its line")
    if text.startswith("**", at):
        return Stray(at + 2, "there is no `**`", "write a power as a product: `x * x`", "*")
    if space := _SPACES.match(text, at):
        return Stray(space.end(), f"a {_name(text[at])} between the words", "replace it by an ordinary space")
    if text[at] in _QUOTES:
        end = at + 1
        while end < len(text) and text[end] in _QUOTES:
            end += 1
        if any(c in _QUOTES for c in text[text.rfind("\n", 0, at) + 1 : at]):
            return Stray(end, "", None)
        return Stray(end, "quotation marks have no place here", "names and units are written without quotation marks")
    if text[at] == ";":
        return Stray(
            at + 1, "a semicolon has no place here", "statements need nothing between them; items of a list have commas"
        )
    if text.startswith("°C", at) and after_number:
        return Stray(at + 2, "`°C` is not spelt so", "write `degC`", "degC")
    for length in (2, 1):
        mark = text[at : at + length]
        if len(mark) == length and mark in _MEANT:
            means = _MEANT[mark]
            if means in ("deg", "degC") and not after_number:
                means = ""
            return Stray(at + length, f"`{mark}` is not spelt so", f"write `{_MEANT[mark]}`", means)
    if text[at] in "²³" and after_number is False:
        power = unicodedata.digit(text[at])
        return Stray(at + 1, f"a raised `{text[at]}`", f"write the power of a unit as `^{power}`")
    if text[at] == "%":
        return Stray(at + 1, "`%` without a number", "`%` is a unit (1/100), after a number or a range")
    if text[at] == "?":
        end = _line_end(text, at) if ":" in text[at : _line_end(text, at)] else at + 1
        return Stray(end, "there is no `? :`", "a choice reads `a if TEST else b`")
    if text[at] == "^":
        raised = _POWER.match(text, at)
        end = raised.end() if raised else at + 1
        return Stray(
            end,
            "there is no power operator `^`",
            "write a product: `x * x`; `^` stands in units: `m/s^2`",
        )
    if ours := letters.mark(text[at]):
        return Stray(at + 1, f"`{text[at]}` is not spelt so", f"write `{ours}`", ours)
    end = at + 1
    while end < len(text) and _unknown(text[end]):
        end += 1
    if end == at + 1:
        return Stray(end, *letters.told(text[at]))
    return Stray(end, f"unknown characters {_printable(text[at:end])}", "take them out")


def _unknown(char: str) -> bool:
    return not (char.isspace() or char.isascii() or char.isalnum() or char in _MEANT or char in _QUOTES)


def _line_end(text: str, at: int) -> int:
    end = text.find("\n", at)
    return len(text) if end < 0 else end


def _name(char: str) -> str:
    name = unicodedata.name(char, "")
    return name.lower() if name else f"character U+{ord(char):04X}"


def _printable(text: str) -> str:
    if len(text) > 8:
        return f"`{text[:6]}..`" if text[:6].isprintable() else ""
    return " ".join(f"`{c}`" if c.isprintable() else f"U+{ord(c):04X}" for c in text)


def mend_number(text: str, max_digits: int) -> tuple[str, str]:
    """For a number in a form that the language lacks: the digits to go on with, and what to write."""
    if re.match(r"0[xXbBoO]", text):
        value = str(int(text, 0)) if _fits_base(text) and len(text) <= max_digits else "1"
        return value, f"write it in decimal: `{value}`" if value != "1" else "write it in decimal"
    mantissa, mark, exponent = re.sub(r"[_']", "", text).lower().partition("e")
    if mark:
        value = _shifted(mantissa, exponent, max_digits)
        return (value, f"write it out: `{value}`") if value else ("1", "write it out without an exponent")
    if mantissa.count(".") > 1:
        return "1", "a number has one decimal point; a span of counts has two: `0..4095`"
    value = mantissa + "0" if mantissa.endswith(".") else mantissa
    value = "0" + value if value.startswith(".") else value
    return value, f"write `{value}`" if len(value) <= max_digits else "write digits only"


def _fits_base(text: str) -> bool:
    try:
        int(text, 0)
    except ValueError:
        return False
    return True


def _shifted(mantissa: str, exponent: str, max_digits: int) -> str:
    """``mantissa`` times ten to ``exponent``, written out; empty where that is too long."""
    if len(exponent) > 4 or len(mantissa) + abs(int(exponent)) > max_digits:
        return ""
    whole, _, part = mantissa.partition(".")
    point = len(whole) + int(exponent)
    digits = whole + part
    if point <= 0:
        digits, point = "0" * (1 - point) + digits, 1
    digits = digits.ljust(point, "0")
    whole, part = digits[:point].lstrip("0") or "0", digits[point:].rstrip("0")
    return f"{whole}.{part}" if part else whole


def plain_unit(text: str) -> str:
    """A unit in the letters that the language has."""
    plain = "".join(_UNITS.get(c, c) for c in text)
    return plain if plain.isascii() else "?"


def odd_unit(text: str, span: Span) -> Diagnostic:
    """Tells of a unit in letters that the language does not have."""
    plain = plain_unit(text)
    help_ = f"write `{plain}`" if plain != "?" else "units are written in letters a to z and A to Z, or `%`"
    return Diagnostic("FZ107", f"the unit `{text}` is not spelt so", span, help=help_)
