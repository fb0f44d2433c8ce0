"""Constructors of program expressions: each derives the interval of what it builds.

They refuse, with :class:`RangeError`, whatever could leave the 32-bit type it is computed in, so range analysis is
not a
later pass but the only way to make a node. Constants fold.
"""

from __future__ import annotations

from dataclasses import replace

from fuzzyspec.fixed.division import offered
from fuzzyspec.fixed.program import (
    Above,
    Binary,
    BinaryOp,
    Compare,
    CompareOp,
    Const,
    CType,
    Division,
    Expr,
    Greatest,
    Least,
    Local,
    MulHigh,
    Quotient,
    Select,
    Test,
)

LIMITS: dict[CType, tuple[int, int]] = {
    "uint8": (0, 2**8 - 1),
    "int8": (-(2**7), 2**7 - 1),
    "uint16": (0, 2**16 - 1),
    "int16": (-(2**15), 2**15 - 1),
    "uint32": (0, 2**32 - 1),
    "int32": (-(2**31), 2**31 - 1),
}
UINT32_MAX = 2**32 - 1
INT32_MIN, INT32_MAX = -(2**31), 2**31 - 1


class RangeError(ValueError):
    """An intermediate would not fit its 32-bit type."""


def fits(*intervals: tuple[int, int]) -> bool:
    """Whether an operation over these intervals (operands and result) can be computed in one 32-bit type."""
    lo = min(i[0] for i in intervals)
    hi = max(i[1] for i in intervals)
    return hi <= UINT32_MAX if lo >= 0 else lo >= INT32_MIN and hi <= INT32_MAX


def smallest_type(lo: int, hi: int) -> CType:
    """The narrowest C type that holds ``[lo, hi]``; unsigned where it can be."""
    order: tuple[CType, ...] = ("uint8", "uint16", "uint32") if lo >= 0 else ("int8", "int16", "int32")
    for ctype in order:
        if LIMITS[ctype][0] <= lo and hi <= LIMITS[ctype][1]:
            return ctype
    raise RangeError(f"no 32-bit type holds {lo} .. {hi}")


def local(name: str, value: Expr, *, ctype: CType | None = None, lo: int | None = None, hi: int | None = None) -> Local:
    """A local wide enough for ``value`` (or for the wider interval given, where it is set again later)."""
    low = value.lo if lo is None else min(lo, value.lo)
    high = value.hi if hi is None else max(hi, value.hi)
    return Local(name, ctype or smallest_type(low, high), low, high)


def _binary(op: BinaryOp, left: Expr, right: Expr, lo: int, hi: int) -> Expr:
    if not fits((left.lo, left.hi), (right.lo, right.hi), (lo, hi)):
        raise RangeError(
            f"{left.lo} .. {left.hi} {op} {right.lo} .. {right.hi} = {lo} .. {hi} does not fit 32 bits",
        )
    return Binary(op, left, right, lo, hi)


def add(left: Expr, right: Expr) -> Expr:
    """``left + right``."""
    if isinstance(left, Const) and isinstance(right, Const):
        return Const(left.value + right.value)
    if isinstance(left, Const) and left.value == 0:
        return right
    if isinstance(right, Const):
        if right.value == 0:
            return left
        if right.value < 0:
            return sub(left, Const(-right.value))
    return _binary("+", left, right, left.lo + right.lo, left.hi + right.hi)


def sub(left: Expr, right: Expr) -> Expr:
    """``left - right``."""
    if isinstance(right, Const):
        if right.value == 0:
            return left
        if isinstance(left, Const):
            return Const(left.value - right.value)
        if right.value < 0:
            return add(left, Const(-right.value))
    return _binary("-", left, right, left.lo - right.hi, left.hi - right.lo)


def sub_guarded(left: Expr, right: Expr, hi: int) -> Expr:
    """``left - right`` where a test around it, or the caller's proof, holds the result in ``[0, hi]``."""
    if isinstance(right, Const) and right.value == 0:
        return left if isinstance(left, Const) else replace(left, lo=max(left.lo, 0), hi=min(left.hi, hi))
    return _binary("-", left, right, 0, hi)


def add_bounded(left: Expr, right: Expr, hi: int, lo: int = 0) -> Expr:
    """``left + right`` where the caller's proof (a loop invariant) holds the result in ``[lo, hi]``."""
    for one, other in ((left, right), (right, left)):
        if isinstance(one, Const) and one.value == 0:
            return floored(capped(other, hi), lo)
    return _binary("+", left, right, lo, hi)


