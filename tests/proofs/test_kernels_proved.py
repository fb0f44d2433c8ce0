"""Every kernel of the generated C, as it is printed: for all inputs of its domain it is what it says.

Nothing wraps around on the way. The proofs run along the code. Long division is cut behind every digit, where the
remainder is below the divisor and no more need be known of it; a reciprocal enters by the two inequalities that
``tests/fixed/test_reciprocals.py`` shows by trying every divisor's upper bits (docs/numbers.md, lemma "digit").
"""

from __future__ import annotations

import re
from fractions import Fraction
from functools import cache
from typing import Any, get_args

import pytest
import z3
from pycparser import c_ast

from fuzzyspec.fixed import build
from fuzzyspec.fixed.program import Const, Define, Division, Function, Local, Port, Program, ReadPort, SetOutput
from tests.emit.test_dividers import dividing, files
from tests.fixed.test_reciprocals import LOSS, LOSS_FROM_LINE
from tests.proofs.symbolic import UINT32, Execution, Known, Unproved, kernels

DIVISIONS: tuple[Division, ...] = get_args(Division)


@cache
def text_of(division: Division) -> str:
    """The C of every kernel that divides in one way, over divisors of many intervals."""
    return files(dividing(division)).files["divide.c"].decode()


def domains(text: str) -> dict[str, tuple[str, int, int]]:
    """By kernel what its comment says, and the least and the largest divisor that it allows."""
    found = {}
    comment = r"/\* floor\(num \* 2\^16 / den\)(.*?)\*/\nstatic uint32_t (\w+)\("
    for said, name in re.findall(comment, text, re.DOTALL):
        low = re.search(r"2\^(\d+) <= den", said)
        high = re.search(r"den (<=?) 2\^(\d+)", said)
        assert high is not None
        found[name] = (said, 2 ** int(low[1]) if low else 0, 2 ** int(high[2]) - (high[1] == "<"))
    return found


def start(low: int, high: int) -> tuple[Known, Any, Any]:
    """A numerator below a divisor of the domain."""
    known = Known()
    den = known.number(lambda d: d >= max(low, 1), lambda d: d <= high)
    num = known.number(lambda n: n >= 0, lambda n: n <= den - 1)
    return known, num, den


def exact(known: Known, found: Any, num: Any, den: Any) -> None:
    """What is returned is the floor of ``2^16 num / den``."""
    known.prove(found * den <= 65536 * num, "not too large")
    known.prove(65536 * num <= found * den + den - 1, "not too small")


@pytest.mark.parametrize("division", DIVISIONS)
def test_every_way_to_divide(division: Division) -> None:
    """Each kernel returns the quotient's floor for every numerator below every divisor of its domain."""
    text = text_of(division)
    for name in kernels(text):
        prove(text, name, division)


@pytest.mark.parametrize(
    ("division", "right", "wrong"),
    [
        ("loop", "rest >= den", "rest > den"),
        ("loop", "digits | digit", "digits + 1U"),
        ("loop", "32768U", "16384U"),
        ("rounds", "digits + 4U", "digits + 3U"),
        ("rounds", "rounds = 4U", "rounds = 3U"),
        ("unrolled", "high | 2U", "high | 4U"),
        ("unrolled", "den < 2^31", "den < 2^32"),
        ("hardware", "(rest << 8U) / den", "(rest << 7U) / den"),
        ("hardware", "den < 2^24", "den < 2^25"),
        ("reciprocal", "digits = digits + 1U", "digits = digits"),
        ("reciprocal", "rest >= divisor", "rest > divisor"),
        ("reciprocal", "(rest << 8U) - (digit", "(rest << 7U) - (digit"),
        ("reciprocal", "den <= 2^23", "den <= 2^24"),
        ("newton", "rest = rest << 2U", "rest = rest << 1U"),
        ("newton", "digits << 4U", "digits << 5U"),
    ],
)
def test_what_is_wrong_is_not_proved(division: Division, right: str, wrong: str) -> None:
    """A kernel with a fault planted, or said to hold for more than it does, has no proof."""
    text = text_of(division)
    where = {
        n: re.findall(r"/\*.*?\*/\nstatic uint32_t " + n + r"\(.*?^}", text, re.S | re.M)[0] for n in kernels(text)
    }
    name, whole = next((n, w[w.rindex("/*") :]) for n, w in where.items() if right in w[w.rindex("/*") :])
    with pytest.raises(Unproved):
        prove(whole.replace(right, wrong) + "\n", name, division)


def prove(text: str, name: str, division: Division) -> None:
    """Raises Unproved where a kernel of the C is not shown to return what its comment says."""
    said, low, high = domains(text)[name]
    function = kernels(text)[name]
    if "long division" in said:
        known = _by_long_division(function, low, high)
    elif "by one division" in said or "digits of" in said:
        known, num, den = start(low, high)
        exact(known, Execution(known).call(function, num, den), num, den)
    else:
        known = _by_reciprocal(function, low, high, division)
    known.consistent()


@pytest.mark.parametrize("division", DIVISIONS)
def test_of_a_numerator_that_is_no_smaller(division: Division) -> None:
    """Where the numerator is the divisor or more, and where the divisor is 0, each kernel returns 2^16."""
    for function in kernels(text_of(division)).values():
        known = Known()
        den = known.number(lambda d: d >= 0, lambda d: d <= UINT32)
        num = known.number(lambda n, den=den: n >= den, lambda n: n <= UINT32)
        assert Execution(known).call(function, num, den) == 65536


