"""Text into tokens: words, numbers and punctuation, and a diagnostic for what is none of these.

Whether a word is a keyword or a name is left to the parser, which knows what can stand there.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import NamedTuple

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source, Span
from fuzzyspec.syntax import letters, strays
from fuzzyspec.syntax.table import load

MAX_DIGITS = 40
"""Digits of one number."""
MAX_ODD = 50
"""Numbers and units written in no form of ours that are told of one by one."""
MAX_NAME = 200
"""Characters of one name that are kept; far more than the checker allows, and few enough for a message."""

END = "$END"
MISSING = "?"
"""The name of what recovery put in the place of a missing name; nothing is to be said about it."""


class Token(NamedTuple):
    """``kind`` is ``WORD``, ``NUMBER``, ``LABEL``, ``UNIT``, ``COMPARE``, the name of a mark, or ``$END``.

    ``first`` tells that it is the first token of its line, ``made`` that recovery put it in.
    """

    kind: str
    text: str
    start: int
    end: int
    first: bool = False
    made: bool = False

    @property
    def span(self) -> Span:
        return Span(self.start, self.end)


_SPACE = re.compile(r"[ \t\r\n\f]+|#[^\n]*")
_NUMBER = re.compile(r"[0-9]+(?:\.[0-9]+)?")
_ODD_NUMBER = re.compile(
    r"0[xXbBoO][0-9A-Fa-f]+\b"  # another base
    r"|(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)[eE][+-]?[0-9]+"  # an exponent
    r"|[0-9]+(?:[_'][0-9]+)+(?:\.[0-9]+)?"  # digit groups
    r"|[0-9]+(?:\.[0-9]+){2,}"
    r"|[0-9]+\.(?![.0-9])"
    r"|\.[0-9]+"
)
_FOREIGN_NUMBER = re.compile(r"\d+(?:\.\d+)?")
_COLON = re.compile(r"[ \t]*:(?!=)")
_FACTOR = r"(?:[A-Za-z_][A-Za-z0-9_]*|%)(?:\^-?[0-9]+)?"
UNIT = re.compile(rf"{_FACTOR}(?:[*/]{_FACTOR})*")
_LONG_POWER = re.compile(r"\^-?[0-9]{3,}")
_COMPARE = re.compile(r"<=|>=|==|!=|<|>")


def tokenize(source: Source) -> tuple[list[Token], list[Diagnostic]]:
    """Every token of a text, ``$END`` last, and what was wrong with it."""
    return _Scanner(source).run()


@dataclass
class _Scanner:
    source: Source

    def run(self) -> tuple[list[Token], list[Diagnostic]]:
        text = self.source.text
        table = load()
        marks = sorted((t for t in table.fixed if not t.isalpha()), key=len, reverse=True)
        self.marks = re.compile("|".join(re.escape(m) for m in marks))
        self.fixed = table.fixed
        self.keywords = table.keywords
        self.tokens: list[Token] = []
        self.found: list[Diagnostic] = []
        self.strays: dict[str, int] = {}
        self.first = True
        self.bytes = False
        self.odd = 0
        self.last_odd: Diagnostic | None = None
        at = 0
        while at < len(text):
            space = _SPACE.match(text, at)
            if space:
                at = space.end()
                self.first = self.first or "\n" in space.group()
                continue
            at = self._token(text, at)
        self._add(END, "", len(text), len(text))
        return self.tokens, self._counted()

    def _tell(self, odd: Diagnostic) -> None:
        """A number or unit in a form of its own; of many, the first ones."""
        self.odd += 1
        if self.odd <= MAX_ODD:
            self.found.append(odd)
            self.last_odd = odd

    def _tell_once(self, stray: Diagnostic) -> None:
        """A habit shows on every line; it is told of at the first."""
        count = self.strays.get(stray.message, 0)
        self.strays[stray.message] = count + 1
        if count == 0:
            self.found.append(stray)

    def _tell_of_byte(self, at: int) -> None:
        if not self.bytes:
            self.found.append(strays.not_utf8(at))
        self.bytes = True

    def _counted(self) -> list[Diagnostic]:
        return [replace(d, notes=(note,)) if (note := self._note(d)) else d for d in self.found]

    def _note(self, told: Diagnostic) -> str:
        if told is self.last_odd and self.odd > MAX_ODD:
            return f"{self.odd - MAX_ODD} more like these in this file"
        more = self.strays.get(told.message, 1) - 1
        return f"{more} more of these in this file" if more else ""

    def _add(self, kind: str, text: str, start: int, end: int) -> int:
        self.tokens.append(Token(kind, text, start, end, self.first))
        self.first = False
        return end

    def _token(self, text: str, at: int) -> int:
        """Takes one token at ``at``; returns where it ends."""
        char = text[at]
        if char.isdecimal():
            return self._number(text, at) if char.isascii() else self._foreign_number(text, at)
        if char == "." and (odd := _ODD_NUMBER.match(text, at)) and text[at - 1 : at] != ".":
            return self._odd_number(odd)
        if char.isidentifier() or char == "%":
            return self._word(text, at)
        if (compare := _COMPARE.match(text, at)) and not strays.COMBINED.match(text, at):
            return self._add("COMPARE", compare.group(), at, compare.end())
        if (mark := self.marks.match(text, at)) and not strays.COMBINED.match(text, at):
            return self._add(self.fixed[mark.group()], mark.group(), at, mark.end())
        return self._stray(text, at)

    def _number(self, text: str, at: int) -> int:
        if odd := _ODD_NUMBER.match(text, at):
            return self._odd_number(odd)
        number = _NUMBER.match(text, at)
        assert number is not None
        return self._bounded_number(number.group(), at, number.end())

    def _foreign_number(self, text: str, at: int) -> int:
        """A number in digits of another script."""
        odd = _FOREIGN_NUMBER.match(text, at)
        assert odd is not None
        digits = letters.digits(odd.group())
        help_ = f"write `{_shown(digits)}`"
        self._tell(Diagnostic("FZ108", "digits of another script", Span(*odd.span()), help=help_))
        return self._bounded_number(digits, at, odd.end())

    def _odd_number(self, odd: re.Match[str]) -> int:
        digits, help_ = strays.mend_number(odd.group(), MAX_DIGITS)
        self._tell(
            Diagnostic(
                "FZ108", f"`{_shown(odd.group())}` is not how a number is written", Span(*odd.span()), help=help_
            )
        )
        return self._bounded_number(digits, odd.start(), odd.end())

    def _bounded_number(self, digits: str, start: int, end: int) -> int:
        if len(digits) > MAX_DIGITS:
            self._tell(
                Diagnostic(
                    "FZ122",
                    f"a number of {len(digits)} digits",
                    Span(start, end),
                    f"more than {MAX_DIGITS} digits",
                    help="a number has at most 40 digits; no raw type can tell more than five apart",
                )
            )
            digits = "1"
        return self._add("NUMBER", digits, start, end)

    def _word(self, text: str, at: int) -> int:
        after_number = bool(self.tokens) and self.tokens[-1].kind in ("NUMBER", "RSQB")
        word = letters.WORD.match(text, at)
        if after_number and (word is None or word.group() not in self.keywords):
            return self._unit(text, at)
        if word is None:
            return self._stray(text, at)
        name, end = word.group(), word.end()
        if not name.isascii():
            byte = name.find(strays.BYTE)
            if byte < 0:
                self._tell_once(_odd_name(name, Span(at, end)))
            else:
                self._tell_of_byte(at + byte)
            name = letters.plain(name)
        name = name[:MAX_NAME]
        colon = _COLON.match(text, end)
        if colon:
            return self._add("LABEL", name, at, colon.end())
        return self._add("WORD", name, at, end)

    def _unit(self, text: str, at: int) -> int:
        unit = UNIT.match(text, at)
        word = letters.WORD.match(text, at)
        if word is not None and (unit is None or word.end() > unit.end()):
            span = Span(at, word.end())
            self._tell(strays.odd_unit(word.group(), span))
            return self._add("UNIT", strays.plain_unit(word.group()), at, word.end())
        assert unit is not None
        factors = unit.group()
        if _LONG_POWER.search(factors):
            told = Diagnostic(
                "FZ108", "a power of more than two digits", Span(*unit.span()), help="write a unit such as `m/s^2`"
            )
            self._tell(told)
            factors = _LONG_POWER.sub("", factors)
        return self._add("UNIT", factors, at, unit.end())

    def _stray(self, text: str, at: int) -> int:
        if text[at] == strays.BYTE:
            self._tell_of_byte(at)
            return at + 1
        after_number = bool(self.tokens) and self.tokens[-1].kind in ("NUMBER", "RSQB")
        stray = strays.find(text, at, after_number)
        if stray.message:
            self._tell_once(Diagnostic("FZ107", stray.message, Span(at, stray.end), help=stray.help))
        if stray.means:
            if stray.means in self.fixed:
                kind = "WORD" if stray.means.isalpha() else self.fixed[stray.means]
            else:
                kind = "COMPARE" if _COMPARE.fullmatch(stray.means) else "UNIT"
            self._add(kind, stray.means, at, stray.end)
        return stray.end


def unit_behind(tokens: list[Token], at: int, text: str) -> None:
    """Reads the words at ``at`` as a unit, in place: what stands behind a bracket that turned out to close a range."""
    if at >= len(tokens) or tokens[at].kind != "WORD" or tokens[at].text in load().keywords:
        return
    unit = UNIT.match(text, tokens[at].start)
    if unit is not None:
        last = at
        while tokens[last].end < unit.end():
            last += 1
        tokens[at : last + 1] = [tokens[at]._replace(kind="UNIT", text=unit.group(), end=unit.end())]


def _odd_name(name: str, span: Span) -> Diagnostic:
    if hidden := letters.invisible(name):
        message = f"`{_shown(name)}` holds an invisible character"
        return Diagnostic("FZ115", message, span, help=f"delete U+{ord(hidden):04X}, or type the name again")
    write = f"write `{_shown(letters.plain(name))}`; " if letters.guessed(name) else ""
    return Diagnostic(
        "FZ115",
        f"`{_shown(name)}` holds letters that a name cannot have",
        span,
        help=f"{write}names become C names: letters a to z and A to Z, digits and `_`",
    )


def _shown(text: str, limit: int = 24) -> str:
    """A text cut to a length that fits a message."""
    return text if len(text) <= limit else text[: limit - 2] + ".."