def capped(expr: Expr, hi: int) -> Expr:
    """The same expression where the caller's proof keeps it at ``hi`` or below."""
    return expr if isinstance(expr, Const) else replace(expr, hi=min(expr.hi, hi))


def floored(expr: Expr, lo: int) -> Expr:
    """The same expression where the caller's proof keeps it at ``lo`` or above."""
    return expr if isinstance(expr, Const) else replace(expr, lo=max(expr.lo, lo))


def mul(left: Expr, right: Expr) -> Expr:
    """``left * right``."""
    if isinstance(left, Const):
        left, right = right, left
    if isinstance(right, Const):
        if isinstance(left, Const):
            return Const(left.value * right.value)
        if right.value == 1:
            return left
        if right.value == 0:
            return Const(0)
    products = [a * b for a in (left.lo, left.hi) for b in (right.lo, right.hi)]
    return _binary("*", left, right, min(products), max(products))


def square(value: Expr) -> Expr:
    """``value * value``, which is never negative."""
    found = mul(value, value)
    if not isinstance(found, Binary):
        return found
    ends = (value.lo * value.lo, value.hi * value.hi)
    return replace(found, lo=0 if value.lo <= 0 <= value.hi else min(ends), hi=max(ends))


def floor_div(left: Expr, right: Expr) -> Expr:
    """``left / right`` of a non-negative by a positive, rounded down."""
    if left.lo < 0 or right.lo < 1:
        raise RangeError("division of a negative, or by what may be 0")
    if isinstance(right, Const):
        if right.value == 1:
            return left
        if right.value & (right.value - 1) == 0:
            return shift_right(left, right.value.bit_length() - 1)
        multiplied = _by_reciprocal(left, right.value)
        if multiplied is not None:
            return multiplied
    return _binary("/", left, right, left.lo // right.hi, left.hi // right.lo)


def _by_reciprocal(left: Expr, divisor: int) -> Expr | None:
    """``left / divisor`` by one product and shifts; None where no multiplier is exact for all values.

    With ``e = m d - 2**s >= 0`` is ``x m / 2**s = x / d + x e / (d 2**s)``, which has the floor of ``x / d`` where
    ``x e < 2**s`` (docs/numbers.md, "Division").
    """
    twos = (divisor & -divisor).bit_length() - 1
    if isinstance(left, Const) or left.hi >> 31:
        return None
    value, odd = shift_right(left, twos), divisor >> twos
    for s in range(1, 32):
        m = -((-1 << s) // odd)
        if value.hi * (m * odd - (1 << s)) >= 1 << s:
            continue
        if value.hi * m <= UINT32_MAX:
            return shift_right(mul(value, Const(m)), s)
        if s >= 16 and m <= 65536:
            return shift_right(mul_high(value, Const(m)), s - 16)
    return None


def shift_right(left: Expr, count: int) -> Expr:
    """``left >> count`` of a non-negative."""
    if left.lo < 0 or not 0 <= count < 32:
        raise RangeError("shift of a negative, or by 32 and more")
    if count == 0:
        return left
    if isinstance(left, Const):
        return Const(left.value >> count)
    return _binary(">>", left, Const(count), left.lo >> count, left.hi >> count)


def shift_left(left: Expr, count: int) -> Expr:
    """``left << count`` of a non-negative."""
    if left.lo < 0 or not 0 <= count < 32:
        raise RangeError("shift of a negative, or by 32 and more")
    if count == 0:
        return left
    if isinstance(left, Const) and left.value << count <= UINT32_MAX:
        return Const(left.value << count)
    return _binary("<<", left, Const(count), left.lo << count, left.hi << count)


def bits_and(left: Expr, right: Expr) -> Expr:
    """Bitwise and of two non-negatives."""
    _unsigned(left, right)
    return Binary("&", left, right, 0, min(left.hi, right.hi))


def bits_or(left: Expr, right: Expr) -> Expr:
    """Bitwise or of two non-negatives."""
    _unsigned(left, right)
    return Binary("|", left, right, max(left.lo, right.lo), _all_ones(left, right))


def bits_xor(left: Expr, right: Expr) -> Expr:
    """Bitwise exclusive or of two non-negatives."""
    _unsigned(left, right)
    return Binary("^", left, right, 0, _all_ones(left, right))


def _all_ones(left: Expr, right: Expr) -> int:
    hi: int = (1 << max(left.hi, right.hi).bit_length()) - 1
    return hi


def _unsigned(left: Expr, right: Expr) -> None:
    if left.lo < 0 or right.lo < 0 or max(left.hi, right.hi) > UINT32_MAX:
        raise RangeError("bits are taken of non-negatives of 32 bits")


def rounded_shift(left: Expr, count: int) -> Expr:
    """Shift right, rounding to nearest, ties up."""
    if count == 0:
        return left
    return shift_right(add(left, Const(1 << (count - 1))), count)


def least(left: Expr, right: Expr) -> Expr:
    """The smaller of two atoms."""
    if left.hi <= right.lo:
        return left
    if right.hi <= left.lo:
        return right
    _atoms(left, right)
    _one_type(left, right)
    return Least(left, right, min(left.lo, right.lo), min(left.hi, right.hi))


def greatest(left: Expr, right: Expr) -> Expr:
    """The larger of two atoms."""
    if left.lo >= right.hi:
        return left
    if right.lo >= left.hi:
        return right
    _atoms(left, right)
    _one_type(left, right)
    return Greatest(left, right, max(left.lo, right.lo), max(left.hi, right.hi))


def above(left: Expr, right: Expr) -> Expr:
    """``max(left - right, 0)``."""
    if left.lo >= right.hi:
        return sub(left, right)
    if left.hi <= right.lo:
        return Const(0)
    _atoms(left, right)
    if not fits((left.lo, left.hi), (right.lo, right.hi), (0, left.hi - right.lo)):
        raise RangeError("a guarded difference does not fit one 32-bit type with its operands")
    return Above(left, right, max(left.lo - right.hi, 0), left.hi - right.lo)


def select(test: Test, then: Expr, other: Expr) -> Expr:
    """``then`` where the test holds, else ``other``; both are computed."""
    if then == other:
        return then
    _one_type(then, other)
    return Select(test, then, other, min(then.lo, other.lo), max(then.hi, other.hi))


def mul_high(left: Expr, right: Expr) -> Expr:
    """The kernel ``floor(left * right / 2**16)``."""
    if left.lo < 0 or right.lo < 0 or right.hi > 65536 or left.hi > UINT32_MAX:
        raise RangeError("mul_high takes a uint32 and at most 65536")
    return MulHigh(left, right, (left.lo * right.lo) >> 16, (left.hi * right.hi) >> 16)


def quotient(num: Expr, den: Expr, division: Division = "loop") -> Expr:
    """The kernel ``floor(num * 2**16 / den)``, 65536 from ``num >= den`` on."""
    if num.lo < 0 or den.lo < 0 or den.hi >= 2**31 or num.hi > UINT32_MAX:
        raise RangeError("the quotient's divisor must stay below 2**31")
    return Quotient(num, den, offered(division, den.hi))


def compare(op: CompareOp, left: Expr, right: Expr) -> Test:
    """A comparison whose two sides fit one 32-bit type."""
    if not fits((left.lo, left.hi), (right.lo, right.hi)):
        raise RangeError("the two sides of a comparison do not fit one 32-bit type")
    return Compare(op, left, right)


def always(test: Test) -> bool | None:
    """What a comparison is for every value of its operands' intervals, or None where it varies."""
    if not isinstance(test, Compare):
        return None
    a, b = test.left, test.right
    match test.op:
        case "<":
            return True if a.hi < b.lo else False if a.lo >= b.hi else None
        case "<=":
            return True if a.hi <= b.lo else False if a.lo > b.hi else None
        case ">":
            return True if a.lo > b.hi else False if a.hi <= b.lo else None
        case ">=":
            return True if a.lo >= b.hi else False if a.hi < b.lo else None
        case "==":
            return True if a.lo == a.hi == b.lo == b.hi else False if a.hi < b.lo or b.hi < a.lo else None
        case "!=":
            return False if a.lo == a.hi == b.lo == b.hi else True if a.hi < b.lo or b.hi < a.lo else None


def _one_type(left: Expr, right: Expr) -> None:
    if not fits((left.lo, left.hi), (right.lo, right.hi)):
        raise RangeError("the two values that are chosen from do not fit one 32-bit type")


def _atoms(left: Expr, right: Expr) -> None:
    if not isinstance(left, Const | Local) or not isinstance(right, Const | Local):
        raise TypeError("min, max and guarded differences take locals and constants: bind the operand first")