def _by_long_division(function: c_ast.FuncDef, low: int, high: int) -> Known:
    known, num, den = start(low, high)
    last, bits, taken, steps = num, [], [], []

    def cut(execution: Execution, node: c_ast.Node) -> None:
        nonlocal last
        if isinstance(node, c_ast.If) and getattr(node.cond.left, "name", "") == "rest":
            rest = execution.env["rest"]
            known.prove(rest <= den - 1, "the remainder is below the divisor")
            bits.append(execution.bit)
            taken.append(known.number(lambda t: t == z3.If(execution.bit == 1, den, z3.RealVal(0))))
            known.prove(rest == 2 * last - taken[-1], "a step of the division")
            after = known.number(lambda r: r >= 0, lambda r: r <= den - 1)
            steps.append(after == 2 * last - taken[-1])
            last = execution.env["rest"] = after

    found = Execution(known, cut).call(function, num, den)
    if len(bits) != 16:
        raise Unproved(f"{len(bits)} digits are taken")
    Known().prove(found == z3.Sum([2 ** (15 - k) * bit for k, bit in enumerate(bits)]), "all digits are returned")
    whole = z3.Sum([2 ** (15 - k) * t for k, t in enumerate(taken)])
    Known(steps).prove(65536 * num == whole + last, "digits and remainder make the numerator")
    return known


def _by_reciprocal(function: c_ast.FuncDef, low: int, high: int, division: Division) -> Known:
    loss = {"newton": LOSS_FROM_LINE, "reciprocal": LOSS}[division]
    known, num, den = start(low, high)
    width = high.bit_length() - 1
    ghosts: list[Any] = []
    scaled: list[Any] = []

    def after(execution: Execution, node: c_ast.Node) -> None:
        nonlocal known
        declared = node.name if isinstance(node, c_ast.Decl) else ""
        if declared == "inverse":
            known = execution.known = _normalised(execution, num, den, width, division, loss)
            scaled.extend((execution.env["rest"], execution.env["divisor"]))
            execution.given = {"inverse": execution.env["inverse"]}
        if isinstance(node, c_ast.Assignment) and node.lvalue.name == "rest" and scaled:
            ghosts.append(execution.env["rest"])

    execution = Execution(known, after)
    execution.given = {"guess": 1, "inverse": 1, "top": 1}
    found = execution.call(function, num, den)
    rest, divisor = scaled
    known.prove(found * divisor <= 65536 * rest, "not too large")
    known.prove(65536 * rest <= found * divisor + divisor - 1, "not too small")
    return known


def _normalised(execution: Execution, num: Any, den: Any, width: int, division: Division, loss: Fraction) -> Known:
    """The divisor has been shifted up with its numerator; from here on only their sizes and the reciprocal count."""
    old, env = execution.known, execution.env
    missing = 1 if division == "newton" else 3
    rest, divisor = env["rest"], env["divisor"]
    old.prove(z3.Or([z3.And(divisor == den * 2**k, rest == num * 2**k) for k in range(32)]), "one shift for both")
    old.prove(divisor <= 2**width, "the divisor has its size")
    old.prove(divisor >= 2 ** (width - missing), "the divisor has its size")
    known = Known()
    env["divisor"] = known.number(lambda d: d >= 2 ** (width - missing), lambda d: d <= 2**width)
    env["rest"] = known.number(lambda r: r >= 0, lambda r: r <= env["divisor"] - 1)
    top = known.floor(env["divisor"], 2 ** (width - 16))
    one = 2**32 if division == "reciprocal" else 2**31
    env["inverse"] = known.number(
        lambda r: r >= 0,
        lambda r: r * (top + 1) <= one,
        lambda r: r * top * loss.denominator >= one * (loss.denominator - loss.numerator),
    )
    return known


def test_the_upper_half_of_a_product() -> None:
    """``mul_high`` is the floor of the product over 2^16, for every uint32 and every factor up to 2^16."""
    (function,) = kernels(_multiplying()).values()
    known = Known()
    value = known.number(lambda v: v >= 0, lambda v: v <= UINT32)
    factor = known.number(lambda f: f >= 0, lambda f: f <= 2**16)
    found = Execution(known).call(function, value, factor)
    known.prove(65536 * found <= value * factor, "not too large")
    known.prove(value * factor <= 65536 * found + 65535, "not too small")
    known.consistent()


def _multiplying() -> str:
    """The C of a module that multiplies by 16 fraction bits."""
    value, factor = (Local(name, "uint32", 0, most) for name, most in (("value", UINT32), ("factor", 2**16)))
    body = (
        Define(value, ReadPort("value", "uint32", 0, UINT32), True),
        Define(factor, build.least(Local("given", "uint32", 0, UINT32), Const(2**16)), True),
        SetOutput("high", build.mul_high(value, factor)),
    )
    given = Define(Local("given", "uint32", 0, UINT32), ReadPort("given", "uint32", 0, UINT32), True)
    ports = tuple(Port(name, "uint32", 0, UINT32, None) for name in ("value", "given"))
    outputs = (Port("high", "uint32", 0, UINT32, None),)
    function = Function("f", "controller", ports, outputs, (), (), (), (), (), (given, *body))
    return files(Program("product", (function,))).files["product.c"].decode()
