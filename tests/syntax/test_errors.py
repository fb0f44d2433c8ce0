"""What is told of typical slips: the place, the words and the way out."""

from __future__ import annotations

import pytest

from fuzzyspec.diagnostics.diagnostic import Diagnostic, Source
from fuzzyspec.syntax import parse, tree


def errors(text: str) -> list[tuple[Diagnostic, str]]:
    """Everything that is found in a module's body, each with the text that it points at."""
    source = Source("spec.fz", "module m\n" + text)
    return [(d, source.text[d.span.start : d.span.end]) for d in parse(source)[1]]


def system(body: str) -> str:
    """A system with this body."""
    return f"system s {{\n{body}\n}}\n"


def controller(body: str) -> str:
    """A controller with this body."""
    return f"controller c {{\n{body}\n}}\n"


def rules(body: str) -> str:
    """A controller with these sentence rules."""
    return controller(f"rules {{\n{body}\n}}")


TERMS = "{ partition A B }"

SLIPS = [
    # (text, code, what the carets stand under, words of the message, words of label or help)
    (rules("if x is then y is B"), "FZ101", "then", "expected a term", ""),
    (rules("if x = A then y is B"), "FZ101", "=", "found `=`", "write `is`"),
    (rules("if x is A y is B"), "FZ103", "y", "expected `then`", "if x is A then y is B"),
    (rules("if x is A and then y is B"), "FZ101", "then", "expected a condition", ""),
    (rules("if x in [A, B] then y is B"), "FZ101", "[", "terms in braces", "write `{` .. `}`"),
    (rules("if x is A then y is B and z is C"), "FZ101", "and", "expected `,`", "separated by commas"),
    (rules("if x is A then y is B with"), "FZ101", "", "expected a weight", ""),
    (rules("x is A then y is B"), "FZ103", "x", "expected `if`", "begins with `if`"),
    (rules("if x is A tehn y is B"), "FZ102", "tehn", "expected", "did you mean `then`?"),
    (rules("if (x is A or x is B then y is B"), "FZ105", "(", "never closed", "needs a `)`"),
    (controller(f"input x in (0, 1) m {TERMS}"), "FZ101", "(", "a range", "both ends belong to it"),
    (controller(f"input x in [0..1] {TERMS}"), "FZ101", "..", "expected `,`", "separated by a comma"),
    (controller(f"input x in [0, 1,5] {TERMS}"), "FZ101", ",", "expected", "`1.5`"),
    (controller(f"input x in [0, 1] m / s {TERMS}"), "FZ101", "/", "expected", "without spaces: `m/s`"),
    (controller("input x in [0, 1] { partition A, B }"), "FZ101", ",", "another term", "no commas"),
    (controller("input x in [0, 1] { partition A at 0 B at 1 }"), "FZ103", "B", "expected `,`", ""),
    (controller("input x in [0, 1] { term a: triangle(0, 1, 2) }"), "FZ101", ":", "expected `=`", "write `=`"),
    (controller("output x in [0, 1] { term a = points(0, 0, 1, 1) }"), "FZ101", "0", "expected `(`", "are pairs"),
    (controller("output x in [0, 1] { term a = triangle((0, 1), (2, 3)) }"), "FZ101", ",", "`)`", "only `points`"),
    (controller(f"input x in [0, 1] raw int16 0-4095 {TERMS}"), "FZ101", "{", "expected `..`", "0..4095"),
    (controller("output y in [0, 1] { partition A B otherwise hold 0 }"), "FZ103", "0", "`initial`", "hold initial"),
    (controller("behavior GO 3 { if x is A then y is B }"), "FZ103", "3", "expected `priority`", ""),
    (controller("table y for x { A: B }"), "FZ102", "for", "expected", "write `by`"),
    (controller("table y by x { A = B }"), "FZ109", "=", "expected `:`", "write `:`"),
    (controller("table y by x, z {\nA B\nS, S: A B\n}"), "FZ101", ",", "expected", "stand in parentheses"),
    (controller("infer { and: min }"), "FZ101", ":", "expected `=`", "write `=`"),
    (controller("fires 1/64"), "FZ103", "1", "expected `at`", "fires at 1/64"),
    (controller("let x = 3"), "FZ116", "let", "does not belong in a controller", "stands in a system"),
    (system("table y by x { A: B }"), "FZ116", "table", "does not belong in a system", "stand in a controller"),
    (system("x = 3"), "FZ103", "x", "expected `let`", "gets its name by `let"),
    (system("let x = a if b > 3"), "FZ103", "", "expected `else`", "a choice reads"),
    (system("let x = if a then b else c"), "FZ101", "if", "expected a value", "a choice reads"),
    (system("let x = a > 3 ? 4 : 5"), "FZ107", "? 4 : 5", "no `? :`", "a choice reads"),
    (system("let x = \nlet y = 3"), "FZ101", "", "expected a value, found the keyword `let`", ""),
    (system("let x = 3 *\noutput y = 3"), "FZ101", "", "expected a value, found the keyword `output`", ""),
    (system("let x = a == 3 and b = 4"), "FZ101", "=", "found `=`", "`==` compares"),
    (system("let x = a.b.c"), "FZ101", ".", "expected", "one dot at most"),
    (system("let x = c(a b, d: 3)"), "FZ103", "a", "expected `:`", "`NAME: VALUE`"),
    (system("let x = c(a = b, d: 3)"), "FZ103", "=", "expected `:`", "`NAME: VALUE`"),
    (system("let x = max(a b)"), "FZ103", "b", "expected `,`", "`,` is missing"),
    (system("let x = max(a, (b + 3)\nlet y = 3"), "FZ105", "(", "never closed", "needs a `)`"),
    (system("let x = a)"), "FZ106", ")", "closes nothing", "no `(` is open"),
    (system("let x = +3"), "FZ101", "+", "expected a value", "no plus sign"),
    (system("let x = a^2"), "FZ107", "^2", "no power operator", "`x * x`"),
    (system("let x = a ** 2"), "FZ107", "**", "no `**`", "`x * x`"),
    (system("let x = a && b"), "FZ107", "&&", "not spelt so", "write `and`"),
    (system("let x = max(o.a for o in l if o.b > 0 otherwise 3)"), "FZ103", "otherwise", "expected `,`", ""),
    (system("let x = max(o.a for o in l, 3)"), "FZ103", "3", "expected `otherwise`", "otherwise 0"),
    (system("let x = max(o.a for each o in l, otherwise 3)"), "FZ101", "each", "expected a name", ""),
    (system("let x = count(o for o in l where o.a > 3)"), "FZ101", "where", "or `if`", "begins with `if`"),
    (system("for o in l { let o.x = 3 }"), "FZ103", "o", "expected `each`", "for each o in LIST"),
    (system("for each o of l { let o.x = 3 }"), "FZ102", "of", "expected `in`", "write `in`"),
    (system("input l(16) { a in [0, 1] }"), "FZ101", "(", "found `(`", "`obstacles[16]`"),
    (system("param T = 2 µs"), "FZ107", "µs", "unit", "write `us`"),
    (system("param T = 9 m/s²"), "FZ107", "²", "raised", "`^2`"),
    ("module again", "FZ116", "module", "at the top level", "once, at the top"),
    ("sytem s { let x = 3 }", "FZ102", "sytem", "expected", "did you mean `system`?"),
    ("controller 3d { }", "FZ101", "3", "the controller's name", "begins with a letter"),
]


