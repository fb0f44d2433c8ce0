"""FZ1xx: what the parser finds."""

from __future__ import annotations

from textwrap import dedent

from fuzzyspec.diagnostics.code import Code
from fuzzyspec.diagnostics.diagnostic import Severity


def _code(code: str, title: str, page: str, severity: Severity = "error") -> Code:
    return Code(code, title, severity, dedent(page).strip() + "\n")


CODES: tuple[Code, ...] = (
    _code(
        "FZ101",
        "something stands where it cannot",
        """
        The words before this place can only be followed by what the message lists, and something else was
        found.

            if error is then duty is HIGH       # a term is missing after `is`
            input x in (0, 1) { .. }            # a range stands in square brackets

        The compiler goes on behind the place, so the rest of the file is read, and what it still reports is worth
        mending in the same round.
        """,
    ),
    _code(
        "FZ102",
        "a keyword that is not one",
        """
        A word stands where only certain keywords can, and looks like one of them. Keywords are written in small
        letters.

            ouput v in [0, 1] { .. }            # output
            IF x IS LOW THEN v IS HIGH          # if x is LOW then v is HIGH
        """,
    ),
    _code(
        "FZ103",
        "a mark or word is missing",
        """
        With one mark or word put in, the text can be read on; so it was probably left out here.

            input x [0, 1] { .. }               # input x in [0, 1]
            if x is LOW v is HIGH               # if x is LOW then v is HIGH
            danger(eta_t o.gap)                 # danger(eta_t: o.gap)

        Lists of names, arguments, settings and fields have commas between their items; terms in a partition and
        entries of a table have only spaces.
        """,
    ),
    _code(
        "FZ104",
        "a brace is never closed",
        """
        A `{` has no `}` before something that cannot stand in its block, or before the end of the file.

            controller fan {
                input x in [0, 1] { partition LOW HIGH
                output y in [0, 1] { partition LOW HIGH }
            }

        The message points at the innermost block that was open. Where some other block within it is closed at an
        indent that is not its own, that block is pointed at too: the missing brace often belongs there.
        """,
    ),
    _code(
        "FZ105",
        "a parenthesis or bracket is never closed",
        """
        A `(` or `[` has no partner before something that cannot stand inside it.

            let gap = max(0 m, o.distance - (R_robot + o.radius)
            output v = drive.v
        """,
    ),
    _code(
        "FZ106",
        "a bracket closes nothing",
        """
        A `)`, `]` or `}` stands where none is open, often because the one that it was meant for was closed
        before.

            let half = (a + b)) / 2

        A `}` too many inside a block closes it too early: what follows then stands outside. In a file that has
        more closing braces than opening ones, that brace is the one pointed at.
        """,
    ),
    _code(
        "FZ107",
        "a character or sign that the language does not have",
        """
        Specs are written in letters, digits and the marks `{ } ( ) [ ] , : = . .. + - * / < <= > >= == != % ^ #`.
        Quotation marks, semicolons, typographic dashes and the signs of other languages (`&&`, `//`, `:=`) are
        read as what they probably mean, so that the rest of the file can be checked, but have to be mended.

            let near = d ≤ 3 m;                 # d <= 3 m
            input t in [0, 90] °C { .. }        # degC
            // comment                          # comment
        """,
    ),
    _code(
        "FZ108",
        "a number in a form that the language does not have",
        """
        A number has digits and at most one decimal point with digits on both sides. There are no exponents, no
        digit groups and no other bases; quotients such as `1/64` are exact and can be written wherever a number
        can.

            param big   = 1e5                   # 100000
            param small = .5                    # 0.5
            param third = 0.3333333             # better: 1/3
        """,
    ),
    _code(
        "FZ109",
        "a table row lost the colon of its label",
        """
        A row begins with its label and a colon. Without the colon it reads like more entries of the row above;
        the compiler tells by the line break.

            table ddc by eta_d, eta_t {
                     TS TM TB
                DS:  B  B  B
                DM   B  M  M                    # DM:
            }
        """,
    ),
    _code(
        "FZ110",
        "a table's header does not suit its inputs",
        """
        A table by one input has a row for each term and no header; by more inputs, the terms of the last input
        run across in a header, and the others label the rows.

            table u by e { N: S  Z: M  P: B }

            table u by e, rate {
                     DOWN UP
                N:   S    M
                P:   M    B
            }
        """,
    ),
    _code(
        "FZ112",
        "the module has no name",
        """
        A spec begins with `module` and a name. The name becomes the prefix of the generated files and of every C
        name, so it cannot be guessed.

            module nav
        """,
    ),
    _code(
        "FZ113",
        "there is nothing in the file",
        """
        The file is empty or holds comments only. The smallest spec has a module name and one controller:

            module fan

            controller fan {
                input  error in [-10, 10] K { partition N Z P }
                output duty  in [0, 100] %  { partition OFF HALF ON }
                table duty by error { N: OFF  Z: HALF  P: ON }
            }
        """,
    ),
    _code(
        "FZ115",
        "a name that cannot become a C name",
        """
        Names become parts of C names: they begin with a letter and go on with letters, digits and `_`, without
        accents.

            input größe in [0, 1] { .. }        # groesse
        """,
    ),
    _code(
        "FZ116",
        "an item in the wrong kind of block",
        """
        Each item has its place. At the top level: `module`, `unit`, `param`, `controller`, `system`. In a
        controller: `input`, `output`, `table`, `behavior`, `rules`, `infer`, `fires at`. In a system: `param`,
        `input`, `for each`, `let`, `output`. In a variable's braces: `partition`, `singletons`, `term`,
        `otherwise`.

            controller fan {
                let half = 1/2                  # `let` stands in a system
            }

        If the item looks right where it is, a brace above it may have closed its block too early.
        """,
    ),
    _code(
        "FZ120",
        "the file is too large",
        """
        A spec has at most 524,288 characters. Nothing of a larger file is read. Specs are written by people; a
        generated one of this size would not fit a microcontroller either.
        """,
    ),
    _code(
        "FZ121",
        "too many things within one another",
        """
        At most 32 brackets are open at once, and an expression or a condition has at most 100 steps from the
        whole down to its innermost part (`a + b + c` has three). Nothing of the file is read on beyond such a place.

        Give parts of the expression names by `let`, or write a sum over a list as a fold: `sum(o.x for o in
        LIST)`.
        """,
    ),
    _code(
        "FZ122",
        "a number has too many digits",
        """
        A number has at most 40 digits. The finest raw has 16 bits, which is not quite five digits, and a quotient
        such as `1/3` is exact.
        """,
    ),
    _code(
        "FZ123",
        "too many syntax errors",
        """
        After 50 syntax errors the rest of a file is left unread: what would still be reported would hardly be
        about the spec. Mend the first ones and run again. Is it a spec at all?
        """,
        severity="note",
    ),
    _code(
        "FZ130",
        "the file is not UTF-8",
        """
        Specs are read as UTF-8 text. Save the file as UTF-8; all that matters to the compiler is ASCII, so only
        comments can be affected.
        """,
    ),
    _code(
        "FZ131",
        "the file holds NUL bytes",
        """
        A NUL byte never stands in a text: this is probably no spec, or one saved as UTF-16. Save it as UTF-8.
        """,
    ),
)
