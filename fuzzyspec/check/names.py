"""Declared names: duplicates, and what C and the language reserve."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from fuzzyspec.check.findings import Report
from fuzzyspec.diagnostics.diagnostic import Diagnostic, Label, Span
from fuzzyspec.syntax import tree

LONGEST = 40
"""Characters in a name: with prefix and suffix it stays within the 63 that C99 promises to tell apart."""

_C = """
    auto break case char const continue default do double else enum extern float for goto if inline int long register
    restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
"""
_CPP = """
    alignas alignof and and_eq asm bitand bitor bool catch char16_t char32_t class compl constexpr const_cast decltype
    delete dynamic_cast explicit export false friend mutable namespace new noexcept not not_eq nullptr operator or or_eq
    private protected public reinterpret_cast static_assert static_cast template this thread_local throw true try typeid
    typename using virtual wchar_t xor xor_eq
"""
_HEADERS = """
    assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg stdatomic
    stdbool stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar wctype
"""
C_HEADERS = frozenset(_HEADERS.split())
C_KEYWORDS = frozenset(_C.split())
CPP_KEYWORDS = frozenset(_CPP.split())
_STDINT = re.compile(r"u?int(_least|_fast)?\d+_t|u?int(max|ptr)_t")


def report_duplicate(what: str, name: tree.Name, first: Span, report: Report, exactly: str | None = None) -> None:
    """Two declarations of one name, both shown. ``exactly`` is the first spelling where only the case differs."""
    if exactly is None or exactly == name.text:
        report(
            Diagnostic(
                "FZ210",
                f"{what} `{name.text}` is declared twice",
                name.span,
                label="declared again here",
                labels=(Label(first, "first declared here"),),
                help="rename one of them",
            )
        )
        return
    report(
        Diagnostic(
            "FZ212",
            f"`{exactly}` and `{name.text}` differ only in case",
            name.span,
            label=f"its macros in C would be those of `{exactly}`",
            labels=(Label(first, f"`{exactly}` is declared here"),),
            help="rename one of them",
        )
    )


def too_early(what: str, text: str, used: Span, defined: Span) -> Diagnostic:
    """A use that stands above the definition."""
    return Diagnostic(
        "FZ241",
        f"{what} `{text}` is used before it is defined",
        used,
        label="used here",
        labels=(Label(defined, "defined here"),),
        help="move its definition up",
    )


class Names:
    """Names declared so far in one namespace; ``cased`` where names that differ only in case may stand together."""

    def __init__(self, report: Report, cased: bool = False) -> None:
        self._report = report
        self._cased = cased
        self._known: dict[str, tree.Name] = {}

    def declare(self, what: str, name: tree.Name) -> bool:
        """Whether the name is new; reports it where it is not."""
        key = name.text if self._cased else name.text.lower()
        first = self._known.get(key)
        if first is not None:
            report_duplicate(what, name, first.span, self._report, first.text)
            return False
        self._known[key] = name
        return True


def check_identifier(what: str, name: tree.Name, report: Report, field: bool = True) -> None:
    """A name that becomes part of C: ``field`` where it stands alone there, as a member of a struct."""
    text = name.text
    if len(text) > LONGEST:
        report(
            Diagnostic(
                "FZ213",
                f"the name of this {what} is too long",
                name.span,
                label=f"{len(text)} characters, {LONGEST} is the most",
                help="choose a shorter name",
            )
        )
    reason = None
    if text[:1].isdigit() or not re.fullmatch(r"\w+", text, re.ASCII):
        reason = "is no identifier in C"
    elif text.startswith("_") or "__" in text:
        reason = "is reserved in C and C++: no underscore at the start, no two in a row"
    elif field and text in C_KEYWORDS:
        reason = "is a keyword of C"
    elif field and text in CPP_KEYWORDS:
        reason = "is a keyword of C++, which must be able to read the header too"
    elif field and _STDINT.fullmatch(text):
        reason = "is a type of <stdint.h>"
    if reason is not None:
        report(
            Diagnostic(
                "FZ211",
                f"`{text}` cannot be the name of this {what}",
                name.span,
                label=reason,
                help="choose another name",
            )
        )


def check_header(name: tree.Name, report: Report) -> None:
    """A module's name becomes its header's, which must not stand before one of C's own."""
    if name.text.lower() in C_HEADERS:
        report(
            Diagnostic(
                "FZ211",
                f"`{name.text}` cannot be the name of a module",
                name.span,
                label=f"its header would be taken for <{name.text.lower()}.h> of C",
                help=f"choose another name, say `{name.text}_control`",
            )
        )


def check_reserved(what: str, name: tree.Name, taken: Mapping[str, str], report: Report) -> bool:
    """Whether a name is free of what the language itself uses there; reports it where not."""
    why = taken.get(name.text)
    if why is not None:
        report(
            Diagnostic(
                "FZ211",
                f"`{name.text}` cannot be the name of this {what}",
                name.span,
                label=why,
                help="choose another name",
            )
        )
    return why is None


def unique(names: Iterable[tree.Name], what: str, report: Report, cased: bool = True) -> tuple[tree.Name, ...]:
    """The names without repetitions, which are reported."""
    known = Names(report, cased)
    return tuple(n for n in names if known.declare(what, n))