@pytest.mark.parametrize(("text", "code", "marked", "message", "remedy"), SLIPS, ids=lambda v: None)
def test_a_slip_is_told_where_it_is(text: str, code: str, marked: str, message: str, remedy: str) -> None:
    """One slip gives one diagnostic that says what was expected, where, and how to mend it."""
    ((found, at),) = errors(text)
    assert (found.code, at) == (code, marked)
    assert message in found.message
    assert remedy in f"{found.label} {found.help}"


@pytest.mark.parametrize("unit", ["K", "m/s", "deg"])
def test_a_unit_is_read_behind_a_mended_bracket(unit: str) -> None:
    """Wrong brackets around a range draw no second finding about its unit."""
    assert len(errors(controller(f"input x in (0, 1) {unit} {TERMS}"))) == 1


def test_all_slips_of_a_file_are_told_at_once() -> None:
    """Slips in every block of a file are all found in one run, and what is right between them is in the tree."""
    text = (
        controller(f"input x [0, 1] {TERMS}\noutput y in [0 1] {TERMS}\ntable y by x {{ A: A  B B\n}}")
        + rules("if x is then y is B\nif x is A then y is A\nIF x is B then y is B")
        + system("param T = 2 s\nlet a = max(T, \nlet b = 3 *\noutput c = b")
    )
    assert len(errors(text)) == 7
    module, _ = parse(Source("spec.fz", "module m\n" + text))
    first, second, third = module.items
    assert isinstance(first, tree.ControllerDecl) and len(first.items) == 3
    assert isinstance(second, tree.ControllerDecl) and isinstance(second.items[0], tree.RulesBlock)
    assert len(second.items[0].rules) == 3
    assert isinstance(third, tree.SystemDecl) and len(third.items) == 4


