"""What is changed of the analyser's C before it is analysed: loops written out, and ghosts that are sums."""

from __future__ import annotations

from pycparser import c_ast, c_generator, c_parser

from fuzzyspec.prove.annotated import STDINT
from fuzzyspec.prove.rounds import written_out
from fuzzyspec.prove.totals import totalled

C = """
void f(uint32_t x, uint8_t n)
{
  uint32_t level[3];
  uint32_t sum = 0U;
  { uint32_t k = 0U; while (k < 3U) { level[k] = 0U; k ++; } }
  if (x > 7U) level[n] += x; else { level[1U] = level[1U] + x; }
  { uint32_t j = 0U; while (j < 3U) { sum = sum + level[j]; j ++; } }
}
"""


def function(text: str) -> c_ast.FuncDef:
    """The only function of a unit."""
    found = c_parser.CParser().parse(STDINT + text).ext[-1]
    assert isinstance(found, c_ast.FuncDef)
    return found


def printed(node: c_ast.FuncDef) -> str:
    """On one line."""
    return " ".join(c_generator.CGenerator().visit(node).split())


def test_a_ghost_grows_with_its_array() -> None:
    """Behind every addition to an element stands one to the ghost, a branch without braces included."""
    node = function(C)
    totalled(node, frozenset())
    text = printed(node)
    assert "level[n] += x; fuzzyc_total_level = fuzzyc_total_level + x;" in text
    assert "level[1U] = level[1U] + x; fuzzyc_total_level = fuzzyc_total_level + x;" in text
    assert text.index("level[k] = 0U") < text.index("fuzzyc_total_level = 0U") < text.index("level[n]")


def test_an_array_that_is_set_otherwise_has_no_ghost() -> None:
    """One other assignment, or its address, or elements that are cut to their width: nothing is said of the sum."""
    for old, new in (
        ("level[n] += x", "level[n] = x"),
        ("level[n] += x", "level[n] = level[1U] + x"),
        ("level[n] += x", "level[n] += level[0U]"),
        ("level[n] += x", "g(level)"),
        ("level[n] += x", "level[n] ++"),
        ("uint32_t level", "uint16_t level"),
        ("k < 3U", "k < 2U"),
        ("level[k] = 0U", "level[k] = 1U"),
    ):
        assert old in C
        node = function(C.replace(old, new, 1))
        totalled(node, frozenset())
        assert "fuzzyc_total" not in printed(node)


def test_a_loop_is_written_out() -> None:
    """Each round has its number for the counter; a loop whose counter changes otherwise, or that jumps, stays."""
    narrow = (
        C.replace("uint32_t j", "uint8_t j")
        .replace("(j < 3U)", "((int)j < 3)")
        .replace("j ++", "j = (uint8_t)((int)j + 1)")
    )
    for text in (C, narrow):
        node = function(text)
        written_out(node, lambda old, new: None)
        text = printed(node)
        assert "level[0U]" in text and "level[2U]" in text and "level[j]" not in text
        assert "while (k < 3U)" in text
    for old, new in (
        ("sum = sum + level[j];", "sum = sum + level[j]; j = j + 1U;"),
        ("j < 3U", "j < n"),
        ("j = 0U", "j = x"),
    ):
        assert old in C
        node = function(C.replace(old, new, 1))
        written_out(node, lambda old, new: None)
        assert "level[j]" in printed(node)