def test_a_missing_brace_points_at_the_block_that_lost_it() -> None:
    """Where indents tell, the block that was closed by another's brace is pointed at."""
    text = """controller a {
    table y by x {
        A: B
}
controller b {
    input x in [0, 1] { partition A B }
}
"""
    ((found, at),) = errors(text)
    assert found.code == "FZ104" and at == "{"
    source = Source("spec.fz", "module m\n" + text)
    assert source.position(found.span.start)[0] == 2
    assert [source.position(label.span.start)[0] for label in found.labels] == [5, 3, 5]


def test_a_row_without_colon_is_told_at_that_row() -> None:
    """The row that lost its colon is pointed at, not the longer one above, and the table is whole in the tree."""
    text = controller("table y by a, b {\n   S M B\nS: P Q R\nM  P Q R\nB: P Q R\n}")
    ((found, at),) = errors(text)
    assert (found.code, at) == ("FZ109", "M")
    (item,) = parse(Source("spec.fz", "module m\n" + text))[0].items
    assert isinstance(item, tree.ControllerDecl)
    (table,) = item.items
    assert isinstance(table, tree.Table)
    assert [(r.labels[0].text, len(r.entries)) for r in table.rows] == [("S", 3), ("M", 3), ("B", 3)]


def test_the_first_row_may_lose_its_colon_too() -> None:
    """A first row without colon is told apart from the header above it."""
    ((found, at),) = errors(controller("table y by a, b {\n   S M\nS  P Q\nM: P Q\n}"))
    assert (found.code, at) == ("FZ109", "S")


def test_repeated_habits_are_told_once() -> None:
    """A semicolon on every line gives one finding that counts the others."""
    ((found, at),) = errors(system("param a = 1;\nparam b = 2;\nparam c = 3;"))
    assert (found.code, at) == ("FZ107", ";")
    assert found.notes == ("2 more of these in this file",)


@pytest.mark.parametrize("word", ["input", "in", "if", "rules", "full", "at", "let", "module"])
def test_keywords_are_names_where_only_a_name_can_stand(word: str) -> None:
    """A term, an output or a parameter may have a keyword's name."""
    text = f"param {word} = 1\n" + controller(
        f"input x in [0, 1] {{ term {word} = triangle(0, 1, 2) }}\nrules {{ if x is {word} then {word} is {word} }}"
    )
    assert errors(text) == []
